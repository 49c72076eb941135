# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The building on a sheet, from two looks by the parser.

The first look at the whole sheet tells where buildings are. The second, at one building as finely
as its walls need, knows what the first one saw, and tells what is wall, window, door and floor.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.parsing.network import Parse, bin_metres, parse
from fpnet_core.drawings.pictures.thickness import wall_cells
from fpnet_core.drawings.pictures.view import View
from fpnet_core.drawings.types import Array, Box, Chances, Trust
from fpnet_core.errors import MapFormatError
from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask, disc, grown, grown_by, opened_by, square
from fpnet_core.raster.pieces import longer_pieces, pieces_of
from fpnet_core.raster.pixels import map_points
from fpnet_core.raster.windows import window_of
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

SHEET_PX = 1024
"""The longer side of the picture in the first look. Chosen."""

BUILDING_PX = (420, 1400)
"""The longer side of the building in the second look, and between them. Chosen."""

WALL_PX = 5.0
"""so large that its walls are as thick as this in the mean. Chosen."""

LIKELY = 0.5  # numerical

# Chosen, not measured:
_WING_SHARE = 0.03  # of the building's longer side: so far apart may its parts be
_LINE_SHARE = 0.008  # of a picture's longer side: what is thinner encloses nothing
_STOREY_SHARE = 0.3  # of the largest building's area: others are storeys
_LEAST_SHARE = 0.002  # of the sheet is building, or it shows none
_MARGIN = 0.04  # of the building's longer side is looked at around it
_SPECK_SHARE = 0.006  # of the building's longer side: shorter pieces of wall are none
_WALL_SHARE = 0.06  # of the building's longer side: what is further from any floor is no wall
_WALLS_COUNT = 2.0  # times as much as floor: a hole in a wall joins two rooms
_UNSURE = 0.8  # less probable classes are not sure
_LEAKS = 0.12  # of a space is unlike the rest of it
_NEAR_PX = 3  # both looks may be off by so much at the edges of walls, in the finer one's pixels


@dataclass(frozen=True, eq=False)
class SeenBuilding:
    """
    A building as the parser sees it.

    ``cells (H, W)`` with row 0 at the top, ``rough_cells (H, W)`` by the first look alone;
    ``doors (H, W)`` marks doorways; ``H_cell_pixel (3, 3)`` maps the drawing's pixels to them;
    ``boxes`` are those of all buildings on the sheet in the view's pixels, ``chosen`` indexes
    them. ``scale (SCALE_BINS,)`` are probabilities of the metres of a cell.
    """

    cells: NDArray[np.int8]
    rough_cells: NDArray[np.int8]
    doors: Mask
    H_cell_pixel: Array
    boxes: tuple[Box, ...]
    chosen: int
    trust: Trust
    scale: NDArray[np.float64]


def see_building(view: View, storey: int | None) -> SeenBuilding | None:
    """
    Return the building of a view as the parser sees it; None where it sees none.

    ``storey`` is its number from 1, of several on a sheet; None takes the largest.

    Raises
    ------
    MapFormatError
        If there is no such storey.
    """
    shape = view.levels.shape
    sheet, H_sheet_pixel = view.shown((0, 0, shape[1], shape[0]), SHEET_PX)
    first = parse(sheet)
    labels, boxes = _buildings(first.classes[OUTSIDE] < LIKELY)
    if not boxes:
        return None
    order = _reading_order(boxes)
    chosen = order.index(0) if storey is None else storey - 1
    if not 0 <= chosen < len(order):
        raise MapFormatError(f'storey {storey} is not on the sheet: expected 1 to {len(order)}')
    S = view.H_view_pixel @ np.linalg.inv(H_sheet_pixel)
    in_view = tuple(_mapped(S, boxes[k]) for k in order)
    ground = labels == order[chosen] + 1
    longest = _longest(first.classes, ground, boxes[order[chosen]])
    picture, H_cell_pixel = view.shown(_widened(in_view[chosen], shape), longest)
    size = (picture.shape[1], picture.shape[0])
    H_cell_sheet = H_cell_pixel @ np.linalg.inv(H_sheet_pixel)
    context = _context(first, H_cell_sheet, size)
    second = parse(picture, context)
    around = _grown(ground, _WING_SHARE).astype(np.float32)
    near = cv2.warpPerspective(around, H_cell_sheet, size) > LIKELY
    cells = _alone(_cells(second.classes, near))
    if not (cells == FREE).any():
        return None
    rough = _alone(_cells(context[:-1], near))
    doors = (second.classes[DOOR] > LIKELY) & (cells == FREE)
    trust = _trust(second.classes, context[:-1], cells)
    return SeenBuilding(
        cells,
        rough,
        doors,
        H_cell_pixel,
        in_view,
        chosen,
        trust,
        _scale(first, second, H_cell_sheet),
    )


