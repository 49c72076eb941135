# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Nodes of a robot, with parameters and remappings, from arguments of the launch file.

Also the Fast DDS profile for large clouds. Imports no ROS.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
import os
import shutil
from typing import Any

from fpnet_core.errors import ConfigError
from fpnet_core.io.topic_names import KISS_FRAME, KISS_ODOMETRY, TF_STATIC_TOPIC, TF_TOPIC

ARGUMENTS = (
    ('floorplan', '', 'Map YAML or drawing of the floorplan.'),
    ('map', '', 'Topic of an OccupancyGrid instead of a floorplan, for example of map_server.'),
    ('site', '', 'Several floors: site.yaml, folder of maps or Open-RMF building.'),
    ('resolution_m', '', 'Metres per pixel of a drawing; 0: as stated, or estimated.'),
    ('storey', '', 'Floor on the sheet, from 1; 0: the largest.'),
    ('page', '', 'Page of a PDF, from 1; 0: the likeliest one.'),
    ('length', '', 'Two points on the drawing [pixels] and their distance [m]: X1,Y1,X2,Y2,M.'),
    ('crop', '', 'Part of the drawing to read [pixels]: LEFT,TOP,RIGHT,BOTTOM.'),
    ('layers', '', 'Layers of a DXF, SVG or PDF with walls, separated by commas.'),
    ('mirrored', '', 'Flip the drawing: it is a mirror image.'),
    ('floorplan_frame', '', 'Frame of the drawing; map: its scale is trusted.'),
    ('points', '/points', 'Topic of the lidar clouds.'),
    ('scan', '', 'Topics of LaserScans instead of clouds, separated by commas.'),
    ('imu', '', 'Topic of an Imu whose gyroscope gives rotations between sweeps.'),
    ('scan_stamp', '', 'Instant of the sweep that stamps give: auto, start, middle or end.'),
    ('base_frame', '', 'Frame to localize; empty: the root of the sensor in /tf_static.'),
    ('odometry', 'kiss', "kiss: KISS-ICP; robot: the robot's own; both: combined."),
    ('odom_topic', '', "Topic of the robot's own odometry; empty: odom_frame in TF."),
    ('odom_frame', '', "Odometry frame in TF; empty: odom_lidar, or odom for the robot's own."),
    ('publish_odom_tf', '', 'Publish our odometry as TF; false if the robot has its own.'),
    ('namespace', '', 'Namespace of all nodes and their relative topics.'),
    ('shared_tf', 'false', 'One TF tree for all robots, outside the namespace.'),
    ('use_sim_time', '', 'Follow /clock.'),
    ('hand_over', '', 'Initialize another localizer (seeder), and leave TF to it.'),
    ('other_pose', '', 'Topic of the pose of that localizer; empty: amcl_pose.'),
    ('other_source', '', 'pose_with_covariance (AMCL), pose, odometry, or tf instead.'),
    ('autostart', '', 'Configure and activate without a lifecycle manager.'),
    ('state_file', '', 'File of the saved state, restored at the start; empty: none.'),
)
"""Name, default and description of every argument. Given: they are the interface."""

_ROBOT_ODOM = 'odom'  # given: REP-105
_TF_IN_NAMESPACE = {TF_TOPIC: 'tf', TF_STATIC_TOPIC: 'tf_static'}


@dataclass(frozen=True)
class NodeSpec:
    """
    A node of this package.

    ``parameters`` holds those that were set; ``remappings`` maps the node's names to the robot's.
    """

    executable: str
    parameters: dict[str, Any] = field(default_factory=dict)
    remappings: dict[str, str] = field(default_factory=dict)


def wired(given: Mapping[str, str]) -> list[NodeSpec]:
    """
    Return the nodes for the given arguments; missing ones have their defaults.

    Raises
    ------
    ConfigError
        If arguments contradict each other, or a value has the wrong type.
    """
    arguments = {name: default for name, default, _ in ARGUMENTS} | dict(given)
    _check(arguments)
    nodes = [_floorplan_server(arguments)] if arguments['floorplan'] else []
    if arguments['odometry'] != 'robot':
        nodes.append(_odometry(arguments))
    if _hands_over(arguments):
        nodes.append(_seeder(arguments))
    return [*nodes, _localizer(arguments)]


