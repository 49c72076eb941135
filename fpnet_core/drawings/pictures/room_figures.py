# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What speaks for and against each room of a reading, in figures that need no scale.

A reading goes wrong room by room: the outside leaks in at a window, a stair or an arrow parts a
room, a wall was too faint. Each leaves a trace at that room: an edge without a wall, a wall that
is thinner or fainter than the others, ink that nobody read, another reading that cuts it
differently.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.pictures.looking import WHAT_IFS, ReadingView
from fpnet_core.raster.morphology import Mask, grown
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.windows import EVERY_SIDE
from fpnet_core.types import OCCUPIED, UNKNOWN, GridMap, Segmentation

Array = NDArray[np.float64]
Labels = NDArray[np.int32]

ROOM_FIGURES = (
    'size', 'square', 'convex', 'solid', 'long', 'corners', 'askew', 'doors', 'widest_door',
    'open', 'doored', 'thin', 'faint', 'bitten', 'unread', 'faint_ink', 'strokes', 'furniture',
    'rivals', 'best_rival', 'top_rival', *WHAT_IFS, 'rooms', 'plausible',
)  # fmt: skip

# Chosen, not measured:
_UNREAD, _HALF_READ = 0.5, 0.25  # of the usual wall's contrast is ink that a reader sees
_NEAR_CELLS = 2  # ink as near to a wall is its edge
_CORNER = 0.04  # of the root of a room's area may an outline be off to be the same
_ASKEW_RAD = 0.14  # from the room's own sides, from which on an edge lies askew


def room_figures(look: ReadingView) -> Array:
    """Return the figures (R, F) of all rooms, in the order of ``ROOM_FIGURES``."""
    rooms = look.segmentation.rooms
    if not rooms:
        return np.zeros((0, len(ROOM_FIGURES)))
    columns = {
        **_shapes(look.segmentation),
        **_doors(look.segmentation),
        **_edges(look),
        **_inside(look),
        **_agreements(look),
        'rooms': np.full(len(rooms), np.log(len(rooms))),
        'plausible': np.full(len(rooms), look.plausible),
    }
    return np.column_stack([columns[name] for name in ROOM_FIGURES])


def _shapes(segmentation: Segmentation) -> dict[str, Array]:
    area = np.array([room.area_m2 for room in segmentation.rooms])
    rows = [
        _shape(room.polygon, size) for room, size in zip(segmentation.rooms, area, strict=True)
    ]
    names = ('square', 'convex', 'solid', 'long', 'corners', 'askew')
    found = dict(zip(names, np.array(rows).T, strict=True))
    return {'size': np.log(area / np.median(area)), **found}


def _shape(polygon: Array, area: float) -> list[float]:
    """Return how far a room fills its rectangle, hull and outline, and how plain that is."""
    ring = polygon.astype(np.float32)
    (_, sides, angle) = cv2.minAreaRect(ring)
    low, high = max(min(sides), 1e-6), max(*sides, 1e-6)
    plain = cv2.approxPolyDP(ring, _CORNER * float(np.sqrt(area)), closed=True)[:, 0]
    steps = np.roll(plain, -1, axis=0) - plain
    length = np.hypot(*steps.T)
    turned = np.arctan2(steps[:, 1], steps[:, 0]) - np.deg2rad(angle)
    off = np.abs((turned + 0.25 * np.pi) % (0.5 * np.pi) - 0.25 * np.pi)
    return [
        area / (low * high),
        area / max(cv2.contourArea(cv2.convexHull(ring)), 1e-6),
        area / max(cv2.contourArea(ring), 1e-6),
        float(np.log(high / low)),
        float(np.log(len(plain))),
        float(length[off > _ASKEW_RAD].sum() / max(length.sum(), 1e-6)),
    ]


def _doors(segmentation: Segmentation) -> dict[str, Array]:
    count = len(segmentation.rooms)
    doors, widest = np.zeros(count), np.zeros(count)
    widths = [portal.width_m for portal in segmentation.portals]
    usual = float(np.median(widths)) if widths else 1.0
    for portal in segmentation.portals:
        for room in portal.rooms:
            if room is not None and room < count:
                doors[room] += 1.0
                widest[room] = max(widest[room], portal.width_m / usual)
    return {'doors': np.log1p(doors), 'widest_door': np.log(np.maximum(widest, 0.2))}