def _context(first: Parse, H: Array, size: tuple[int, int]) -> Chances:
    """Return the first answer (CONTEXT, H, W) where the second look is, and where there is one."""
    known = [*first.classes, np.ones(first.classes.shape[1:], np.float32)]
    return np.stack([np.asarray(cv2.warpPerspective(c, H, size), np.float32) for c in known])


def _scale(first: Parse, second: Parse, H_cell_sheet: Array) -> NDArray[np.float64]:
    """Return the probabilities (SCALE_BINS,) of the metres of a cell, by both looks."""
    growth = float(np.sqrt(abs(np.linalg.det(H_cell_sheet[:2, :2]))))
    at = np.log(bin_metres())
    moved = np.interp(at, at - np.log(growth), first.scale, left=0.0, right=0.0)
    both = np.sqrt((moved + 1e-6) * (second.scale + 1e-6))
    return np.asarray(both / both.sum())


def _buildings(inside: Mask) -> tuple[NDArray[np.int32], list[Box]]:
    """Return labels (H, W), 1 and up, and boxes of the buildings, the largest first."""
    longest = max(inside.shape)
    side = 2 * round(0.5 * _LINE_SHARE * longest) + 1
    inside = opened_by(inside, square(side))
    _, stats = pieces_of(inside)
    if len(stats) < 2:
        return np.zeros(inside.shape, np.int32), []
    largest = int(stats[1:, cv2.CC_STAT_AREA].argmax()) + 1
    extent = int(stats[largest, 2:4].max())
    joined = _grown(inside, _WING_SHARE * extent / longest / 2.0)
    pieces, found = pieces_of(joined)
    labels, count = np.where(inside, pieces, 0), len(found)
    areas = np.bincount(labels.ravel(), minlength=count)[1:]
    order = np.argsort(-areas, kind='stable')
    least = max(_STOREY_SHARE * areas.max(), _LEAST_SHARE * inside.size)
    kept = [int(k) + 1 for k in order if areas[k] >= least]
    number = np.zeros(count, np.int32)
    number[kept] = np.arange(1, len(kept) + 1)
    return number[labels], [_box(labels == k) for k in kept]


def _longest(chances: Chances, ground: Mask, box: Box) -> int:
    """Return how long a building's picture should be, by its walls as seen on the sheet."""
    thickness = wall_cells((chances[WALL] > LIKELY) & ground)
    side = max(box[2] - box[0], box[3] - box[1])
    wanted = side * WALL_PX / max(thickness, 1.0)
    return round((1.0 + 2.0 * _MARGIN) * float(np.clip(wanted, *BUILDING_PX)))


def _box(mask: Mask) -> Box:
    window = window_of(mask)
    assert window is not None, 'a building has cells'
    rows, cols = window
    return cols.start, rows.start, cols.stop, rows.stop


