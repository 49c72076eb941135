# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compilation of everything that would delay the first update."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry.voxels import voxel_means
from fpnet_core.localizer.localizer import Localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import FREE, OCCUPIED, GridMap

# Chosen, not measured:
# Two rooms side by side with a door between them; inner sizes in metres.
_ROOM_M = np.array([6.0, 5.0])
_WALL_M, _DOOR_M, _RESOLUTION_M = 0.2, 1.0, 0.1
# Above the sensor; dense, so that walls fill all heights alike: planes are floors and ceilings.
_HEIGHTS_M = np.linspace(-0.8, 1.6, 97)
_LINTEL_M = 1.2
_SPACING_M = 0.05
_SCAN_NS = NS_PER_S


def warm_up(localizer: Localizer) -> None:
    """
    Run every compiled stage once on a toy floorplan; discard the localizer afterwards.

    The first run after an installation fills the compiler's cache, later ones take a fraction of a
    second. A robot that starts to move during that time would lose scans. The cache is valid for
    one path of the package, one processor type and one version of Python and Numba only.
    ``python -m fpnet_core.localizer.warm_up`` fills it without a robot.
    """
    localizer.set_plan(_toy_plan())
    left = _toy_scan()
    voxel_means(left.astype(np.float64), _SPACING_M)  # for odometry in the same process
    right = left * np.array([-1.0, 1.0, 1.0], dtype=np.float32)
    seen_from = np.zeros((2, len(left), 3), dtype=np.float32)
    seen_from[1, :, 0] = _ROOM_M[0] + _WALL_M
    both = np.concatenate([left, right + seen_from[1]])
    for stamp_ns in (_SCAN_NS, 2 * _SCAN_NS):
        localizer.add_scan(both, np.eye(4), stamp_ns, seen_from.reshape(-1, 3))
        localizer.update(stamp_ns)


def _toy_plan() -> GridMap:
    room, wall, door = (
        np.round(np.asarray(metres) / _RESOLUTION_M).astype(int)
        for metres in (_ROOM_M, _WALL_M, _DOOR_M)
    )
    columns, rows = room
    cells = np.full((rows + 2 * wall, 2 * columns + 3 * wall), OCCUPIED, dtype=np.int8)
    cells[wall:-wall, wall : wall + columns] = FREE
    cells[wall:-wall, -wall - columns : -wall] = FREE
    cells[2 * wall : 2 * wall + door, wall + columns : 2 * wall + columns] = FREE
    return GridMap(cells, _RESOLUTION_M)


def _toy_scan() -> NDArray[np.float32]:
    """Return wall points (P, 3) seen from the centre of the left room, also through its door."""
    width, depth = _ROOM_M
    x, y = (np.arange(0.0, length, _SPACING_M) - length / 2 for length in (width, depth))
    outline = np.concatenate(
        [
            np.column_stack([x, np.full_like(x, -depth / 2)]),
            np.column_stack([x, np.full_like(x, depth / 2)]),
            np.column_stack([np.full_like(y, -width / 2), y]),
            np.column_stack([np.full_like(y, width / 2), y]),
        ]
    )
    layers = np.empty((len(_HEIGHTS_M), len(outline), 3), dtype=np.float32)
    layers[..., :2] = outline
    layers[..., 2] = _HEIGHTS_M[:, None]
    points = layers.reshape(-1, 3)
    from_door = np.abs(points[:, 1] + depth / 2 - _WALL_M - _DOOR_M / 2)
    is_doorway = (points[:, 0] >= width / 2) & (from_door <= _DOOR_M / 2)
    is_doorway &= points[:, 2] < _LINTEL_M
    # Through the door the sensor sees the other room's lower wall.
    points[is_doorway, :2] *= depth / 2 / np.abs(points[is_doorway, 1:2])
    return points


if __name__ == '__main__':
    from fpnet_core.config import FpnetConfig
    from fpnet_core.localizer import create_localizer

    warm_up(create_localizer(FpnetConfig()))
