# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Maps, clouds, recordings and trajectories, to and from files.

The names below are imported on first use: a node that only decodes clouds loads neither rosbags
nor Pillow.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fpnet_core.io.bag_writer import BagWriter
    from fpnet_core.io.bags import BagReader
    from fpnet_core.io.clouds import read_cloud
    from fpnet_core.io.maps import read_map, states_scale, write_map
    from fpnet_core.io.outside import outside_as_unknown
    from fpnet_core.io.pointcloud2 import CloudArrays, PointField, decode_points, encode_points
    from fpnet_core.io.posed_scans import PosedScans
    from fpnet_core.io.recordings import open_scans
    from fpnet_core.io.scans import Scan, ScanSource
    from fpnet_core.io.trajectories import (
        Trajectory,
        read_poses,
        read_tum,
        write_covariances,
        write_tum,
    )

__all__ = [
    'BagReader',
    'BagWriter',
    'CloudArrays',
    'PointField',
    'PosedScans',
    'Scan',
    'ScanSource',
    'Trajectory',
    'decode_points',
    'encode_points',
    'open_scans',
    'outside_as_unknown',
    'read_cloud',
    'read_map',
    'read_poses',
    'read_tum',
    'states_scale',
    'write_covariances',
    'write_map',
    'write_tum',
]

_MODULE_OF = {
    'BagReader': 'bags',
    'BagWriter': 'bag_writer',
    'CloudArrays': 'pointcloud2',
    'PointField': 'pointcloud2',
    'PosedScans': 'posed_scans',
    'Scan': 'scans',
    'ScanSource': 'scans',
    'Trajectory': 'trajectories',
    'decode_points': 'pointcloud2',
    'encode_points': 'pointcloud2',
    'open_scans': 'recordings',
    'outside_as_unknown': 'outside',
    'read_cloud': 'clouds',
    'read_map': 'maps',
    'read_poses': 'trajectories',
    'read_tum': 'trajectories',
    'states_scale': 'maps',
    'write_map': 'maps',
    'write_covariances': 'trajectories',
    'write_tum': 'trajectories',
}


def __getattr__(name: str) -> Any:
    """Import the module that defines a public name."""
    if name not in _MODULE_OF:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(f'{__name__}.{_MODULE_OF[name]}'), name)
