# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localise a robot on a floorplan: floorplan server, lidar odometry and localizer.

Example: ros2 launch fpnet_ros localizer.launch.py floorplan:=plan.yaml points:=/lidar/points
"""

from launch.actions import DeclareLaunchArgument, GroupAction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def _arguments() -> list[DeclareLaunchArgument]:
    share = FindPackageShare('fpnet_ros')
    rows = (
        ('floorplan', None, 'Map YAML or drawing of the floorplan.'),
        ('resolution_m', '0.0', 'Metres per pixel of a drawing; 0: as it says, or estimated.'),
        ('storey', '0', 'Of several on one sheet, from 1; 0: the largest.'),
        ('page', '0', 'Of a PDF, from 1; 0: the first one.'),
        ('floorplan_frame', 'floorplan', 'Frame of the drawing; map: its scale is trusted.'),
        ('points', '/points', 'Topic of the lidar clouds.'),
        ('base_frame', '', 'Frame whose pose is wanted; empty: that of the clouds.'),
        ('odometry', 'true', 'Start the lidar odometry; false: another node publishes it.'),
        ('namespace', '', 'Namespace of all nodes and their relative topics.'),
        ('use_sim_time', 'false', 'Follow /clock.'),
        ('autostart', 'true', 'Configure and activate without a lifecycle manager.'),
        ('state_file', '', 'Where the state is saved and restored; empty: nowhere.'),
        ('rviz', 'false', 'Show everything in RViz.'),
        (
            'params_file',
            PathJoinSubstitution([share, 'config', 'fpnet.yaml']),
            'Parameters of all nodes.',
        ),
    )
    return [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, default, description in rows
    ]


def _value(name: str, kind: type) -> ParameterValue:
    return ParameterValue(LaunchConfiguration(name), value_type=kind)


def generate_launch_description() -> LaunchDescription:
    """Describe the three nodes; only the floorplan has no default."""
    params_file = LaunchConfiguration('params_file')
    sim_time = {'use_sim_time': _value('use_sim_time', bool)}
    autostart = {'autostart': _value('autostart', bool)}
    base = {'base_frame': _value('base_frame', str)}
    nodes = [
        PushRosNamespace(LaunchConfiguration('namespace')),
        Node(
            package='fpnet_ros',
            executable='floorplan_server',
            parameters=[
                params_file,
                sim_time,
                autostart,
                {
                    'floorplan': _value('floorplan', str),
                    'resolution_m': _value('resolution_m', float),
                    'storey': _value('storey', int),
                    'page': _value('page', int),
                    'frame_id': _value('floorplan_frame', str),
                },
            ],
            output='screen',
        ),
        Node(
            package='fpnet_ros',
            executable='odometry',
            parameters=[params_file, sim_time, base],
            remappings=[('pointcloud_topic', LaunchConfiguration('points'))],
            condition=IfCondition(LaunchConfiguration('odometry')),
            output='screen',
        ),
        Node(
            package='fpnet_ros',
            executable='localizer',
            parameters=[
                params_file,
                sim_time,
                autostart,
                base,
                {'state_file': _value('state_file', str)},
            ],
            output='screen',
        ),
        Node(
            package='rviz2',
            executable='rviz2',
            arguments=[
                '-d',
                PathJoinSubstitution([FindPackageShare('fpnet_ros'), 'config', 'fpnet.rviz']),
            ],
            parameters=[sim_time],
            condition=IfCondition(LaunchConfiguration('rviz')),
        ),
    ]
    return LaunchDescription([*_arguments(), GroupAction(nodes)])
