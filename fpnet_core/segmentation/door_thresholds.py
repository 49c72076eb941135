# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What is drawn in and before doorways: sills from one jamb to the other, leaves and their arcs.

Nothing tells a sill from a wall but that the walls at its ends are thicker. So lines are taken
away, gaps are looked for in the walls that remain, and a gap between two rooms that is closed by
less than walls are made of is a doorway. Windows are drawn alike: what the gaps in outer walls
show as often as not, and no fewer of them than of inner ones, is a window's sign, and takes a leaf
to be a sill's. Where a doorway is known its leaf can stand in a few places only, and is found
though letters or furniture cross it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_any, unblocked
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask, grown, opened_by, square
from fpnet_core.raster.pieces import label_figures, label_windows, looked_up, pieces_of
from fpnet_core.raster.rays import cells_at, marked, run_lengths, values_at
from fpnet_core.segmentation.gaps import find_gaps

Array = NDArray[np.float64]

# Physical: doorways of a storey are so wide [m] and its walls at most so thick [m], at a scale
# wrong by a half.
_WIDTH_M, _THICKEST_M = (0.5, 3.0), 0.8
# Fitted by hand to the tune plans (notes/segmentation.md): wider doorways have leaves, which
# are drawn then [m].
_LEAFLESS_M = 1.5
# Numerical: symbols are looked for at cells of about this size [m].
_WORK_M = 0.02
# Numerical: lines are thinner than so many cells.
_SIDES = (2, 3, 4, 6, 8)
# Fitted by hand to the tune half's plans (notes/segmentation.md): thinner walls are not told from
# lines, without a leaf and with one.
_LEAST_CELLS, _LEAST_LEAFED_CELLS = 4.0, 2.5
# Chosen, not measured:
_LINE_M = 0.18  # and than this [m]
_HOLLOW_M = 0.5  # narrower closed spaces are the inside of walls that are drawn as two lines [m]
_PLAIN = 0.8  # of its rectangle does the inside of a doorway with two sills fill
_DRAWN = 0.8  # of a line's length is drawn
_EMPTY = 0.25  # of the rest of a doorway, at most, is drawn: a leaf's end, a jamb's rounding
_THIN = 0.5  # of a wall's thickness has a single sill, at most
_MOST_LINES = 2
_BESIDE_M = (0.25, 0.45)  # on both sides of the doorway there is a room [m]
_ROOM_SHARE = 0.6  # of the places there
_WINDOWS = 0.5  # of the gaps in outer walls show as many lines as windows do
_OPEN_RAD = (0.5 * np.pi, 0.25 * np.pi)  # leaves are drawn open so far
_SWEPT, _BARE = 0.9, 0.5  # of a leaf and an arc is drawn, and of those beside them
_SHORTER, _BESIDE_RAD = 0.8, 0.2  # those beside: an arc of so much the radius, a leaf so turned
_LENGTHS = (0.94, 0.97, 1.0, 1.03, 1.06)  # a leaf's, over the doorway's width
_LOOSE_M = 0.03  # leaves and arcs may be off by so much [m]
_STUB_CELLS = 1.5  # of a leaf at its hinge and an arc at its jamb so much stays
_STEP = 0.5  # numerical: of a cell, at which a doorway is looked over
_PLACES = 14  # numerical: where a leaf and an arc are looked at
# All leaves that there may be (5, N): length and hinge over the doorway's length, side, face from
# the wall's low to its high one, how far open.
_LEAVES = np.stack(
    np.meshgrid(np.outer([1.0, 0.5], _LENGTHS), (0, 1), (-1, 1), (0.0, 0.5, 1.0), _OPEN_RAD)
).reshape(5, -1)


@dataclass(frozen=True, eq=False)
class _Doorway:
    """
    A place where a door may be, in cells.

    It goes from ``start (2,)`` on ``along (2,)`` for ``length`` through a wall that lies from
    ``low`` to ``high`` across it.
    """

    start: Array
    along: Array
    length: float
    low: float
    high: float

    @property
    def across(self) -> Array:
        """Return the unit vector (2,) through the wall."""
        return np.array([-self.along[1], self.along[0]])

    def at(self, along: Array, across: Array) -> Array:
        """Return places (..., 2) so far along and across."""
        return np.asarray(
            self.start + along[..., None] * self.along + across[..., None] * self.across
        )


