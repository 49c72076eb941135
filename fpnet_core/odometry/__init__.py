# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lidar odometry with KISS-ICP, optionally guided by the robot's odometry."""

from fpnet_core.odometry.check import Consistency, GuidedOdometry
from fpnet_core.odometry.kiss import KissOdometry

__all__ = ['Consistency', 'GuidedOdometry', 'KissOdometry']
