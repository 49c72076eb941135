# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real nodes run from the lab, for the demo, tests and benchmarks; only this package needs ROS."""
