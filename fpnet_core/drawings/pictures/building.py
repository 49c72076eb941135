# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Segmentation of the building on a sheet by the parser network.

A coarse pass over the whole sheet locates buildings. A fine pass over one building, at the
resolution that its walls need and with the coarse pass as context, classifies its pixels.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.parsing.network import Parsed, parse
from fpnet_core.drawings.pictures.spaces import LIKELY, rooms_among_spaces
from fpnet_core.drawings.pictures.thickness import wall_cells
from fpnet_core.drawings.pictures.view import View
from fpnet_core.drawings.types import Array, Box, Chances
from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import scale_of
from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask, disc, grown, grown_by, opened_by, shrunk, square
from fpnet_core.raster.pieces import longer_pieces, pieces_of
from fpnet_core.raster.pixels import map_points
from fpnet_core.raster.windows import window_of
from fpnet_core.segmentation.scale_model import ScalePrior
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

Pixels = NDArray[np.uint8]

SHEET_PX = (400, 800)
"""
Longer sides of the images of the coarse pass: of (400), (512), (640), (1024), these and three
others the best on 40 sheets of the development split. Chosen.
"""

BUILDING_PX = (500, 1300)
"""Smallest and largest longer side of the building in the image of the fine pass. Chosen."""

WALL_PX = 6.0
"""Mean thickness of walls in the image of the fine pass, within these limits. Chosen."""

FINAL_PX = 1600
"""Largest longer side of the map, at which edges of walls are refined on the drawing. Chosen."""

# Chosen, not measured:
_WING_SHARE = 0.03  # of the building's longer side: largest distance of its parts
_LINE_SHARE = 0.008  # of an image's longer side: thinner areas are no buildings
_STOREY_SHARE = 0.3  # of the largest building's area: others of this size are storeys
_LEAST_SHARE = 0.002  # smallest share of the sheet that counts as a building
_MARGIN = 0.04  # of the building's longer side: margin of the fine pass
_SPECK_SHARE = 0.006  # of the building's longer side: shorter components are not walls
_WALL_SHARE = 0.06  # of the building's longer side: largest distance of a wall from floor
# Weight of walls over floor, as a hole in a wall joins two rooms; fitted to ten wrong and ten
# right sheets of the development split (notes/drawings.md).
_WALLS_COUNT = 2.5
_FAINT = 0.15  # probability of a line that bounds a space in the coarse pass
_SURELY, _HARDLY = 0.7, 0.2  # probabilities of wall and other pixels whose levels are compared
_SHARP_PX = 2.0  # error of wall edges in pixels of the network
_EDGE = 0.2  # of an image's contrast: smaller changes over that distance are no edges
_SOLID_GAP, _SOLID_SPREAD = 0.15, 0.2  # of solid walls: contrast; spread of levels over it
_LEAST = 1e-3  # numerical


@dataclass(frozen=True, eq=False)
class SeenBuilding:
    """
    A building as segmented by the network.

    ``cells (H, W)`` with row 0 at the top, ``chances (K, H, W)`` of each class there, and
    ``first_chances (K, H, W)`` by the coarse pass alone; ``H_cell_pixel (3, 3)`` maps pixels of
    the drawing to them; ``boxes`` are those of all buildings on the sheet in the view's pixels,
    ``chosen`` indexes them; ``scale`` is the distribution of a cell's edge [m].
    """

    cells: NDArray[np.int8]
    chances: Chances
    first_chances: Chances
    H_cell_pixel: Array
    boxes: tuple[Box, ...]
    chosen: int
    scale: ScalePrior