def _check(arguments: Mapping[str, str]) -> None:
    choice = arguments['odometry']
    if choice not in ('kiss', 'robot', 'both'):
        raise ConfigError(f'odometry:={choice} is unknown; choose kiss, robot or both')
    plans = [name for name in ('floorplan', 'map', 'site') if arguments[name]]
    if len(plans) != 1:
        found = ' and '.join(plans) or 'none'
        raise ConfigError(f'set one of floorplan:=FILE, map:=TOPIC and site:=FILE; {found} is set')
    if choice == 'robot' and arguments['publish_odom_tf'] == 'true':
        raise ConfigError('publish_odom_tf:=true needs our odometry; choose kiss or both')
    if choice == 'robot' and arguments['imu']:
        raise ConfigError('imu is used by our odometry only; choose odometry:=kiss or both')
    if choice == 'kiss' and arguments['odom_topic']:
        raise ConfigError('odom_topic is used only with odometry:=robot or odometry:=both')
    if (arguments['other_pose'] or arguments['other_source']) and not _hands_over(arguments):
        raise ConfigError('other_pose and other_source are used only with hand_over:=true')
    if _publishes_tf(arguments) and choice == 'both' and not arguments['odom_topic']:
        raise ConfigError(
            "odometry:=both without odom_topic takes the robot's odometry from TF, where "
            'publish_odom_tf:=true would give the base a second parent'
        )


def _hands_over(arguments: Mapping[str, str]) -> bool:
    return bool(arguments['hand_over']) and _boolean('hand_over', arguments['hand_over'])


def _publishes_tf(arguments: Mapping[str, str]) -> bool:
    """Return whether our odometry publishes TF, in which the base has only one parent."""
    return arguments['publish_odom_tf'] == 'true' or (
        not arguments['publish_odom_tf'] and arguments['odometry'] == 'kiss'
    )


def _floorplan_server(arguments: Mapping[str, str]) -> NodeSpec:
    parameters = _typed(arguments, use_sim_time=bool, autostart=bool, floorplan=str)
    parameters |= _typed(arguments, resolution_m=float, storey=int, page=int, mirrored=bool)
    parameters |= _typed(arguments, length=[float], crop=[int], layers=[str])
    if arguments['floorplan_frame']:
        parameters['frame_id'] = arguments['floorplan_frame']
    return NodeSpec('floorplan_server', parameters)


def _odometry(arguments: Mapping[str, str]) -> NodeSpec:
    parameters = _typed(arguments, use_sim_time=bool, base_frame=str) | _scans(arguments)
    remappings = {'pointcloud_topic': arguments['points'], **_tf(arguments)}
    if arguments['imu']:
        parameters['use_imu'] = True
        remappings['imu'] = arguments['imu']
    if not _publishes_tf(arguments):
        parameters['publish_odom_tf'] = False
    elif arguments['odom_frame']:
        parameters['lidar_odom_frame'] = arguments['odom_frame']
    if arguments['odometry'] == 'both':
        if arguments['odom_topic']:
            parameters['robot_odometry'] = 'topic'
            remappings['odom'] = arguments['odom_topic']
        else:
            parameters |= {'robot_odometry': 'tf', 'odom_frame': _robot_odom(arguments)}
    return NodeSpec('odometry', parameters, remappings)


def _localizer(arguments: Mapping[str, str]) -> NodeSpec:
    parameters = _typed(arguments, use_sim_time=bool, autostart=bool, base_frame=str)
    parameters |= _typed(arguments, state_file=str, hand_over=bool, site=str)
    remappings = _tf(arguments)
    if arguments['map']:
        remappings['floorplan'] = arguments['map']
    if arguments['odometry'] == 'robot':
        # Our odometry publishes the registered scans; without it the localizer reads raw ones.
        parameters |= _scans(arguments)
        remappings[KISS_FRAME] = arguments['points']
        if arguments['odom_topic']:
            remappings[KISS_ODOMETRY] = arguments['odom_topic']
            parameters |= _typed(arguments, odom_frame=str)
        else:
            parameters |= {'odometry_source': 'tf', 'odom_frame': _robot_odom(arguments)}
    elif not _publishes_tf(arguments):
        parameters['odom_frame'] = _robot_odom(arguments)
    return NodeSpec('localizer', parameters, remappings)


