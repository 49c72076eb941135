# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rendering of a building's plan as the raster drawing given to a robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
import shapely
from shapely.geometry.polygon import orient

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.raster.pixels import fixed_point
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.sim.buildings.furnishing import furnish_loosely
from fpnet_lab.sim.drawn.styles import CLEAN, DrawingStyle
from fpnet_lab.sim.drawn.symbols import (
    Text,
    dimension_lines,
    door_marks,
    door_sills,
    glazing,
    hatch,
    room_texts,
    windows,
)
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, polygons_from_rings, ring_of

_SUBPIXEL_BITS = 6
"""Numerical: fractional bits of polygon corners passed to the rasterizer."""

DOOR_OVERLAP_M = 0.05
"""Numerical: overlap of a door's opening with the rooms, so that no thin wall remains."""

MIN_WALL_PX = 1.5
"""Numerical: minimum wall thickness; thinner diagonal walls would have gaps."""


MARGIN_M = 1.0
"""Unknown border around a drawing. Chosen."""

LINE_M = 0.03
"""Width of drawn lines; at least one cell. Chosen."""

MIN_DOUBLE_WALL_M = 0.24
THICK_WALL_M = 0.35
"""Minimum thickness of outlined and of thick walls. Chosen."""

# Chosen, not measured:
_HATCH_M = 0.28  # spacing of strokes
_HATCH_PX = 2.0  # minimum spacing of strokes
_LETTER_M = 0.35
_MIN_LETTER_PX = 5.0
_FONT, _FONT_PX = cv2.FONT_HERSHEY_SIMPLEX, 21.0  # given: height of a capital at scale 1
_INK = 255  # given
_BOX_SAMPLES = 11  # numerical