def see_building(view: View, storey: int | None) -> SeenBuilding | None:
    """
    Return the building of a view as segmented by the network; None if it finds none.

    ``storey`` is its number from 1, of several on a sheet; None takes the largest.

    Raises
    ------
    MapFormatError
        If there is no such storey.
    """
    shape = view.shape
    sheet, H_sheet_pixel = _coarse_pass(view)
    first = sheet.chances
    labels, boxes = _buildings(first[OUTSIDE] < LIKELY)
    if not boxes:
        return None
    order = _reading_order(boxes)
    chosen = order.index(0) if storey is None else storey - 1
    if not 0 <= chosen < len(order):
        raise MapFormatError(f'storey {storey} is not on the sheet: expected 1 to {len(order)}')
    S = view.H_view_pixel @ np.linalg.inv(H_sheet_pixel)
    in_view = tuple(_mapped(S, boxes[k]) for k in order)
    ground = labels == order[chosen] + 1
    box = _widened(in_view[chosen], shape)
    final, H_cell_pixel = view.shown(box, FINAL_PX)
    H_cell_sheet = H_cell_pixel @ np.linalg.inv(H_sheet_pixel)
    size = (final.shape[1], final.shape[0])
    before = _moved(first, H_cell_sheet, size)
    picture, H_picture_pixel = view.shown(box, _longest(first, ground, boxes[order[chosen]]))
    second = _parsed_with(picture, first, H_picture_pixel @ np.linalg.inv(H_sheet_pixel))
    fine = _enlarged(second.chances, final)
    grounds = _grown(ground, _WING_SHARE).astype(np.float32)
    near = cv2.warpPerspective(grounds, H_cell_sheet, size) > LIKELY
    cells = _largest(_cells(fine, before, near))
    if not (cells == FREE).any():
        return None
    scale = sheet.scale.per(1.0 / float(scale_of(H_cell_sheet[:2, :2])))
    return SeenBuilding(cells, fine, before, H_cell_pixel, in_view, chosen, scale)


def _coarse_pass(view: View) -> tuple[Parsed, Array]:
    """
    Return the parse of the whole sheet, and the map (3, 3) from a drawing's pixels to it.

    The parse of a small image, which shows halls and large buildings, is the context of the next.
    """
    height, width = view.shape
    seen, H_seen_pixel = None, np.eye(3)
    for longest in SHEET_PX:
        picture, H_picture_pixel = view.shown((0, 0, width, height), longest)
        H_picture_seen = H_picture_pixel @ np.linalg.inv(H_seen_pixel)
        parsed = _parsed_with(picture, None if seen is None else seen.chances, H_picture_seen)
        scale = parsed.scale
        if seen is not None:
            scale = scale.and_also(seen.scale.per(1.0 / float(scale_of(H_picture_seen[:2, :2]))))
        seen, H_seen_pixel = Parsed(_with_halls(parsed.chances), scale), H_picture_pixel
    assert seen is not None
    return seen, H_seen_pixel


def _with_halls(chances: Chances) -> Chances:
    """Return the probabilities (K, H, W) of a sheet with enclosed halls as floor."""
    is_line = chances[WALL] + chances[WINDOW] + chances[DOOR] > _FAINT
    is_room = rooms_among_spaces(1.0 - chances[OUTSIDE], is_line, chances) & ~is_line
    found = chances.copy()
    is_hall = is_room & (chances[OUTSIDE] > LIKELY)
    found[FLOOR][is_hall] += found[OUTSIDE][is_hall]
    found[OUTSIDE][is_hall] = 0.0
    return found


def _parsed_with(picture: Pixels, before: Chances | None, H_picture_before: Array) -> Parsed:
    """Return the parse of an image, with an earlier one ``before`` as context."""
    if before is None:
        return parse(picture)
    known = np.concatenate([before, np.ones_like(before[:1])])
    size = (picture.shape[1], picture.shape[0])
    return parse(picture, _moved(known, H_picture_before, size))


def first_cells(seen: SeenBuilding) -> NDArray[np.int8]:
    """Return the cells (H, W) of the same building by the coarse pass alone."""
    built = _grown(seen.cells != UNKNOWN, _WING_SHARE)
    return _largest(_cells(seen.first_chances, seen.first_chances, built))


def _moved(chances: Chances, H: Array, size: tuple[int, int]) -> Chances:
    """Return channels (K, H, W) mapped by ``H`` to an image of ``size`` (width, height)."""
    return np.stack([np.asarray(cv2.warpPerspective(c, H, size), np.float32) for c in chances])


def _enlarged(chances: Chances, picture: Pixels) -> Chances:
    """Return the probabilities for a larger ``picture (H, W, 3)``, with sharp solid walls."""
    size = (picture.shape[1], picture.shape[0])
    factor = size[0] / chances.shape[2]
    shown = [cv2.resize(each, size, interpolation=cv2.INTER_LINEAR) for each in chances]
    found = np.asarray(np.stack(shown), np.float32)
    solid = found[WALL] + found[WINDOW]
    guide = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.float32) / 255.0
    if not _are_solid(solid, guide):
        return found
    sharp = np.clip(_guided(solid, guide, max(1, round(_SHARP_PX * factor))), 0.0, 1.0)
    rest = (1.0 - sharp) / np.maximum(1.0 - solid, _LEAST)
    window = found[WINDOW] / np.maximum(solid, _LEAST) * sharp
    found *= rest
    found[WALL], found[WINDOW] = sharp - window, window
    return found


