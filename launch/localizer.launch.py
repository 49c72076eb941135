# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localise a robot on a floorplan: floorplan server, lidar odometry and localizer.

Example: ros2 launch fpnet_ros localizer.launch.py floorplan:=plan.yaml points:=/lidar/points
"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe the three nodes; only the floorplan has no default."""
    defaults = PathJoinSubstitution([FindPackageShare('fpnet_ros'), 'config', 'fpnet.yaml'])
    params_file = LaunchConfiguration('params_file')
    return LaunchDescription(
        [
            DeclareLaunchArgument('floorplan', description='Map YAML or image of the floorplan.'),
            DeclareLaunchArgument(
                'points', default_value='/points', description='Topic of the lidar clouds.'
            ),
            DeclareLaunchArgument(
                'params_file', default_value=defaults, description='Parameters of all nodes.'
            ),
            Node(
                package='fpnet_ros',
                executable='floorplan_server',
                parameters=[params_file, {'floorplan': LaunchConfiguration('floorplan')}],
            ),
            Node(
                package='fpnet_ros',
                executable='odometry',
                parameters=[params_file],
                remappings=[('pointcloud_topic', LaunchConfiguration('points'))],
            ),
            Node(package='fpnet_ros', executable='localizer', parameters=[params_file]),
        ]
    )
