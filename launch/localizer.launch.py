# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localise a robot on a floorplan: floorplan server, lidar odometry and localizer.

Example: ros2 launch fpnet_ros localizer.launch.py floorplan:=plan.yaml points:=/lidar/points
Example: ros2 launch fpnet_ros localizer.launch.py floorplan:=plan.yaml scan:=/scan
"""

from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    LogInfo,
    OpaqueFunction,
    Shutdown,
)
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

_ROWS = (
    ('floorplan', None, 'Map YAML or drawing of the floorplan.'),
    ('resolution_m', '', 'Metres per pixel of a drawing; 0: as it says, or estimated.'),
    ('storey', '', 'Of several on one sheet, from 1; 0: the largest.'),
    ('page', '', 'Of a PDF, from 1; 0: the first one.'),
    ('floorplan_frame', '', 'Frame of the drawing; map: its scale is trusted.'),
    ('points', '/points', 'Topic of the lidar clouds.'),
    ('scan', '', 'Topic of LaserScans in place of clouds; several: commas between them.'),
    ('base_frame', '', 'Frame whose pose is wanted; empty: that of the clouds.'),
    ('odometry', 'true', 'Start the lidar odometry; false: another node publishes it.'),
    ('namespace', '', 'Namespace of all nodes and their relative topics.'),
    ('use_sim_time', '', 'Follow /clock.'),
    ('autostart', '', 'Configure and activate without a lifecycle manager.'),
    ('state_file', '', 'Where the state is saved and restored; empty: nowhere.'),
    ('rviz', 'false', 'Show everything in RViz.'),
)


def _arguments():
    config = PathJoinSubstitution([FindPackageShare('fpnet_ros'), 'config', 'fpnet.yaml'])
    rows = (*_ROWS, ('params_file', config, 'Parameters of all nodes.'))
    return [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, default, description in rows
    ]


def _given(context, **kinds):
    """
    Return parameters for those arguments that somebody set: of the others params_file decides.

    The argument of ``frame_id`` is ``floorplan_frame``; the others have their parameter's name.
    """
    names = {name: 'floorplan_frame' if name == 'frame_id' else name for name in kinds}
    given = {
        name: ParameterValue(LaunchConfiguration(names[name]), value_type=kind)
        for name, kind in kinds.items()
        if LaunchConfiguration(names[name]).perform(context)
    }
    return [given] if given else []


def _scan_topics(context):
    words = LaunchConfiguration('scan').perform(context).split(',')
    topics = [word.strip() for word in words if word.strip()]
    return [{'scan_topics': topics}] if topics else []


def _on_exit(event, _):
    """End everything where a node was given something it cannot use; else say who is gone."""
    name = event.process_name
    if event.returncode == 1:
        return [Shutdown(reason=f'{name} cannot start; its last line says why')]
    if event.returncode:
        return [LogInfo(msg=f'{name} has died ({event.returncode}); the others go on')]
    return []


def _nodes(context):
    params_file = LaunchConfiguration('params_file')
    has_odometry = IfCondition(LaunchConfiguration('odometry')).evaluate(context)
    scans = _scan_topics(context)
    nodes = [
        PushRosNamespace(LaunchConfiguration('namespace')),
        Node(
            package='fpnet_ros',
            executable='floorplan_server',
            on_exit=_on_exit,
            parameters=[
                params_file,
                *_given(context, use_sim_time=bool, autostart=bool, floorplan=str),
                *_given(context, resolution_m=float, storey=int, page=int, frame_id=str),
            ],
            output='screen',
        ),
        Node(
            package='fpnet_ros',
            executable='localizer',
            on_exit=_on_exit,
            parameters=[
                params_file,
                *_given(context, use_sim_time=bool, autostart=bool, base_frame=str),
                *_given(context, state_file=str),
                # Our odometry hands on what it registered; another's leaves the scans to us.
                *([] if has_odometry else scans),
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
            parameters=_given(context, use_sim_time=bool),
            condition=IfCondition(LaunchConfiguration('rviz')),
        ),
    ]
    if has_odometry:
        odometry = Node(
            package='fpnet_ros',
            executable='odometry',
            on_exit=_on_exit,
            parameters=[
                params_file,
                *_given(context, use_sim_time=bool, base_frame=str),
                *scans,
            ],
            remappings=[('pointcloud_topic', LaunchConfiguration('points'))],
            output='screen',
        )
        nodes.append(odometry)
    return [GroupAction(nodes)]


def generate_launch_description() -> LaunchDescription:
    """Describe the three nodes; only the floorplan has no default."""
    return LaunchDescription([*_arguments(), OpaqueFunction(function=_nodes)])
