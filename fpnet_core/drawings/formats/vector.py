# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion of a vector page to a drawing: presumed walls, rendered at a suitable resolution.

Texts, doors, hatches, dashed lines and layers of furniture are not rendered; all lines and texts
are kept beside the pixels for dimensions and scale bars.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.door_elements import drawn_model
from fpnet_core.drawings.formats.door_strokes import DoorStrokes, find_door_strokes
from fpnet_core.drawings.formats.doors import Doors, find_doors
from fpnet_core.drawings.formats.hatching import find_hatching
from fpnet_core.drawings.formats.layer_choice import choose_paths, is_seen
from fpnet_core.drawings.formats.layers import LayerRole, layer_role
from fpnet_core.drawings.formats.pages import (
    Array,
    Box,
    Canvas,
    OutlinePieces,
    UnitKind,
    VectorPage,
    composed,
    outline_pieces,
    transformed,
)
from fpnet_core.drawings.formats.painting import paint
from fpnet_core.drawings.formats.units import DrawingUnit, resolve_unit
from fpnet_core.drawings.model_raster import WALL_M
from fpnet_core.drawings.types import (
    BUILDING_M,
    Drawing,
    DrawingScale,
    Label,
    ReadOptions,
    ScaleSource,
    Strokes,
)
from fpnet_core.errors import MapFormatError
from fpnet_core.raster.pixels import PIXEL_BITS, fixed_point

PIXEL_M = WALL_M / 4.0
"""Numerical: edge of a pixel [m] of a drawing of known size; a partition is four pixels thick."""
LONG_SIDE_PX = 3_000
"""Long side of a drawing of unknown size [pixels], about that of a floor of 100 m. Chosen."""

_MAX_SIDE_PX = 10_000  # numerical
_MIN_SIDE_PX = 400  # numerical
# Chosen, not measured:
_MARGIN = 0.06  # of the long side: white margin
_CORE = (0.01, 0.99)  # quantiles of line length that bound the core of the drawing
_REACH = 0.6  # of the core's size: reach of the drawing on either side, strays beyond
_SYMBOL_SHARE = 0.5  # of a path's length in a door or hatch, from which all of it is one
_SHEET_SHARE = 0.85  # of the sheet's width and height, from which an area may be the paper
_RECTANGLE = 0.95  # of the bounding box of an area, from which it is a rectangle
_UNIT_ERROR = 0.01  # relative, between drawings in true units and buildings as built
_SOME_DOORS = 3  # from which the drawing certainly shows a building
_PAPER = (255, 255, 255)
_FEWEST_LINES = 4
_FACE_M = 0.06  # physical: distance of a wall's line beyond a door's on either side
_LEAST_DOMINANT = 0.2  # of the lines' length; evenly spread lines have 0.07 within 6 degrees


def drawing_of(page: VectorPage, name: str, kind: str, options: ReadOptions) -> Drawing:
    """
    Convert a page to a drawing.

    Raises
    ------
    MapFormatError
        If nothing is drawn on it, or it lacks the layers in ``options``.
    """
    pieces = outline_pieces(page)
    if not (is_seen(page)[pieces.path].any() or page.is_scan or page.pictures):
        raise MapFormatError(
            f'{name} has no lines, areas or pictures to read: expected a floorplan; export the '
            'sheet again with its layers switched on'
        )
    is_hatch = find_hatching(pieces, _styles(page), _size(pieces, page))
    choice = choose_paths(page, pieces, is_hatch, options)
    is_line = choice.is_path[pieces.path]
    unit = _unit(page, pieces, is_line)
    page = replace(page, unit_m=unit.length_m)
    doors = find_doors(pieces, unit.length_m, _size(pieces, page))
    is_symbol = doors.is_door | is_hatch
    is_line = is_line & ~is_symbol
    is_path = choice.is_path & ~_symbols(pieces, is_symbol, len(page.width))
    is_line &= is_path[pieces.path]
    others = _other_doors(page, pieces, doors, is_line)
    canvas, notes = _canvas(page, pieces, is_line, is_path)
    pixels = _painted(page, pieces, canvas, is_path, is_line)
    _open(pixels, others, canvas, page.unit_m)
    return Drawing(
        pixels=pixels,
        name=name,
        format=kind,
        strokes=_strokes(page, pieces, canvas),
        labels=_labels(page, canvas),
        scale=_scale(unit, canvas),
        A_pixel_image=composed(canvas.A_pixel_page, page.A_page_file),
        paper_m=_times(page.paper_m, canvas),
        door_px=tuple(float(w) for w in doors.width * canvas.pixels_per_unit),
        notes=(*page.notes, *(() if page.model else choice.notes), *unit.notes, *notes),
        doubts=_doubts(page, unit, pieces[is_line], len(doors.width)),
        model=page.model or drawn_model(page, doors, others),
    )


