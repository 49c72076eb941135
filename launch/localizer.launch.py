# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Launch of floorplan server, lidar odometry and localizer.

It ends if one of them cannot start.

Example: ros2 launch fpnet_ros localizer.launch.py floorplan:=plan.yaml points:=/lidar/points
Example: ros2 launch fpnet_ros localizer.launch.py floorplan:=plan.yaml scan:=/scan
"""

import os

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    LogInfo,
    OpaqueFunction,
    SetEnvironmentVariable,
    Shutdown,
)
from launch.conditions import IfCondition
from launch.substitutions import (
    EnvironmentVariable,
    LaunchConfiguration,
    PathJoinSubstitution,
)
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from fpnet_ros.wiring import ARGUMENTS, PROFILE, PROFILE_VARIABLE, has_shared_memory, wired

_RESPAWN_S = 2.0  # chosen: the resources of a dead node are free by then


def _arguments():
    config = PathJoinSubstitution([FindPackageShare('fpnet_ros'), 'config', 'fpnet.yaml'])
    profile = PathJoinSubstitution([FindPackageShare('fpnet_ros'), *PROFILE.split('/')])
    rows = (
        *ARGUMENTS,
        ('rviz', 'false', 'Start RViz.'),
        ('params_file', config, 'Parameters of all nodes.'),
        ('respawn', 'false', 'Restart nodes that have died.'),
        ('log_level', 'info', 'Log level of all nodes: debug, info, warn, error.'),
        (
            'dds_profile',
            EnvironmentVariable(PROFILE_VARIABLE, default_value=profile),
            'Fast DDS profile of all nodes; empty: none. Default: that of the environment.',
        ),
    )
    return [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, default, description in rows
    ]


def _parameters(values):
    # A string that looks like a number or a boolean stays a string.
    typed = {
        name: ParameterValue(value, value_type=str) if isinstance(value, str) else value
        for name, value in values.items()
    }
    return [typed] if typed else []


def _node(spec):
    return Node(
        package='fpnet_ros',
        executable=spec.executable,
        parameters=[LaunchConfiguration('params_file'), *_parameters(spec.parameters)],
        remappings=list(spec.remappings.items()),
        arguments=['--ros-args', '--log-level', LaunchConfiguration('log_level')],
        output='screen',
        respawn=LaunchConfiguration('respawn'),
        respawn_delay=_RESPAWN_S,
        on_exit=_on_exit,
    )


def _on_exit(event, _):
    """Shut down if a node cannot use its input (exit status 1); otherwise log which node died."""
    name = event.process_name
    if event.returncode == 1:
        return [Shutdown(reason=f'{name} cannot start; its last line gives the reason')]
    if event.returncode:
        return [LogInfo(msg=f'{name} has died ({event.returncode}); the other nodes go on')]
    return []


def _rviz(localizer):
    """Return RViz, or a log line if it is not installed, as on most robots."""
    wanted = IfCondition(LaunchConfiguration('rviz'))
    try:
        get_package_prefix('rviz2')
    except PackageNotFoundError:
        return LogInfo(msg='rviz2 is not installed: going on without it', condition=wanted)
    layout = PathJoinSubstitution([FindPackageShare('fpnet_ros'), 'config', 'fpnet.rviz'])
    return Node(
        package='rviz2',
        executable='rviz2',
        arguments=['-d', layout],
        parameters=_parameters(
            {k: v for k, v in localizer.parameters.items() if k == 'use_sim_time'}
        ),
        remappings=[(k, v) for k, v in localizer.remappings.items() if k.startswith('/tf')],
        condition=wanted,
    )


def _transport(context):
    """Return the action that sets the DDS profile, if one is wanted and its memory fits."""
    profile = LaunchConfiguration('dds_profile').perform(context)
    if not profile:
        return []
    if PROFILE_VARIABLE not in os.environ and not has_shared_memory():
        return [LogInfo(msg='too little shared memory for large clouds (docs/ros.md)')]
    return [SetEnvironmentVariable(PROFILE_VARIABLE, profile)]


def _nodes(context):
    given = {name: LaunchConfiguration(name).perform(context) for name, *_ in ARGUMENTS}
    specs = wired(given)
    (localizer,) = [spec for spec in specs if spec.executable == 'localizer']
    namespace = PushRosNamespace(LaunchConfiguration('namespace'))
    return [GroupAction([namespace, *_transport(context), *map(_node, specs), _rviz(localizer)])]


def generate_launch_description() -> LaunchDescription:
    """Return the launch of the nodes; one of ``floorplan``, ``map`` and ``site`` must be set."""
    return LaunchDescription([*_arguments(), OpaqueFunction(function=_nodes)])