def _reading_order(boxes: list[Box]) -> list[int]:
    """Return the places of the boxes row by row; those that overlap in height are a row."""
    left = sorted(range(len(boxes)), key=lambda k: boxes[k][1])
    found: list[int] = []
    while left:
        bottom = boxes[left[0]][3]
        row = [k for k in left if (boxes[k][1] + boxes[k][3]) / 2.0 < bottom]
        found += sorted(row, key=lambda k: boxes[k][0])
        left = [k for k in left if k not in row]
    return found


def _grown(mask: Mask, share: float) -> Mask:
    """Return the mask dilated by a share of the picture's longer side."""
    return grown_by(mask, disc(2 * max(1, round(share * max(mask.shape))) + 1))


def _mapped(H: Array, box: Box) -> Box:
    left, top, right, bottom = box
    corners = np.array([[left, top], [right - 1.0, bottom - 1.0]])
    (x0, y0), (x1, y1) = map_points(H, corners).tolist()
    return round(x0), round(y0), round(x1) + 1, round(y1) + 1


def _widened(box: Box, shape: tuple[int, ...]) -> Box:
    left, top, right, bottom = box
    by = round(_MARGIN * max(right - left, bottom - top)) + 1
    return (
        max(0, left - by),
        max(0, top - by),
        min(shape[1], right + by),
        min(shape[0], bottom + by),
    )


def _cells(seen: Chances, near: Mask) -> NDArray[np.int8]:
    """Return cells (H, W) of the building within ``near (H, W)``; windows are walls."""
    solid = _WALLS_COUNT * (seen[WALL] + seen[WINDOW])
    is_wall = (solid > np.maximum(seen[FLOOR] + seen[DOOR], seen[OUTSIDE])) & near
    is_shut = is_wall | (seen[DOOR] > LIKELY)
    inside = _by_spaces(1.0 - seen[OUTSIDE], is_shut) & near
    is_free = inside & ~is_wall
    reach = _WALL_SHARE * max(near.shape)
    is_wall &= cells_to_nearest(is_free) <= reach
    is_wall = longer_pieces(is_wall, _SPECK_SHARE * max(near.shape))
    return np.select([is_wall, is_free], [OCCUPIED, FREE], UNKNOWN).astype(np.int8)


def _alone(cells: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return the cells without what stands apart from the building."""
    labels, boxes = _buildings(cells != UNKNOWN)
    if not boxes:
        return np.full_like(cells, UNKNOWN)
    return np.where(_grown(labels == 1, _LINE_SHARE), cells, UNKNOWN).astype(np.int8)


def _by_spaces(inside: Chances, is_shut: Mask) -> Mask:
    """
    Return what is more inside than outside, of the probability ``inside (H, W)``.

    A space that lines shut off is one or the other as a whole, unless it is much of both: then
    it leaks.
    """
    spaces, found = pieces_of(~is_shut, connectivity=4)
    count = len(found)
    flat, likely = spaces.ravel(), (inside > LIKELY).ravel()
    share = np.bincount(flat, likely, count) / np.maximum(np.bincount(flat, minlength=count), 1)
    leaks = np.minimum(share, 1.0 - share) > _LEAKS
    leaks[0] = True
    return np.where(leaks[spaces], inside, share[spaces]) > LIKELY


def _trust(fine: Chances, before: Chances, cells: NDArray[np.int8]) -> Trust:
    built, walls = cells != UNKNOWN, cells == OCCUPIED
    most = fine.max(axis=0)[built]
    solid = fine[WALL] + fine[WINDOW]
    earlier = (before[WALL] + before[WINDOW] > LIKELY) & built
    return Trust(
        certainty=float(most.mean()),
        wall_certainty=float(solid[walls].mean()) if walls.any() else 0.0,
        unsure=float((most < _UNSURE).mean()),
        agreement=min(_covered(walls, earlier), _covered(earlier, walls)),
    )


def _covered(walls: Mask, by: Mask) -> float:
    """Return the share of walls that others are near to."""
    return float((grown(by, _NEAR_PX) & walls).sum() / max(walls.sum(), 1))