@dataclass(frozen=True, eq=False)
class _Swing:
    """Leaves of a door that stand open: places (N, 2) on them and on their arcs."""

    places: Array
    has_arc: bool


def doorway_symbols(ink: Mask, room: Mask, cell_m: float) -> Mask:
    """
    Return the cells (H, W) of sills, leaves and arcs that close doorways between rooms.

    Parameters
    ----------
    ink : (H, W), what is drawn
    room : (H, W), free space inside the building
    cell_m : cell edge, about [true metres]
    """
    stride = max(1, int(_WORK_M / cell_m))
    drawn = block_any(ink, stride)
    found = _symbols(drawn, block_any(room, stride) & ~drawn, cell_m * stride)
    return unblocked(found, stride, ink.shape) & ink


def _symbols(ink: Mask, room: Mask, cell_m: float) -> Mask:
    strokes, filled = np.zeros(ink.shape, np.bool_), np.zeros(ink.shape, np.uint8)
    pen = max(1, round(_LOOSE_M / cell_m))
    near = grown(ink, pen)
    spaces, is_hollow = _hollows(ink, cell_m)
    hollow = looked_up(spaces, is_hollow)
    found = np.zeros(ink.shape, np.bool_)
    for walls in _wall_masks(ink, hollow, cell_m):
        found |= _in_gaps(ink, near, walls, room, cell_m, pen)
    for way in _hollow_doorways(ink, spaces, is_hollow, cell_m):
        swing = _swing(near, way) if _is_between(room, way, cell_m) else None
        if swing is not None and swing.has_arc:
            strokes[cells_at(swing.places, ink.shape)] = True
            _fill(way, filled)
    return found | grown(strokes, pen) | (filled > 0)


def _hollows(ink: Mask, cell_m: float) -> tuple[NDArray[np.int32], Mask]:
    """Return the closed spaces of a drawing (H, W), and which are nowhere as wide as a room."""
    spaces, figures = pieces_of(~ink, connectivity=4)
    _, widest = label_figures(spaces, cells_to_nearest(ink), len(figures))
    is_hollow = 2.0 * widest * cell_m < _HOLLOW_M
    is_hollow[0] = False
    return spaces, is_hollow


def _wall_masks(ink: Mask, hollow: Mask, cell_m: float) -> Iterator[Mask]:
    """Yield what is left (H, W) without lines of so many cells, hollow walls filled and not."""
    for side in _SIDES:
        if side > _SIDES[0] and side * cell_m > _LINE_M:
            return
        for mask in (ink, ink | hollow):
            walls = opened_by(mask, square(side))
            if walls.any():
                yield walls


def _in_gaps(ink: Mask, near: Mask, walls: Mask, room: Mask, cell_m: float, pen: int) -> Mask:
    """Return what (H, W) is drawn in and before the gaps of ``walls (H, W)``."""
    strokes, filled = np.zeros(ink.shape, np.bool_), np.zeros(ink.shape, np.uint8)
    ways = list(_gap_doorways(walls, cell_m))
    lines = [_lines(ink, way) for way in ways]
    is_inner = [_is_between(room, way, cell_m) for way in ways]
    windows = _windows(lines, is_inner)
    for way, many, inner in zip(ways, lines, is_inner, strict=True):
        swing = _swing(near, way)
        if swing is not None and swing.has_arc:
            strokes[cells_at(swing.places, ink.shape)] = True
        is_narrow = way.length * cell_m <= _LEAFLESS_M
        is_plain = is_narrow and way.high - way.low >= _LEAST_CELLS and many not in windows
        if inner and 0 < many <= _MOST_LINES and (swing is not None or is_plain):
            _fill(way, filled)
    # A pen covers the lines of leaves and arcs; walls that they touch stay.
    return (grown(strokes, pen) & ~grown(walls, 1)) | (filled > 0)


def _windows(lines: list[int], is_inner: list[bool]) -> set[int]:
    """Return by how many lines windows are drawn, as what closes gaps and where these are say."""
    closed = [(many, inside) for many, inside in zip(lines, is_inner, strict=True) if many]
    outer = Counter(many for many, inside in closed if not inside)
    inner = Counter(many for many, inside in closed if inside)
    least = _WINDOWS * outer.total()
    return {many for many, count in outer.items() if count > max(least, inner[many] - 1)}