@dataclass(frozen=True, eq=False)
class _Sheet:
    """The target raster (H, W) int8 and its transform from building metres to cells."""

    cells: NDArray[np.int8]
    resolution_m: float
    origin: NDArray[np.float64]
    A: Affine2D

    def px(self, xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert building metres (..., 2) to x, y in cells from the outer corner."""
        return np.asarray((self.A.apply(xy) - self.origin) / self.resolution_m)

    @property
    def line_px(self) -> int:
        """Width of a drawn line in cells."""
        return max(1, round(LINE_M / self.resolution_m))

    def stroke(self, lines: Sequence[NDArray[np.float64]], is_closed: bool = False) -> None:
        """Draw polylines (V, 2) given in building metres."""
        corners = [fixed_point(self.px(line) - 0.5, _SUBPIXEL_BITS) for line in lines]
        ink = self.cells.view(np.uint8)
        cv2.polylines(ink, corners, is_closed, OCCUPIED, self.line_px, shift=_SUBPIXEL_BITS)

    def values(self, xy: NDArray[np.float64]) -> NDArray[np.int8]:
        """Return the cells at building metres (..., 2), clamped to the raster's border."""
        last = np.array(self.cells.shape[::-1]) - 1
        at = np.clip(self.px(xy).astype(int), 0, last)
        return np.asarray(self.cells[at[..., 1], at[..., 0]])


def render_plan(
    plan: BuildingPlan,
    resolution_m: float,
    wall_m: float | None = None,
    T_plan_building: Affine2D | None = None,
    style: DrawingStyle = CLEAN,
) -> GridMap:
    """
    Draw rooms and doors as free, walls as occupied and the outside as unknown.

    Parameters
    ----------
    plan : the storey, frame ``building``
    resolution_m : cell edge [m]
    wall_m : drawn wall thickness, at least 1.5 cells; None uses the plan's thickness
    T_plan_building : affine transform from the building to the drawing
    style : drawing style; its lines and letters are occupied

    Returns
    -------
    GridMap in frame ``plan``, with its origin at the drawing's lower left corner.
    """
    A = T_plan_building if T_plan_building is not None else Affine2D.identity()
    wall = _drawn_wall(wall_m if wall_m is not None else plan.wall_m, resolution_m, style)
    outlines = room_outlines(plan, wall)
    doors = [door_outline(door, wall, plan.wall_m) for door in plan.doors]
    shell = shell_outlines(plan, wall)
    corners = A.apply(np.concatenate(shell))
    origin = corners.min(axis=0) - MARGIN_M
    columns, rows = np.ceil((corners.max(axis=0) + MARGIN_M - origin) / resolution_m).astype(int)
    sheet = _Sheet(np.full((rows, columns), UNKNOWN, np.int8), resolution_m, origin, A)
    fill_polygons(sheet.cells, [sheet.px(ring) for ring in shell], OCCUPIED)
    fill_polygons(sheet.cells, [sheet.px(ring) for ring in outlines + doors], FREE)
    if style != CLEAN:
        _decorate(sheet, plan, style, outlines, wall)
    return GridMap(sheet.cells, resolution_m, SE2.from_xy_yaw(origin[0], origin[1], 0.0), 'plan')


def _drawn_wall(wall_m: float, resolution_m: float, style: DrawingStyle) -> float:
    """Return the thickness of drawn walls [m]."""
    thinnest = MIN_WALL_PX * resolution_m
    if style.walls == 'thin':
        return thinnest
    least = {'double': MIN_DOUBLE_WALL_M, 'thick': THICK_WALL_M}.get(style.walls, thinnest)
    return max(wall_m, least, thinnest)


def _decorate(
    sheet: _Sheet,
    plan: BuildingPlan,
    style: DrawingStyle,
    outlines: list[NDArray[np.float64]],
    wall_m: float,
) -> None:
    """Draw, in place, all elements of a style other than filled walls."""
    rng = np.random.default_rng(style.seed)
    if style.walls == 'double':
        _outline_walls(sheet, outlines if style.hatching else [])
    if style.windows:
        outer_m = max(wall_m, plan.wall_m) + (wall_m - plan.wall_m) / 2.0
        _draw_windows(sheet, outlines, outer_m)
    if style.furniture:
        _draw_furniture(sheet, furnish_loosely(plan, rng).from_above())
    if style.doors != 'gap':
        sheet.stroke(door_marks(plan, wall_m, style.doors == 'arc'))
    sheet.stroke(door_sills(plan, wall_m, style.sills))
    if style.text:
        _write(sheet, room_texts(plan, rng))
    if style.dimensions:
        sheet.stroke(dimension_lines(np.concatenate(outlines), wall_m))
    if style.white_paper:
        sheet.cells[sheet.cells == UNKNOWN] = FREE


def _outline_walls(sheet: _Sheet, hatched: list[NDArray[np.float64]]) -> None:
    """Reduce walls to their outlines, and hatch them if ``hatched (V, 2)`` has room outlines."""
    wall = (sheet.cells == OCCUPIED).astype(np.uint8)
    inner = cv2.erode(wall, np.ones((3, 3), np.uint8), iterations=sheet.line_px) > 0
    sheet.cells[inner] = FREE
    if hatched:
        corners = np.concatenate(hatched)
        around = shapely.box(*(corners.min(axis=0) - MARGIN_M), *(corners.max(axis=0) + MARGIN_M))
        strokes = replace(sheet, cells=np.zeros_like(sheet.cells))
        spacing_m = max(_HATCH_M, _HATCH_PX * sheet.resolution_m)
        strokes.stroke(hatch(around, -np.pi / 4.0, spacing_m))
        sheet.cells[inner & (strokes.cells == OCCUPIED)] = OCCUPIED


def _draw_windows(sheet: _Sheet, outlines: list[NDArray[np.float64]], depth_m: float) -> None:
    """Draw windows in the outer walls of rooms that face empty paper."""
    panes, beyond = windows(outlines, depth_m, 2.0 * sheet.resolution_m)
    panes = panes[(sheet.values(beyond) == UNKNOWN).all(axis=1)]
    if not len(panes):
        return
    fill_polygons(sheet.cells, [sheet.px(pane) for pane in panes], FREE)
    sheet.stroke(list(panes), is_closed=True)
    sheet.stroke(glazing(panes))


def _draw_furniture(sheet: _Sheet, pieces: NDArray[np.float64]) -> None:
    """Draw the outlines (F, 4, 2) of the pieces that are completely on free floor."""
    a, b = np.meshgrid(*2 * [np.linspace(0.0, 1.0, _BOX_SAMPLES)])
    weights = np.stack([(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b]).reshape(4, -1)
    samples = np.einsum('kij,is->ksj', pieces, weights)
    is_inside = (sheet.values(samples) == FREE).all(axis=1)
    sheet.stroke(list(pieces[is_inside]), is_closed=True)


def _write(sheet: _Sheet, texts: list[Text]) -> None:
    """Write texts that fit, horizontally on the displayed page, with the last row on top."""
    page = np.zeros(sheet.cells.shape, np.uint8)
    scale = max(_LETTER_M / sheet.resolution_m, _MIN_LETTER_PX) / _FONT_PX
    for text in texts:
        (width, height), _ = cv2.getTextSize(text.text, _FONT, scale, sheet.line_px)
        if width * sheet.resolution_m < text.width_m:
            x, y = sheet.px(np.array(text.xy))
            corner = round(x - width / 2.0), round(len(page) - y + height / 2.0)
            cv2.putText(page, text.text, corner, _FONT, scale, _INK, sheet.line_px)
    sheet.cells[page[::-1] > _INK // 2] = OCCUPIED


def room_outlines(plan: BuildingPlan, wall_m: float) -> list[NDArray[np.float64]]:
    """
    Return each room's outline (V, 2) for another wall thickness; all rooms are kept.

    Outlines are counter-clockwise.
    """
    polygons = plan.outlines
    grown = shapely.buffer(polygons, (plan.wall_m - wall_m) / 2.0, join_style='mitre')
    kept = np.where(shapely.get_type_id(grown) == shapely.GeometryType.POLYGON, grown, polygons)
    kept = np.where(shapely.is_empty(kept), polygons, kept)
    return [ring_of(polygon) for polygon in map(orient, kept)]


def door_outline(door: PlanDoor, wall_m: float, true_wall_m: float) -> NDArray[np.float64]:
    """
    Return the rectangle (4, 2) of a door's opening in a wall drawn ``wall_m`` thick.

    A full-height opening narrows with its corridor if walls are drawn thicker than they are.
    """
    inset = door.along * (wall_m - true_wall_m) / 2.0 if door.is_open else np.zeros(2)
    normal = door.normal * (max(wall_m, true_wall_m) / 2.0 + DOOR_OVERLAP_M)
    a, b = door.ends[0] + inset, door.ends[1] - inset
    out = normal if not door.reach_m else door.normal * door.reach_m
    return np.stack([a - normal, b - normal, b + out, a + out])


def shell_outlines(plan: BuildingPlan, outer_wall_m: float) -> list[NDArray[np.float64]]:
    """Return the outlines of the rooms grown by their walls, without shafts."""
    grown = shapely.buffer(plan.outlines, max(outer_wall_m, plan.wall_m), join_style='mitre')
    return [ring_of(polygon) for polygon in grown]


def fill_polygons(
    cells: NDArray[np.integer[Any]],
    rings_px: list[NDArray[np.float64]],
    value: int,
    keep_thin: bool = False,
) -> None:
    """
    Set the cells with centres inside any of the rings, in place.

    ``rings_px (V, 2)`` are x, y in cells from the raster's outer corner. The rasterizer also
    sets cells that an outline only touches, hence the inset by half a cell; ``keep_thin`` omits
    the inset, so that small objects like chair legs cover at least one cell.
    """
    rings = list(rings_px)
    if not keep_thin:
        polygons = shapely.buffer(polygons_from_rings(rings_px), -0.5, join_style='mitre')
        parts = shapely.get_parts(polygons).tolist()
        rings = [ring_of(part) for part in parts]
    for ring in rings:
        if len(ring):
            paint_rings(cells, [ring - 0.5], value)


def paint_rings(
    raster: NDArray[np.integer[Any]], rings: Sequence[NDArray[np.float64]], value: int
) -> None:
    """
    Set the cells inside or touched by rings, in place; a ring inside another is a hole.

    ``rings (V, 2)`` are x, y in cells, with integers at cell centres.
    """
    if rings:
        corners = [fixed_point(ring, _SUBPIXEL_BITS) for ring in rings]
        cv2.fillPoly(raster, corners, value, shift=_SUBPIXEL_BITS)
