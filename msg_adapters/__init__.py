# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion of ROS messages to and from core types.

``x_from_msg(msg)`` reads attributes only, so messages decoded by rosbags work as well as those
of rclpy; ``x_to_msg(x, stamp_ns, frame_id)`` needs the installed message packages.
"""