def _edges(look: ReadingView) -> dict[str, Array]:
    """Return what rooms end at: shares of their edge without a wall, and at thin or faint ones."""
    segmentation = look.segmentation
    cells, labels = segmentation.grid.cells, segmentation.labels
    kinds = np.select(
        [labels > 0, look.thin, look.faint, look.walls, cells == UNKNOWN],
        [1, 2, 3, 4, 5],
        0,
    )
    count = len(segmentation.rooms)
    met = np.zeros((count + 1, 6))
    for here, there in EVERY_SIDE:
        room, other = labels[here], labels[there]
        edge = (room > 0) & (other != room)
        np.add.at(met, (room[edge], kinds[there][edge]), 1.0)
    met = met[1:] / np.maximum(met[1:].sum(axis=1, keepdims=True), 1.0)
    bitten = [_bitten(room.polygon, segmentation.grid) for room in segmentation.rooms]
    return {
        'open': met[:, 5],
        'doored': met[:, 0] + met[:, 1],
        'thin': met[:, 2],
        'faint': met[:, 3],
        'bitten': np.array(bitten),
    }


def _bitten(polygon: Array, grid: GridMap) -> float:
    """Return the share of a room's hull that is outside the building."""
    rc = np.rint(grid.xy_to_rc(polygon)).astype(np.int32)
    low = np.maximum(rc.min(axis=0), 0)
    high = np.minimum(rc.max(axis=0) + 1, grid.shape)
    hull = cv2.convexHull(np.ascontiguousarray((rc - low)[:, ::-1]))
    filled = np.zeros(tuple(np.maximum(high - low, 1)), np.uint8)
    cv2.fillConvexPoly(filled, hull, 1)
    cells = grid.cells[low[0] : high[0], low[1] : high[1]]
    inside = filled[: cells.shape[0], : cells.shape[1]] > 0
    return float(np.mean(cells[inside] == UNKNOWN)) if inside.any() else 0.0


def _inside(look: ReadingView) -> dict[str, Array]:
    """Return ink within rooms that is no wall of the reading, and walls that were overlooked."""
    segmentation = look.segmentation
    cells, labels = segmentation.grid.cells, segmentation.labels
    walls = cells == OCCUPIED
    clear = ~grown(walls, _NEAR_CELLS) & (labels > 0)
    unread = clear & (look.levels > _UNREAD * look.tone)
    count = len(segmentation.rooms)
    size = np.maximum(np.bincount(labels.ravel(), minlength=count + 1)[1:], 1)
    shares = {
        'unread': unread,
        'faint_ink': clear & (look.levels > _HALF_READ * look.tone),
        'furniture': walls & (labels > 0),
    }
    found = {
        name: np.bincount(labels[mask], minlength=count + 1)[1:] / size
        for name, mask in shares.items()
    }
    return {**found, 'strokes': _strokes(unread, labels, size)}


def _strokes(unread: Mask, labels: Labels, size: NDArray[np.int64]) -> Array:
    """Return the extent of the longest unread stroke of each room, over the root of its area."""
    pieces, stats = pieces_of(unread)
    extent = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    longest = np.zeros(len(size) + 1)
    at = pieces > 0
    np.maximum.at(longest, labels[at], extent[pieces[at]])
    return np.asarray(longest[1:] / np.sqrt(size))


def _agreements(look: ReadingView) -> dict[str, Array]:
    labels = look.segmentation.labels
    count = len(look.segmentation.rooms)
    each = [best_overlap(labels, rival, count) for rival in look.rivals]
    nothing = np.full(count, np.nan)
    what_if = {name: best_overlap(labels, other, count) for name, other in look.what_if.items()}
    return {
        'rivals': np.average(each, axis=0, weights=look.shares) if each else nothing,
        'best_rival': np.max(each, axis=0) if each else nothing,
        'top_rival': each[0] if each else nothing,
        **what_if,
    }


def best_overlap(labels: Labels, others: Labels, count: int) -> Array:
    """Return each of ``count`` rooms' best intersection over union with a room of ``others``."""
    both = overlaps(labels, others)
    if both.shape[1] < 2:
        return np.zeros(count)
    size, other = both.sum(axis=1, keepdims=True), both.sum(axis=0, keepdims=True)
    shares = both / np.maximum(size + other - both, 1)
    best = np.zeros(count)
    best[: len(both) - 1] = shares[1 : count + 1, 1:].max(axis=1)
    return best


def overlaps(labels: Labels, others: Labels) -> NDArray[np.int64]:
    """Return how many cells two label rasters (H, W) share, by the labels of both."""
    width = int(others.max(initial=0)) + 1
    height = int(labels.max(initial=0)) + 1
    counted = np.bincount(
        labels.ravel().astype(np.int64) * width + others.ravel(), minlength=height * width
    )
    return counted.reshape(height, width)
