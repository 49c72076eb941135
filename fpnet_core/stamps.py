# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Times are whole nanoseconds since the epoch of whatever clock stamped the data, as in ROS 2."""

from __future__ import annotations

NS_PER_S = 1_000_000_000
"""Nanoseconds of a second. Physical: by definition."""