def _seeder(arguments: Mapping[str, str]) -> NodeSpec:
    parameters = _typed(arguments, use_sim_time=bool, base_frame=str, other_source=str)
    remappings = _tf(arguments)
    if arguments['other_pose']:
        remappings['amcl_pose'] = arguments['other_pose']
    return NodeSpec('seeder', parameters, remappings)


def _robot_odom(arguments: Mapping[str, str]) -> str:
    return arguments['odom_frame'] or _ROBOT_ODOM


def _scans(arguments: Mapping[str, str]) -> dict[str, Any]:
    topics = _value('scan', arguments['scan'], [str])
    parameters: dict[str, Any] = {'scan_topics': topics} if topics else {}
    if arguments['scan_stamp']:
        parameters['scans.stamp'] = arguments['scan_stamp']
    return parameters


def _tf(arguments: Mapping[str, str]) -> dict[str, str]:
    is_own = arguments['namespace'] and not _boolean('shared_tf', arguments['shared_tf'])
    return dict(_TF_IN_NAMESPACE) if is_own else {}


def _typed(arguments: Mapping[str, str], **kinds: Any) -> dict[str, Any]:
    """Return parameters for the arguments that were set; ``[kind]`` stands for a list."""
    return {
        name: _value(name, arguments[name], kind)
        for name, kind in kinds.items()
        if arguments[name]
    }


def _value(name: str, text: str, kind: Any) -> Any:
    if isinstance(kind, list):
        words = (word.strip() for word in text.split(','))
        return [_value(name, word, kind[0]) for word in words if word]
    if kind is bool:
        return _boolean(name, text)
    try:
        return kind(text)
    except ValueError:
        raise ConfigError(f'{name}:={text} is not of type {kind.__name__}') from None


def _boolean(name: str, text: str) -> bool:
    if text.lower() not in ('true', 'false'):
        raise ConfigError(f'{name}:={text} is neither true nor false')
    return text.lower() == 'true'


PROFILE_VARIABLE = 'FASTRTPS_DEFAULT_PROFILES_FILE'
"""Given: environment variable with the path of Fast DDS's profile."""

PROFILE = 'config/fastdds_shm.xml'
"""Path of the profile in the share folder of this package."""

LARGE_CLOUDS = f'{PROFILE} passes clouds through shared memory (docs/ros.md)'
"""Remedy for clouds that are lost in transport. Given."""

_FAST_DDS = 'rmw_fastrtps'  # given: prefix of its RMW implementations
_OTHERS = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTDDS_BUILTIN_TRANSPORTS')  # given
# Segments of five participants; container engines mount 64 MB by default.
_SHARED_MEMORY = '/dev/shm'  # noqa: S108 - given: the kernel's, not a temporary file of ours
_NEEDED_BYTES = 5 * 64 * 2**20  # chosen


def has_shared_memory() -> bool:
    """Return whether shared memory has room for the segments of the profile."""
    try:
        return shutil.disk_usage(_SHARED_MEMORY).free >= _NEEDED_BYTES
    except OSError:
        return False


def said_of_transport(middleware: str, environment: Mapping[str, str] = os.environ) -> str:
    """Return the line that a node with clouds logs at its start; empty if none is needed."""
    is_set = any(environment.get(name) for name in (PROFILE_VARIABLE, *_OTHERS))
    if is_set or not middleware.startswith(_FAST_DDS):
        return ''
    return (
        f'{PROFILE_VARIABLE} is not set: most clouds above 500 kB will be lost; '
        f"{LARGE_CLOUDS}; set it for this node and the lidar's driver"
    )
