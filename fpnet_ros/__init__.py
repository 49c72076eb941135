# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes around the core; importing this package imports no ROS."""

import os

# The products of a tick are small: OpenBLAS's threads would wait for each other on a busy robot.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
