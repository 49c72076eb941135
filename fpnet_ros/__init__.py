# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes around the core; importing this package imports no ROS."""