def _are_solid(solid: NDArray[np.float32], guide: NDArray[np.float32]) -> bool:
    """Return whether walls have a uniform grey level, darker than their surroundings."""
    wall = solid > _SURELY
    core, beside = shrunk(wall, 1), grown(wall, 4) & (solid < _HARDLY)
    if not core.any() or not beside.any():
        return False
    tone = float(np.median(guide[core]))
    spread = float(np.median(np.abs(guide[core] - tone)))
    gap = float(np.median(guide[beside])) - tone
    return gap > _SOLID_GAP and spread < _SOLID_SPREAD * gap


def _guided(
    values: NDArray[np.float32], guide: NDArray[np.float32], radius: int
) -> NDArray[np.float32]:
    """Return values (H, W) after a guided filter (He et al., 2010, equations 5-8)."""
    side = (2 * radius + 1, 2 * radius + 1)
    mean, about = cv2.blur(guide, side), cv2.blur(values, side)
    both = cv2.blur(guide * values, side) - mean * about
    spread = cv2.blur(guide * guide, side) - mean * mean
    slope = both / (spread + (_EDGE * float(guide.std())) ** 2)
    offset = about - slope * mean
    return np.asarray(cv2.blur(slope, side) * guide + cv2.blur(offset, side), np.float32)


def _buildings(inside: Mask) -> tuple[NDArray[np.int32], list[Box]]:
    """Return labels (H, W) from 1 on, and boxes of the buildings, the largest first."""
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
    """Return the longer side of the fine pass's image, by the walls in the coarse pass."""
    thickness = wall_cells((chances[WALL] > LIKELY) & ground)
    side = max(box[2] - box[0], box[3] - box[1])
    wanted = side * WALL_PX / max(thickness, 1.0)
    return round((1.0 + 2.0 * _MARGIN) * float(np.clip(wanted, *BUILDING_PX)))


def _box(mask: Mask) -> Box:
    window = window_of(mask)
    assert window is not None, 'a building has at least one pixel'
    rows, cols = window
    return cols.start, rows.start, cols.stop, rows.stop


def _reading_order(boxes: list[Box]) -> list[int]:
    """Return the indices of the boxes row by row; boxes that overlap in height are a row."""
    left = sorted(range(len(boxes)), key=lambda k: boxes[k][1])
    found: list[int] = []
    while left:
        bottom = boxes[left[0]][3]
        row = [k for k in left if (boxes[k][1] + boxes[k][3]) / 2.0 < bottom]
        found += sorted(row, key=lambda k: boxes[k][0])
        left = [k for k in left if k not in row]
    return found


def _grown(mask: Mask, share: float) -> Mask:
    """Return the mask dilated by a share of the image's longer side."""
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


def _walls_and_rooms(
    chances: Chances, outside: NDArray[np.float32], near: Mask
) -> tuple[Mask, Mask]:
    """Return walls and rooms (H, W) within ``near``; ``outside (H, W)`` is a probability."""
    solid, door = chances[WALL] + chances[WINDOW], chances[DOOR]
    is_wall = _WALLS_COUNT * solid > np.maximum(chances[FLOOR] + door, chances[OUTSIDE])
    is_wall &= near
    is_room = rooms_among_spaces(1.0 - outside, is_wall | (door > LIKELY), chances)
    return is_wall, is_room & near


def _cells(fine: Chances, before: Chances, near: Mask) -> NDArray[np.int8]:
    """
    Return cells (H, W) of the building within ``near (H, W)``.

    Walls are those of the ``fine`` pass; both passes decide whether a space is a room.
    """
    is_wall, is_room = _walls_and_rooms(fine, 0.5 * (fine[OUTSIDE] + before[OUTSIDE]), near)
    is_free = is_room & ~is_wall
    reach = _WALL_SHARE * max(near.shape)
    is_wall &= cells_to_nearest(is_free) <= reach
    is_wall = longer_pieces(is_wall, _SPECK_SHARE * max(near.shape))
    return np.select([is_wall, is_free], [OCCUPIED, FREE], UNKNOWN).astype(np.int8)


def _largest(cells: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return the cells of the largest connected building."""
    labels, boxes = _buildings(cells != UNKNOWN)
    if not boxes:
        return np.full_like(cells, UNKNOWN)
    return np.where(_grown(labels == 1, _LINE_SHARE), cells, UNKNOWN).astype(np.int8)