def _gap_doorways(walls: Mask, cell_m: float) -> Iterator[_Doorway]:
    """Yield the gaps of ``walls (H, W)`` that are as wide as doors."""
    for ends in find_gaps(~walls, walls, cell_m):
        length = float(np.hypot(*(ends[1] - ends[0])))
        along = (ends[1] - ends[0]) / max(length, 1.0)
        depth = _depth(walls, ends, along, _THICKEST_M / cell_m)
        if _WIDTH_M[0] <= length * cell_m <= _WIDTH_M[1] and depth is not None:
            yield _Doorway(ends[0], along, length, *depth)


def _depth(walls: Mask, ends: Array, along: Array, most: float) -> tuple[float, float] | None:
    """Return from where to where across a gap the walls at both its ends go; None if nowhere."""
    across = np.array([[along[1], -along[0]], [-along[1], along[0]]])
    starts = ends + 1.5 * np.array([[-1.0], [1.0]]) * along
    runs = run_lengths(walls, False, starts[:, None], across, most).min(axis=0)
    low, high = max(-most, -float(runs[0])), min(most, float(runs[1]))
    return (low, high) if _LEAST_LEAFED_CELLS <= high - low < most else None


def _hollow_doorways(
    ink: Mask, spaces: NDArray[np.int32], is_hollow: Mask, cell_m: float
) -> Iterator[_Doorway]:
    """
    Yield the insides of walls (H, W) that may be those of doorways with two sills.

    They go to the middles of the lines that jambs are drawn as: leaves hang there.
    """
    least = _WIDTH_M[0] / cell_m / np.sqrt(2.0)
    for number, window in label_windows(looked_up(spaces, is_hollow) * spaces).items():
        if max(side.stop - side.start for side in window) < least:
            continue
        rows, cols = np.nonzero(spaces[window] == number)
        (col, row), size, angle = cv2.minAreaRect(np.column_stack([cols, rows]).astype(np.float32))
        wide, long = min(size) + 1.0, max(size) + 1.0
        turn = np.radians(angle if size[0] >= size[1] else angle + 90.0)
        along = np.array([np.sin(turn), np.cos(turn)])
        middle = np.array([row + window[0].start, col + window[1].start])
        is_wide = _WIDTH_M[0] <= long * cell_m <= _WIDTH_M[1]
        if is_wide and len(rows) > _PLAIN * wide * long:
            half = 0.5 * wide + 1.0
            first, last = (
                0.5 * (long + _jamb(ink, middle + 0.5 * long * to, to, 0.25 * wide, cell_m))
                for to in (-along, along)
            )
            yield _Doorway(middle - first * along, along, first + last, -half, half)


def _jamb(ink: Mask, end: Array, along: Array, reach: float, cell_m: float) -> float:
    """Return how thick the line is that ends a doorway [cells], 0 where it is a filled wall."""
    across, most = np.array([-along[1], along[0]]), _LINE_M / cell_m
    starts = end + np.array([[-reach], [0.0], [reach]]) * across + 0.5 * along
    thick = float(np.median(run_lengths(ink, False, starts, along, most)))
    return thick if thick < most else 0.0


def _is_between(room: Mask, way: _Doorway, cell_m: float) -> bool:
    """Tell whether there is a room on both sides of a doorway."""
    places = np.arange(0.0, way.length + 1.0)
    reach = np.array(_BESIDE_M)[:, None] / cell_m
    beside = (way.at(places[None], at) for at in (way.low - reach, way.high + reach))
    return all(float(np.mean(values_at(room, rc, 0.0))) > _ROOM_SHARE for rc in beside)


def _lines(ink: Mask, way: _Doorway) -> int:
    """Return how many lines close a doorway, 0 where nothing does or more than lines."""
    offsets = np.arange(way.low - 1.0, way.high + 1.5, _STEP)
    places = np.arange(2.0, way.length - 1.0)
    if not len(places):
        return 0
    drawn = np.asarray(values_at(ink, way.at(places[None], offsets[:, None]), 0.0)) > 0
    # A line of one cell that runs askew lies between two rows of places.
    is_line = (drawn | np.roll(drawn, -1, axis=0)).mean(axis=1) >= _DRAWN
    starts = np.count_nonzero(np.diff(np.concatenate([[0], is_line.astype(np.int8)])) == 1)
    near = grown(is_line[:, None], round(1.0 / _STEP))[:, 0]
    is_cluttered = not near.all() and drawn[~near].mean() > _EMPTY
    thickness = _STEP * len(offsets) * float(np.mean(drawn))
    is_thick = thickness > _THIN * (way.high - way.low) * float(max(1, int(starts)))
    return 0 if is_cluttered or is_thick or is_line.all() else int(starts)


