# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floorplan localization core: no ROS, no network, data in and data out."""

# Before any kernel is compiled.
from fpnet_core import kernel_cache as kernel_cache
