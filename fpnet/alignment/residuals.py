# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distances of observed walls to drawn walls, in all, by room of the plan, and on a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from fpnet.alignment.deformation import DeformedPlan
from fpnet_core.differences import DifferenceKind, Differences
from fpnet_core.differences.finding import APART_M
from fpnet_core.differences.overlay import FAR_M, metres_to
from fpnet_core.drawings.model import FloorplanModel
from fpnet_core.drawings.model_raster import painted
from fpnet_core.frozen import freeze_field
from fpnet_core.pose.evidence import WALL_REACH_M
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.rays import values_at
from fpnet_core.scoring.deform import PATCH_M
from fpnet_core.types import FREE, OCCUPIED, GridMap

Array = NDArray[np.float64]

OUTSIDE = 'outside of rooms'
"""Name of the entry for observed walls that face no room of the plan."""

_INTO_ROOM_M = 0.3  # chosen: beyond the inexactness of most drawings, within the smallest room
_BESIDE_ROOM_M = 0.5  # chosen: thickness of a wall
_LEAST_M = 1.0  # chosen: less observed wall says nothing of a room
_DIGITS = 3  # numerical: millimetres


@dataclass(frozen=True, eq=False)
class ObservedWalls:
    """
    Samples of the walls of a robot map on the drawing.

    Parameters
    ----------
    xy : (P, 2)
        Position by the transform alone, in the drawing's metres.
    shift : (P, 2)
        Local shift from there to where the wall is drawn [m of the drawing].
    off_m, left_m : (P,)
        True distance to the nearest drawn wall, by the transform alone and after the shift [m].
    room : (P,) int64
        Index of the room that the wall faces in the plan's model; -1 outside of rooms.
    is_furniture : (P,) bool
        Observed, not drawn, and by the differences no wall.
    spacing_m : length of wall that a sample stands for, true metres
    metres : true metres per metre of the drawing
    """

    xy: Array
    shift: Array
    off_m: Array
    left_m: Array
    room: NDArray[np.int64]
    is_furniture: NDArray[np.bool_]
    spacing_m: float
    metres: float

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        count = len(self.xy)
        freeze_field(self, 'xy', np.float64, (count, 2))
        freeze_field(self, 'shift', np.float64, (count, 2))
        freeze_field(self, 'off_m', np.float64, (count,))
        freeze_field(self, 'left_m', np.float64, (count,))
        freeze_field(self, 'room', np.int64, (count,))
        freeze_field(self, 'is_furniture', np.bool_, (count,))

    def of(self, mask: NDArray[np.bool_]) -> dict[str, Any]:
        """
        Return the figures of the samples in ``mask (P,)`` as plain values; None without walls.

        Keys: ``walls_m`` and ``furniture_m`` (lengths); of the walls ``median_m`` and ``p90_m`` of
        the distances by the transform alone, ``deformed_m`` (root mean square of the shifts),
        ``left_median_m`` (median after the shifts) and ``explained`` (share that then lies within
        APART_M of a drawn wall).
        """
        walls = mask & ~self.is_furniture
        length = {
            'walls_m': round(float(walls.sum()) * self.spacing_m, 1),
            'furniture_m': round(float((mask & self.is_furniture).sum()) * self.spacing_m, 1),
        }
        if not walls.any():
            keys = ('median_m', 'p90_m', 'deformed_m', 'left_median_m', 'explained')
            return length | dict.fromkeys(keys)
        off_m, left_m = self.off_m[walls], self.left_m[walls]
        shift_m = self.metres * np.hypot(*self.shift[walls].T)
        values = {
            'median_m': np.median(off_m),
            'p90_m': np.quantile(off_m, 0.9),
            'deformed_m': np.sqrt((shift_m**2).mean()),
            'left_median_m': np.median(left_m),
            'explained': (left_m <= APART_M).mean(),
        }
        return length | {key: round(float(value), _DIGITS) for key, value in values.items()}

    @property
    def whole(self) -> dict[str, Any]:
        """Figures of all samples; see :meth:`of`."""
        return self.of(np.ones(len(self.xy), dtype=np.bool_))

    def by_room(self, model: FloorplanModel) -> list[dict[str, Any]]:
        """
        Return the figures of each room with at least a metre of observed wall, largest first.

        Besides :meth:`of`: ``room`` (index in the model; None outside of rooms), ``name`` (empty
        if the drawing states none) and ``area_m2``.
        """
        found: list[dict[str, Any]] = []
        for index in sorted(range(len(model.rooms)), key=lambda i: -model.rooms[i].area_m2):
            area_m2 = round(model.rooms[index].area_m2 * self.metres**2, 1)
            row: dict[str, Any] = {
                'room': index,
                'name': model.rooms[index].name,
                'area_m2': area_m2,
            }
            found.append(row | self.of(self.room == index))
        row = {'room': None, 'name': OUTSIDE, 'area_m2': None}
        found.append(row | self.of(self.room == -1))
        return [each for each in found if each['walls_m'] >= _LEAST_M]

    def on_grid(self) -> list[dict[str, Any]]:
        """
        Return the displacement of the building against the drawing on a grid of 4 m.

        ``x``, ``y``: middle of a grid square with at least a metre of observed wall; ``dx``,
        ``dy``: from where its walls are drawn to where they were observed, mean. All in metres of
        the drawing's frame. ``walls_m``: length of observed wall.
        """
        edge = PATCH_M / self.metres
        squares, of_wall = np.unique(np.floor(self.xy / edge), axis=0, return_inverse=True)
        found = []
        for number, (x, y) in enumerate((squares + 0.5) * edge):
            mask = (of_wall.ravel() == number) & ~self.is_furniture
            walls_m = float(mask.sum()) * self.spacing_m
            if walls_m >= _LEAST_M:
                dx, dy = -self.shift[mask].mean(axis=0)
                values = {'x': x, 'y': y, 'dx': dx, 'dy': dy, 'walls_m': walls_m}
                found.append({key: round(float(v), _DIGITS) for key, v in values.items()})
        return found