def _other_doors(
    page: VectorPage, pieces: OutlinePieces, doors: Doors, is_line: NDArray[np.bool_]
) -> DoorStrokes:
    """Return the doors without a leaf on layers of doors."""
    is_named = np.array([layer_role(layer) is LayerRole.DOOR for layer in page.layers])
    is_own = (is_named[page.layer] & is_seen(page))[pieces.path] & ~doors.is_door
    found = find_door_strokes(pieces[is_own], pieces[is_line & ~is_own], page.unit_m)
    middle = found.ends.mean(axis=1)
    drawn = 0.5 * (doors.hinge + doors.shut)
    is_new = np.array([
        not (np.hypot(*(drawn - at).T) < doors.width).any() for at in middle
    ], dtype=np.bool_)  # fmt: skip
    return DoorStrokes(found.ends[is_new], found.depth[is_new])


def _open(
    pixels: NDArray[np.uint8], doors: DoorStrokes, canvas: Canvas, unit_m: float | None
) -> None:
    """Erase lines that cross doors."""
    if unit_m is not None:
        for corners in transformed(doors.corners(_FACE_M / unit_m), canvas.A_pixel_page):
            cv2.fillPoly(pixels, [fixed_point(corners)], _PAPER, cv2.LINE_8, PIXEL_BITS)


def _doubts(
    page: VectorPage, unit: DrawingUnit, lines: OutlinePieces, doors: int
) -> tuple[str, ...]:
    """Return warnings that a page is no floorplan, but e.g. a machine part, a mesh or a sketch."""
    doubts = []
    if page.is_scan or page.pictures or page.model or doors >= _SOME_DOORS:
        return ()
    if len(lines.ends) < _FEWEST_LINES:
        doubts.append(f'only {len(lines.ends)} lines are drawn')
    elif _dominant_share(lines) < _LEAST_DOMINANT:
        doubts.append('its lines run in all directions, unlike walls')
    if unit.stated_m is not None and unit.length_m is None and len(lines.ends):
        size_m = _size(lines, page) * unit.stated_m
        if not BUILDING_M[0] < size_m < BUILDING_M[1]:
            doubts.append(f'it is {size_m:.3g} m long in its stated unit: implausible')
    return tuple(doubts)


def _dominant_share(lines: OutlinePieces) -> float:
    """Return the share of line length along the two main orthogonal directions."""
    dx, dy = (lines.ends[:, 1] - lines.ends[:, 0]).T
    angle = np.mod(np.degrees(np.arctan2(dy, dx)), 90.0)
    counts = np.bincount((angle / 2.0).astype(int) % 45, lines.length, 45)
    around = counts + np.roll(counts, 1) + np.roll(counts, -1)
    return float(around.max() / counts.sum())


def _painted(
    page: VectorPage,
    pieces: OutlinePieces,
    canvas: Canvas,
    is_path: NDArray[np.bool_],
    is_line: NDArray[np.bool_],
) -> NDArray[np.uint8]:
    """Return the pixels; of paths with both doors and walls only the doors are dropped."""
    if page.renderer is None:
        return paint(page, pieces, canvas, is_path, is_line)
    if page.is_scan:
        return page.renderer(np.ones_like(is_path), canvas)
    is_mixed = np.bincount(pieces.path, is_path[pieces.path] & ~is_line, len(is_path)) > 0
    is_mixed &= page.fill[:, 3] == 0
    image = page.renderer(is_path & ~is_mixed, canvas)
    is_left = is_line & is_mixed[pieces.path]
    return paint(page, pieces, canvas, np.zeros_like(is_path), is_left, image)


