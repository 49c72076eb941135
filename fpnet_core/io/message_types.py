# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of ROS message types, and suffixes of bag files."""

POINT_CLOUD = 'sensor_msgs/msg/PointCloud2'
LASER_SCAN = 'sensor_msgs/msg/LaserScan'
LASER_SCANS = (LASER_SCAN, 'sensor_msgs/msg/MultiEchoLaserScan')
SCANS = (POINT_CLOUD, *LASER_SCANS)
IMU = 'sensor_msgs/msg/Imu'
ODOMETRY = 'nav_msgs/msg/Odometry'
POSE = 'geometry_msgs/msg/PoseStamped'
UNCERTAIN_POSE = 'geometry_msgs/msg/PoseWithCovarianceStamped'
GRID = 'nav_msgs/msg/OccupancyGrid'
TRANSFORMS = 'tf2_msgs/msg/TFMessage'
CLOCK = 'rosgraph_msgs/msg/Clock'
NUMBER = 'std_msgs/msg/Float64'
TEXT = 'std_msgs/msg/String'

ROS_1_SUFFIX = '.bag'
BAG_SUFFIXES = ('.db3', '.mcap', ROS_1_SUFFIX)