def observed_walls(
    walls_map: Array,
    robot: GridMap,
    plan: GridMap,
    labels: NDArray[np.int32],
    model: FloorplanModel,
    differences: Differences,
    deformed: DeformedPlan,
    metres: float,
    spacing_m: float,
) -> ObservedWalls:
    """
    Return the observed walls with their distances to drawn ones.

    Parameters
    ----------
    walls_map : (P, 2) samples of the robot map's walls, in its metres
    robot, plan : both maps, each in its own metres
    labels : (H, W) rooms of the plan, 0 outside; walls far from them do not count
    model : rooms of the plan, in its metres
    differences : between the plan and the robot map
    deformed : the transform with its local shifts
    metres : true metres per metre of the drawing
    spacing_m : true length of wall per sample
    """
    reach = max(1, round(WALL_REACH_M / (plan.resolution * metres)))
    drawn = (plan.cells == OCCUPIED) & grown(labels > 0, 2 * reach)
    far_m = metres_to(drawn, plan.resolution * metres)
    walls = cKDTree(plan.rc_to_xy(np.argwhere(drawn))) if drawn.any() else None

    def off(points: Array) -> Array:
        """Return distances to drawn walls, of points outside of the drawing, too."""
        found = values_at(far_m, plan.xy_to_rc(points), FAR_M).astype(np.float64)
        outside = found >= FAR_M
        if walls is not None and outside.any():
            found[outside] = metres * walls.query(points[outside])[0]
        return found

    xy, shift = deformed.A_plan_map.apply(walls_map), deformed.shift_at(walls_map)
    rc = plan.xy_to_rc(xy + shift)
    kinds = [False, *(each.kind is DifferenceKind.FURNITURE for each in differences.pieces)]
    return ObservedWalls(
        xy=xy,
        shift=shift,
        off_m=off(xy),
        left_m=off(xy + shift),
        room=_room_faced(walls_map, robot, plan, model, deformed, metres),
        is_furniture=np.array(kinds)[values_at(differences.piece_of, rc, 0)],
        spacing_m=spacing_m,
        metres=metres,
    )


def _room_faced(
    walls_map: Array,
    robot: GridMap,
    plan: GridMap,
    model: FloorplanModel,
    deformed: DeformedPlan,
    metres: float,
) -> NDArray[np.int64]:
    """Return the room of the plan that each wall sample ``(P,)`` faces, where it was seen from."""
    to_free = distance_transform_edt(
        robot.cells != FREE, return_distances=False, return_indices=True
    )
    rc = np.rint(robot.xy_to_rc(walls_map)).astype(np.int64)
    free_xy = robot.rc_to_xy(to_free[:, rc[:, 0], rc[:, 1]].T)
    away = free_xy - walls_map
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)
    into_m = _INTO_ROOM_M / metres / deformed.A_plan_map.scale
    rooms = _rooms_of_cells(plan, model, metres)
    at = plan.xy_to_rc(deformed.drawn_at(free_xy + into_m * away))
    return values_at(rooms, at, 0).astype(np.int64) - 1


def _rooms_of_cells(plan: GridMap, model: FloorplanModel, metres: float) -> NDArray[np.int32]:
    """Return the number of each cell's room ``(H, W)``, from 1, also just outside; else 0."""
    local = model.moved(plan.T_frame_grid.inv().matrix[:2])
    order = sorted(range(len(local.rooms)), key=lambda index: -local.rooms[index].area_m2)
    areas = painted([local.rooms[i].rings for i in order], plan.resolution, plan.shape)
    numbers = np.array([0, *(index + 1 for index in order)], np.int32)[areas]
    if not numbers.any():
        return numbers
    away, (rows, cols) = distance_transform_edt(numbers == 0, return_indices=True)
    is_near = away * plan.resolution * metres <= _BESIDE_ROOM_M
    return np.where(is_near, numbers[rows, cols], 0).astype(np.int32)
