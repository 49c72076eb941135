# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Find a robot on a floorplan: no ROS, no network, data in and data out.

What a robot runs. People at a desk use :mod:`fpnet`.
"""

# Before any kernel is compiled.
from fpnet_core import kernel_cache as kernel_cache
