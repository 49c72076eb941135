# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``nav_msgs/OccupancyGrid``, to and from :class:`GridMap`."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import MapFormatError, OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from msg_adapters.stamps import header_to_msg, stamp_to_msg
from msg_adapters.transforms import matrix_from_pose_msg, matrix_to_pose_msg

# Given: default thresholds of map_server [%]: above is occupied, below is free.
OCCUPIED_PERCENT, FREE_PERCENT = 65, 25
# Numerical: 500 m x 500 m at 0.05 m: no building needs more, but a grid of wrong resolution may.
MAX_CELLS = 100_000_000
# Numerical: a grid tilted by more than this cannot be a floorplan (cosine of 1 deg).
_LEAST_UPRIGHT = 0.99985


def grid_from_msg(msg: Any) -> GridMap:
    """
    Return the grid in its metric frame ``plan``, including the yaw of its origin.

    The caller handles ``msg.header.frame_id``.

    Parameters
    ----------
    msg
        An OccupancyGrid; probabilities become free, occupied or unknown by map_server's default
        thresholds.

    Raises
    ------
    MapFormatError
        If sizes are inconsistent, the grid is empty or far too large, or its resolution or origin
        is unusable.
    """
    info = msg.info
    height, width = int(info.height), int(info.width)
    # The message holds a float32; its shortest decimal is the intended number (0.05).
    resolution = float(str(np.float32(info.resolution)))
    if height * width == 0:
        raise MapFormatError(f'grid is empty: {height} x {width} cells; publish a floorplan')
    if height * width > MAX_CELLS:
        raise MapFormatError(
            f'grid of {height} x {width} cells is too large (at most {MAX_CELLS} cells); '
            'crop it or choose a coarser resolution'
        )
    if len(msg.data) != height * width:
        raise MapFormatError(
            f'grid data has {len(msg.data)} cells, but height {height} x width {width} needs '
            f'{height * width}; fix its publisher'
        )
    if not (np.isfinite(resolution) and resolution > 0.0):
        raise MapFormatError(f'grid resolution must be positive metres per cell, got {resolution}')
    percent = np.frombuffer(msg.data, dtype=np.int8).reshape(height, width)
    return GridMap(_cells_from_percent(percent), resolution, _origin_from_msg(info.origin))


def grid_to_msg(grid: GridMap, stamp_ns: int, frame_id: str) -> Any:
    """Return an OccupancyGrid."""
    from nav_msgs.msg import MapMetaData, OccupancyGrid

    height, width = grid.shape
    info = MapMetaData(
        map_load_time=stamp_to_msg(stamp_ns),
        resolution=grid.resolution,
        width=width,
        height=height,
        origin=matrix_to_pose_msg(grid.T_frame_grid.as_matrix4()),
    )
    return OccupancyGrid(
        header=header_to_msg(stamp_ns, frame_id),
        info=info,
        data=array('b', grid.cells.tobytes()),
    )


def confidence_to_msg(
    grid: GridMap, percent: NDArray[np.int8], stamp_ns: int, frame_id: str
) -> Any:
    """Return an OccupancyGrid of ``percent (H, W)`` on the raster of ``grid``; -1 is unknown."""
    msg = grid_to_msg(grid, stamp_ns, frame_id)
    msg.data = array('b', np.ascontiguousarray(percent).tobytes())
    return msg


def _cells_from_percent(percent: NDArray[np.int8]) -> NDArray[np.int8]:
    """Map occupancy in percent to the three cell values; values out of range are unknown."""
    cells = np.full(percent.shape, UNKNOWN, dtype=np.int8)
    cells[(percent >= 0) & (percent < FREE_PERCENT)] = FREE
    cells[(percent > OCCUPIED_PERCENT) & (percent <= 100)] = OCCUPIED
    return cells


def _origin_from_msg(msg: Any) -> SE2:
    try:
        origin = matrix_from_pose_msg(msg)
    except OdometryError as error:
        raise MapFormatError(f'grid origin: {error}') from None
    if origin[2, 2] < _LEAST_UPRIGHT:
        raise MapFormatError('grid origin is tilted out of the plane; only yaw is supported')
    return SE2.from_matrix4(origin)