def _swing(near: Mask, way: _Doorway) -> _Swing | None:
    """Return the leaf that stands open in a doorway, or both; None where none is drawn."""
    leaves = _hypotheses(way)
    swept = _shown(near, way, leaves)
    is_whole = leaves[:, 0] > 0.75 * way.length
    chosen = _best(swept, is_whole, leaves[:, 1] == 0.0)
    if not len(chosen):
        is_alone = (swept == 0.0) & is_whole & (leaves[:, 4] == _OPEN_RAD[0])
        return _Swing(np.zeros((0, 2)), False) if is_alone.any() else None
    parts = [_strokes(way, *leaves[k]) for k in chosen]
    return _Swing(np.concatenate(parts), True)


def _shown(near: Mask, way: _Doorway, leaves: Array) -> Array:
    """
    Return how much of the arcs of ``leaves (N, 5)`` is drawn (N,); 0 if only the leaf is, else -1.

    What lies beside a leaf and within its arc is mostly blank, or it is a pattern.
    """
    share = np.linspace(0.0, 1.0, _PLACES)
    out, turn = 0.2 + 0.75 * share, 0.1 + 0.85 * share

    def drawn(chosen: Array, angle: Array | float, length: Array | float) -> Array:
        """Return the share (N,) of places at angles from the doorway, lengths from the hinge."""
        radius, hinge, side, at, _ = chosen.T[:, :, None]
        u, v = radius * length * np.cos(angle), radius * length * np.sin(angle)
        places = way.at(hinge + np.where(hinge == 0.0, u, -u), at + side * v)
        return np.asarray(marked(near, places, False).mean(axis=1))

    found = np.full(len(leaves), -1.0)
    is_leaf = np.flatnonzero(drawn(leaves, leaves[:, 4:], out) >= _SWEPT)
    if not len(is_leaf):
        return found
    leaves = leaves[is_leaf]
    opened = leaves[:, 4:]
    before, after = (drawn(leaves, opened + by, out) for by in (-_BESIDE_RAD, _BESIDE_RAD))
    arc, inner = (drawn(leaves, opened * turn, length) for length in (1.0, _SHORTER))
    is_arc = (arc >= _SWEPT) & (inner < _BARE)
    is_alone = np.maximum(before, after) < _BARE
    found[is_leaf[is_alone]] = np.where(is_arc, arc, 0.0)[is_alone]
    return found


def _strokes(
    way: _Doorway, radius: float, hinge: float, side: float, at: float, opened: float
) -> Array:
    """Return places (N, 2) on a leaf and its arc."""
    steps = np.linspace(_STUB_CELLS / radius, 1.0, int(2.0 * radius) + 2)
    turn = np.concatenate([opened * steps, np.full_like(steps, opened)])
    length = np.concatenate([np.full_like(steps, radius), radius * steps])
    ahead = 1.0 if hinge == 0.0 else -1.0
    return way.at(hinge + ahead * length * np.cos(turn), at + side * length * np.sin(turn))


def _hypotheses(way: _Doorway) -> Array:
    """Return the leaves (N, 5) that there may be: length, hinge, side, face, how far open."""
    length, hinge, side, face, opened = _LEAVES
    at = (1.0 - face) * way.low + face * way.high
    return np.stack([way.length * length, way.length * hinge, side, at, opened], axis=1)


def _best(swept: Array, is_whole: Mask, is_first: Mask) -> list[int]:
    """Return which leaves are drawn: the best of one, else the best two that meet; or none."""
    groups = (is_whole,), (~is_whole & is_first, ~is_whole & ~is_first)
    for group in groups:
        best = [int(np.argmax(np.where(mask, swept, -1.0))) for mask in group]
        if all(swept[k] > 0.0 for k in best):
            return best
    return []


def _fill(way: _Doorway, filled: NDArray[np.uint8]) -> None:
    """Mark the cells of ``filled (H, W)`` between the jambs of a doorway."""
    along = np.array([1.0, way.length - 1.0, way.length - 1.0, 1.0])
    across = np.array([way.low - 1.0, way.low - 1.0, way.high + 1.0, way.high + 1.0])
    corners = np.rint(way.at(along, across)[:, ::-1]).astype(np.int32)
    cv2.fillConvexPoly(filled, corners, 1)
