# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes around the core; importing this package imports no ROS."""

import os

# Matrix products of an update are small: on a busy robot OpenBLAS's threads would only wait.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