def _unit(page: VectorPage, pieces: OutlinePieces, is_wall: NDArray[np.bool_]) -> DrawingUnit:
    match page.unit_kind:
        case UnitKind.TRUE:
            return DrawingUnit(page.unit_m, 'stated by the file')
        case UnitKind.CLAIMED if is_wall.any():
            walls = pieces[is_wall]
            size = _size(walls, page)
            return resolve_unit(pieces, walls, page.unit_m, size)
    return DrawingUnit(None)


def _scale(unit: DrawingUnit, canvas: Canvas) -> DrawingScale | None:
    if unit.length_m is None:
        return None
    pixel_m = unit.length_m / canvas.pixels_per_unit
    low_m, high_m = (1.0 - _UNIT_ERROR) * pixel_m, (1.0 + _UNIT_ERROR) * pixel_m
    return DrawingScale(pixel_m, low_m, high_m, ScaleSource.UNITS, unit.why)


def _styles(page: VectorPage) -> NDArray[np.int64]:
    """Return a style index for each path's outline: its colour, width and layer."""
    style = np.column_stack([page.stroke, page.width.round(6), page.layer])
    return np.unique(style, axis=0, return_inverse=True)[1].reshape(-1)


def _symbols(pieces: OutlinePieces, is_symbol: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """Return the mask of paths that mostly draw a door or hatch: a leaf's edges, a sector."""
    length = np.bincount(pieces.path, pieces.length, count)
    of_symbols = np.bincount(pieces.path, pieces.length * is_symbol, count)
    symbols: NDArray[np.bool_] = of_symbols > _SYMBOL_SHARE * length
    return symbols


def _size(pieces: OutlinePieces, page: VectorPage) -> float:
    """Return the long side of the drawing in its units."""
    box = content_box(pieces.ends.mean(axis=1), pieces.length) if len(pieces.ends) else page.box
    return max(box[2] - box[0], box[3] - box[1]) if box is not None else 1.0


def content_box(points: Array, weights: Array) -> Box:
    """
    Return the box of ``points (N, 2)``, without those far from most of the weight.

    CAD files often contain stray entities far from the building.
    """
    low, high = np.empty(2), np.empty(2)
    inside = np.ones(len(points), dtype=np.bool_)
    for axis in range(2):
        order = np.argsort(points[:, axis])
        share = np.cumsum(weights[order])
        at = np.searchsorted(share, np.multiply(_CORE, share[-1]))
        core = points[order[np.minimum(at, len(order) - 1)], axis]
        reach = _REACH * (core[1] - core[0])
        inside &= (points[:, axis] >= core[0] - reach) & (points[:, axis] <= core[1] + reach)
    kept = points[inside] if inside.any() else points
    low, high = kept.min(axis=0), kept.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _canvas(
    page: VectorPage, pieces: OutlinePieces, is_line: NDArray[np.bool_], is_area: NDArray[np.bool_]
) -> tuple[Canvas, list[str]]:
    """Return the canvas around the painted part of a page with a margin, and notes."""
    box, notes = _painted_box(page, pieces, is_line, is_area)
    width, height = box[2] - box[0], box[3] - box[1]
    long_side = max(width, height)
    pixel = long_side / LONG_SIDE_PX
    if page.unit_m is not None:
        pixel = min(max(PIXEL_M / page.unit_m, long_side / _MAX_SIDE_PX), long_side / _MIN_SIDE_PX)
    margin = _MARGIN * long_side
    x0, y0 = box[0] - margin, box[1] - margin
    shape = tuple(max(int(np.ceil((side + 2 * margin) / pixel)), 1) for side in (height, width))
    scale, y_top = 1.0 / pixel, box[3] + margin
    A = np.array([[scale, 0.0, -x0 * scale], [0.0, scale, -y0 * scale]])
    if page.is_y_up:
        A[1] = [0.0, -scale, y_top * scale]
    # Integers are pixel centres, and renderers place pages at whole pixels.
    A[:, 2] = np.rint(A[:, 2]) - 0.5
    return Canvas(A, (shape[0], shape[1])), notes


def _painted_box(
    page: VectorPage, pieces: OutlinePieces, is_line: NDArray[np.bool_], is_area: NDArray[np.bool_]
) -> tuple[Box, list[str]]:
    if (page.is_scan or page.pictures) and page.box is not None:
        return page.box, []
    is_painted = is_line & (page.stroke[pieces.path, 3] > 0)
    is_painted |= is_area[pieces.path] & (page.fill[pieces.path, 3] > 0)
    is_painted &= (is_seen(page) & ~_is_paper(page))[pieces.path]
    if not is_painted.any():
        is_painted[:] = True
    ends, length = pieces.ends[is_painted], pieces.length[is_painted]
    points, weights = ends.reshape(-1, 2), np.repeat(length, 2)
    if page.box is not None:
        points = np.clip(points, page.box[:2], page.box[2:])
        low, high = points.min(axis=0), points.max(axis=0)
        box = (*low.tolist(), *high.tolist())
        return (box if (high > low).any() else page.box), []
    box = content_box(points, weights)
    away = ((points < box[:2]) | (points > box[2:])).any(axis=1)
    notes = (
        [f'{away.sum() // 2 + 1} lines far from the building are left out'] if (away.any()) else []
    )
    if box[2] == box[0] and box[3] == box[1]:
        box = (box[0] - 1.0, box[1] - 1.0, box[2] + 1.0, box[3] + 1.0)
    return box, notes


def _is_paper(page: VectorPage) -> NDArray[np.bool_]:
    """
    Return the mask of the sheet's background: rectangles of its size without an outline.

    Filled walls may reach around the sheet as well, but have rooms cut out of them.
    """
    if page.box is None or not len(page.path):
        return np.zeros(len(page.width), dtype=np.bool_)
    starts = page.ring_start[:-1]
    low, high = np.minimum.reduceat(page.points, starts), np.maximum.reduceat(page.points, starts)
    sheet = np.subtract(page.box[2:], page.box[:2])
    is_large = ((high - low) > _SHEET_SHARE * sheet).all(axis=1)
    is_whole = _ring_areas(page) > _RECTANGLE * (high - low).prod(axis=1)
    background = np.bincount(page.path, is_large & is_whole, len(page.width)) > 0
    is_alone = np.bincount(page.path, minlength=len(page.width)) == 1
    is_paper: NDArray[np.bool_] = background & is_alone & (page.stroke[:, 3] == 0)
    return is_paper


def _ring_areas(page: VectorPage) -> NDArray[np.float64]:
    """Return the area of each ring."""
    count = np.diff(page.ring_start)
    following = np.arange(1, len(page.points) + 1)
    following[page.ring_start[1:] - 1] = page.ring_start[:-1]
    (x, y), (next_x, next_y) = page.points.T, page.points[following].T
    twice = np.add.reduceat(x * next_y - next_x * y, page.ring_start[:-1])
    return np.where(count > 2, np.abs(twice) / 2.0, 0.0)


def _strokes(page: VectorPage, pieces: OutlinePieces, canvas: Canvas) -> Strokes:
    colour = np.where(page.stroke[:, 3:] > 0, page.stroke, page.fill)[:, :3]
    return Strokes(
        ends=transformed(pieces.ends, canvas.A_pixel_page),
        width=(page.width * canvas.pixels_per_unit)[pieces.path],
        colour=colour[pieces.path],
        path=pieces.path,
        is_curve=pieces.is_curve,
        layer=page.layer[pieces.path],
        layers=page.layers,
    )


def _labels(page: VectorPage, canvas: Canvas) -> tuple[Label, ...]:
    placed = []
    for label in page.labels:
        corners = transformed(np.reshape(label.box, (2, 2)), canvas.A_pixel_page)
        low, high = corners.min(axis=0), corners.max(axis=0)
        box = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        placed.append(replace(label, box=box))
    return tuple(placed)


def _times(paper_m: float | None, canvas: Canvas) -> float | None:
    return None if paper_m is None else paper_m / canvas.pixels_per_unit
