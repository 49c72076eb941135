# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The plan as the robot found it: likely differences applied, deformed onto the robot map.

Only walls change: likely new walls are added, and likely missing ones removed. Shut doors and
furniture move and are no fault of a drawing. What was not observed stays as drawn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import Point, segmentize, unary_union
from shapely.geometry.base import BaseGeometry

from fpnet.alignment.aligning import Alignment
from fpnet.exports.segmented_model import areas_of
from fpnet.exports.solids import polygon_of, rings_of, solid_walls
from fpnet_core.differences import DifferenceKind
from fpnet_core.drawings.model import FloorplanModel, ModelWall
from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import SE2
from fpnet_core.raster.morphology import grown, square
from fpnet_core.raster.pixels import corners_xy
from fpnet_core.raster.rays import values_at
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

UNSEEN = -1.0
"""Numerical: value of cells where nothing was observed."""

_EDGE_M = 1.0  # numerical: longest edge of a deformed outline; the deformation varies over 4 m
_MARGIN_CELLS = 2  # numerical: outlines of cells and of walls differ by about one cell


@dataclass(frozen=True, eq=False)
class CorrectedPlan:
    """
    The corrected plan in the robot map's frame ``map``.

    ``wrong (H, W)`` is the probability that the drawing is wrong at a cell of ``grid``, UNSEEN
    where nothing was observed.
    """

    grid: GridMap
    wrong: NDArray[np.float32]

    def __post_init__(self) -> None:
        """Check the shape."""
        freeze_field(self, 'wrong', np.float32, self.grid.shape)


def corrected_plan(aligned: Alignment) -> CorrectedPlan:
    """Return the corrected plan at the resolution of the robot map, on the extent of both maps."""
    found, plan, blank = aligned.differences, aligned.plan.grid, _blank(aligned)
    cells = plan.cells.copy()
    cells[_cells(aligned, DifferenceKind.MISSING)] = FREE
    cells[_cells(aligned, DifferenceKind.WALL)] = OCCUPIED
    wrong = np.where(found.is_seen, found.confidence, np.float32(UNSEEN))
    # Walls thinner than a cell of the robot map must not be lost between its cells.
    cell = blank.resolution * aligned.A_plan_map.scale / plan.resolution
    reach = max(0, math.ceil(0.5 * cell - 0.5))
    cells[grown(cells == OCCUPIED, reach)] = OCCUPIED
    marked = cv2.dilate(found.confidence, square(2 * reach + 1))
    wrong = np.where(marked > 0.0, marked, wrong)
    rc = np.stack(np.meshgrid(*map(np.arange, blank.shape), indexing='ij'), axis=-1)
    at = plan.xy_to_rc(aligned.deformed.drawn_at(blank.rc_to_xy(rc)))
    return CorrectedPlan(
        replace(blank, cells=values_at(cells, at, UNKNOWN)), values_at(wrong, at, UNSEEN)
    )


def corrected_model(aligned: Alignment) -> FloorplanModel:
    """Return walls, doors, windows and rooms of the corrected plan, in metres of the robot map."""
    plan, model = aligned.plan.grid, aligned.model
    margin = _MARGIN_CELLS * plan.resolution
    missing, new = (
        [polygon_of(rings) for rings in areas_of(_cells(aligned, kind), plan)]
        for kind in (DifferenceKind.MISSING, DifferenceKind.WALL)
    )
    gone = unary_union(missing).buffer(margin)
    drawn = unary_union([polygon_of(rings) for rings in solid_walls(model)])
    walls = unary_union([drawn.difference(gone), *new])

    outlines = rings_of(segmentize(walls, _EDGE_M / aligned.metres))
    return replace(
        model,
        walls=tuple(ModelWall(rings) for rings in outlines),
        doors=tuple(each for each in model.doors if not _is_within(each.ends, gone)),
        windows=tuple(each for each in model.windows if not _is_within(each.ends, gone)),
    ).mapped(aligned.deformed.observed_at, 1.0 / aligned.A_plan_map.scale)


def _is_within(ends: Array, area: BaseGeometry) -> bool:
    """Return whether both ends (2, 2) of an opening lie in an area."""
    return bool(all(area.intersects(Point(end)) for end in ends))


def _cells(aligned: Alignment, kind: DifferenceKind) -> Mask:
    """Return the cells of the drawing ``(H, W)`` in likely differences of a kind."""
    found = aligned.differences
    is_of_kind = [False, *(each.kind is kind and each.is_likely for each in found.pieces)]
    return np.asarray(np.array(is_of_kind)[found.piece_of])


def _blank(aligned: Alignment) -> GridMap:
    """Return an unknown grid around both maps, axes as the robot map's frame."""
    plan, robot = aligned.plan.grid, aligned.robot
    places = np.concatenate([aligned.A_plan_map.inv().apply(corners_xy(plan)), corners_xy(robot)])
    low = places.min(axis=0)
    cols, rows = np.ceil((places.max(axis=0) - low) / robot.resolution).astype(int)
    origin = SE2.from_xy_yaw(float(low[0]), float(low[1]), 0.0)
    cells = np.full((rows, cols), UNKNOWN, dtype=np.int8)
    return GridMap(cells, robot.resolution, origin, 'map')
