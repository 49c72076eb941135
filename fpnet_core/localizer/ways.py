# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shortest paths of a robot across observed floor, and across free space of a plan beyond it."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from fpnet_core.geometry import Affine2D
from fpnet_core.pose import MapEvidence
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.rays import values_at
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, Submap

Array = NDArray[np.float64]

_REACH_M = 25.0  # numerical: radius of the search
_CELL_M = 0.25  # numerical
_BODY_M = 0.2  # physical: clearance between a robot's centre and walls
_BESIDE_M = 1.0  # physical: largest distance of a robot from passable floor
_LATTICE = 6  # numerical: spacing of the candidate places, in cells


@dataclass(frozen=True, eq=False)
class Ways:
    """
    Shortest paths from the robot to ``N`` cells.

    ``length_m (N,)`` is infinite for unreachable cells; ``before (N,)`` is the preceding cell,
    negative if there is none.
    """

    length_m: Array
    before: NDArray[np.int64]

    def to(self, end: int) -> NDArray[np.int64]:
        """Return the cells of the path from the robot to a cell."""
        way = [end]
        while self.before[way[-1]] >= 0:
            way.append(int(self.before[way[-1]]))
        return np.array(way[::-1])


@dataclass(frozen=True, eq=False)
class WayGrid:
    """
    Passable cells ``(H, W)`` with the lower corner ``low (2,)``, row 0 at the lowest y.

    ``is_seen`` are the cells known to the submap; units are metres of the submap. Cells are
    identified by their flat index.
    """

    is_passable: NDArray[np.bool_]
    is_seen: NDArray[np.bool_]
    low: Array

    def xy(self, cells: NDArray[np.int64]) -> Array:
        """Return the centres (N, 2) of cells (N,)."""
        row, col = np.divmod(cells, self.is_passable.shape[1])
        return self.low + (np.stack([col, row], axis=-1) + 0.5) * _CELL_M

    def ways(self, start_xy: Array) -> Ways:
        """Return paths from the passable cell nearest to ``start_xy (2,)``; none if it is far."""
        passable = self.is_passable.ravel()
        places = np.flatnonzero(passable)
        away = np.linalg.norm(self.xy(places) - start_xy, axis=1)
        if away.min(initial=np.inf) > _BESIDE_M:
            return Ways(np.full(passable.size, np.inf), np.full(passable.size, -1))
        graph = self._links(np.arange(passable.size).reshape(self.is_passable.shape))
        start = int(places[np.argmin(away)])
        length_m, before = dijkstra(graph, False, start, return_predecessors=True)
        return Ways(length_m, before.astype(np.int64))

    def _links(self, number: NDArray[np.int64]) -> csr_array:
        """Return the lengths of straight and diagonal steps between passable cells [m]."""
        steps = [
            (number[:, :-1], number[:, 1:], 1.0),
            (number[:-1], number[1:], 1.0),
            (number[:-1, :-1], number[1:, 1:], math.sqrt(2.0)),
            (number[1:, :-1], number[:-1, 1:], math.sqrt(2.0)),
        ]
        one = np.concatenate([a.ravel() for a, _, _ in steps])
        other = np.concatenate([b.ravel() for _, b, _ in steps])
        metres = np.concatenate([np.full(a.size, _CELL_M * length) for a, _, length in steps])
        passable = self.is_passable.ravel()
        both = passable[one] & passable[other]
        return csr_array((metres[both], (one[both], other[both])), (number.size, number.size))

    def lattice(self, ways: Ways) -> NDArray[np.int64]:
        """Return the reachable cells of a regular lattice."""
        is_on = np.zeros(self.is_passable.shape, np.bool_)
        is_on[_LATTICE // 2 :: _LATTICE, _LATTICE // 2 :: _LATTICE] = True
        return np.flatnonzero(is_on.ravel() & np.isfinite(ways.length_m))

    def straight(self, way: Array) -> Array:
        """Return the farthest point of a path (P, 2) in a straight line from its start, (2,)."""
        steps = np.linspace(0.0, 1.0, round(2.0 * _REACH_M / _CELL_M))[:, None]
        corner = way[0]
        for point in way[1:]:
            rc = ((way[0] + steps * (point - way[0]) - self.low) / _CELL_M - 0.5)[:, ::-1]
            if not values_at(self.is_passable, rc, False).all():
                break
            corner = point
        return np.asarray(corner)


def way_grid_around(
    submap: Submap, robot_xy: Array, drawn: tuple[MapEvidence, Affine2D] | None = None
) -> WayGrid:
    """
    Return the passable ground around a robot at ``robot_xy (2,)``, submap frame.

    ``drawn`` is a floorplan and the placement of the submap on it: its free space counts as
    passable where nothing was observed; None: observed floor only.
    """
    side = round(_REACH_M / _CELL_M)
    low = robot_xy - side * _CELL_M
    steps = (np.arange(2 * side) + 0.5) * _CELL_M
    xy = low + np.stack(np.meshgrid(steps, steps), axis=-1)
    grid = submap.grid
    rc = grid.xy_to_rc(xy)
    seen = values_at(grid.cells, rc, UNKNOWN)
    near_wall = grown(grid.cells == OCCUPIED, round(_BODY_M / grid.resolution))
    is_clear, is_free = ~values_at(near_wall, rc, False), seen == FREE
    if drawn is not None:
        plan, A_plan_submap = drawn
        drawn_rc = A_plan_submap.apply(xy) @ plan.A_rc_xy[:, :2].T + plan.A_rc_xy[:, 2]
        body = np.float32(_BODY_M * A_plan_submap.scale)
        is_drawn = values_at(plan.wall_distance, drawn_rc, 0.0) > body
        is_drawn &= values_at(plan.outside_depth, drawn_rc, np.inf) == 0.0
        is_free |= (seen == UNKNOWN) & is_drawn
    return WayGrid(is_clear & is_free, seen != UNKNOWN, low)
