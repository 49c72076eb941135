# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Launch of a recording that is played into the localizer and shown in RViz.

``fpnet simulate recording`` makes a recording; a bag of a robot works as well.
Example: ros2 launch fpnet_ros demo.launch.py bag:=rec/bag floorplan:=rec/floorplan.yaml
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

_ROWS = (
    ('bag', None, 'Folder of the recording.'),
    ('floorplan', None, 'Map YAML or image of the floorplan.'),
    ('points', '/points', 'Topic of the lidar clouds in the recording.'),
    ('scan', '', 'Topic of LaserScans instead of clouds.'),
    ('rate', '1.0', 'Recorded seconds per second.'),
    ('start_offset_s', '0.0', 'Time to skip at the start.'),
    ('loop', 'false', 'Repeat the recording.'),
    ('rviz', 'true', 'Start RViz.'),
)


def _value(name: str, kind: type) -> ParameterValue:
    return ParameterValue(LaunchConfiguration(name), value_type=kind)


def _replay(context):
    # Scans only: a recording may hold its own odometry and TF.
    scan = LaunchConfiguration('scan').perform(context)
    points = LaunchConfiguration('points').perform(context)
    replay = Node(
        package='fpnet_ros',
        executable='replay',
        parameters=[
            {
                'bag': _value('bag', str),
                'topics': [scan or points],
                'rate': _value('rate', float),
                'start_offset_s': _value('start_offset_s', float),
                'loop': _value('loop', bool),
                'clock': True,
                # The first start after an installation compiles.
                'wait_for_localizer': True,
                'wait_for_subscriber_s': 600.0,
            }
        ],
        output='screen',
    )
    return [replay]


def generate_launch_description() -> LaunchDescription:
    """Return the launch of the localizer in simulated time, and of the replay."""
    localizer = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(
            PathJoinSubstitution([FindPackageShare('fpnet_ros'), 'launch', 'localizer.launch.py'])
        ),
        launch_arguments={
            'floorplan': LaunchConfiguration('floorplan'),
            'points': LaunchConfiguration('points'),
            'scan': LaunchConfiguration('scan'),
            'rviz': LaunchConfiguration('rviz'),
            'use_sim_time': 'true',
        }.items(),
    )
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, default, description in _ROWS
    ]
    return LaunchDescription([*arguments, localizer, OpaqueFunction(function=_replay)])
