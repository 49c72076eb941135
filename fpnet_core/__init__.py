# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localization of a robot on a floorplan, without ROS and without network access.

This package runs on the robot. Offline users import :mod:`fpnet`.
"""

# Must run before any kernel is compiled.
from fpnet_core import kernel_cache as kernel_cache
