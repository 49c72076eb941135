# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Door symbols in doorways: thresholds (sills) drawn between the jambs, leaves and their arcs.

A sill looks like a wall, except that the walls at its ends are thicker. The module therefore
removes lines, finds gaps in the remaining walls, and takes a gap between two rooms that thin lines
close as a doorway. Windows are drawn alike. If more than half of the closed gaps in outer walls
show the same number of lines, and no fewer of them than inner gaps, that number marks a window,
and such a gap needs a leaf to be a doorway. In a known doorway a leaf has few possible poses, so
it is found even where letters or furniture cross it.
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

# Physical: range of doorway widths and largest wall thickness in a building [m], allowing for a
# scale wrong by a half.
_WIDTH_M, _THICKEST_M = (0.5, 3.0), 0.8
# Fitted by hand to the development split's plans (notes/segmentation.md): wider doorways have a
# drawn leaf [m].
_LEAFLESS_M = 1.5
# Numerical: symbols are searched for at cells of about this size [m].
_WORK_M = 0.02
# Numerical: lines are thinner than this many cells.
_SIDES = (2, 3, 4, 6, 8)
# Fitted by hand to the development split's plans (notes/segmentation.md): thinner walls cannot be
# told from lines; without a leaf, with one.
_LEAST_CELLS, _LEAST_LEAFED_CELLS = 4.0, 2.5
# Chosen, not measured:
_LINE_M = 0.18  # lines are also thinner than this [m]
_HOLLOW_M = 0.5  # narrower enclosed spaces are the inside of walls drawn as two lines [m]
_PLAIN = 0.8  # least share of its rectangle that the inside of a doorway with two sills fills
_DRAWN = 0.8  # least drawn share of a line's length
_EMPTY = 0.25  # largest drawn share of the rest of a doorway: a leaf's end, a jamb's rounding
_THIN = 0.5  # largest thickness of a single sill over its wall's
_MOST_LINES = 2
_BESIDE_M = (0.25, 0.45)  # depths on both sides of a doorway where room cells are checked [m]
_ROOM_SHARE = 0.6  # least share of room cells there
_WINDOWS = 0.5  # more than this share of the closed gaps in outer walls marks windows
_OPEN_RAD = (0.5 * np.pi, 0.25 * np.pi)  # drawn opening angles of leaves
_SWEPT, _BARE = 0.9, 0.5  # least drawn share of a leaf and an arc, largest one beside them
_SHORTER, _BESIDE_RAD = 0.8, 0.2  # places beside: arc radius factor, turn of the leaf
_LENGTHS = (0.94, 0.97, 1.0, 1.03, 1.06)  # leaf lengths over the doorway's width
_LOOSE_M = 0.03  # position tolerance of leaves and arcs [m]
_STUB_CELLS = 1.5  # length kept of a leaf at its hinge and of an arc at its jamb
_STEP = 0.5  # numerical: sampling step in a doorway [cells]
_PLACES = 14  # numerical: samples along a leaf and an arc
# Leaf hypotheses (5, N): length and hinge over the doorway's length, side, wall face from low (0)
# to high (1), opening angle.
_LEAVES = np.stack(
    np.meshgrid(np.outer([1.0, 0.5], _LENGTHS), (0, 1), (-1, 1), (0.0, 0.5, 1.0), _OPEN_RAD)
).reshape(5, -1)


@dataclass(frozen=True, eq=False)
class _Doorway:
    """
    A possible doorway, in cells.

    It starts at ``start (2,)`` and extends ``along (2,)`` for ``length``, through a wall from
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
        """Return the places (..., 2) at offsets ``along`` and ``across``."""
        return np.asarray(
            self.start + along[..., None] * self.along + across[..., None] * self.across
        )


@dataclass(frozen=True, eq=False)
class _Swing:
    """Open leaves of a door: places (N, 2) on them and on their arcs."""

    places: Array
    has_arc: bool


def doorway_symbols(ink: Mask, room: Mask, cell_m: float) -> Mask:
    """
    Return the cells (H, W) of sills, leaves and arcs that close doorways between rooms.

    Parameters
    ----------
    ink : (H, W), drawn cells
    room : (H, W), free space inside the building
    cell_m : approximate cell edge [true metres]
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
    """Return labels (H, W) of a drawing's enclosed spaces, and which are narrower than a room."""
    spaces, figures = pieces_of(~ink, connectivity=4)
    _, widest = label_figures(spaces, cells_to_nearest(ink), len(figures))
    is_hollow = 2.0 * widest * cell_m < _HOLLOW_M
    is_hollow[0] = False
    return spaces, is_hollow


def _wall_masks(ink: Mask, hollow: Mask, cell_m: float) -> Iterator[Mask]:
    """Yield ``ink`` (H, W) without lines of each width, hollow walls not filled and filled."""
    for side in _SIDES:
        if side > _SIDES[0] and side * cell_m > _LINE_M:
            return
        for mask in (ink, ink | hollow):
            walls = opened_by(mask, square(side))
            if walls.any():
                yield walls


def _in_gaps(ink: Mask, near: Mask, walls: Mask, room: Mask, cell_m: float, pen: int) -> Mask:
    """Return the drawn symbols (H, W) in and before the gaps of ``walls (H, W)``."""
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
    # The pen covers the lines of leaves and arcs; walls that they touch are kept.
    return (grown(strokes, pen) & ~grown(walls, 1)) | (filled > 0)


def _windows(lines: list[int], is_inner: list[bool]) -> set[int]:
    """Return the numbers of lines that mark windows, from the closed inner and outer gaps."""
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
    """Return the range across a gap that the walls at both ends span; None if there is none."""
    across = np.array([[along[1], -along[0]], [-along[1], along[0]]])
    starts = ends + 1.5 * np.array([[-1.0], [1.0]]) * along
    runs = run_lengths(walls, False, starts[:, None], across, most).min(axis=0)
    low, high = max(-most, -float(runs[0])), min(most, float(runs[1]))
    return (low, high) if _LEAST_LEAFED_CELLS <= high - low < most else None


def _hollow_doorways(
    ink: Mask, spaces: NDArray[np.int32], is_hollow: Mask, cell_m: float
) -> Iterator[_Doorway]:
    """
    Yield insides of hollow walls (H, W) that may be doorways with two sills.

    Each extends to the middle of the lines that form its jambs, where leaves are hinged.
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
    """Return the thickness of the line that ends a doorway [cells], 0 for a filled wall."""
    across, most = np.array([-along[1], along[0]]), _LINE_M / cell_m
    starts = end + np.array([[-reach], [0.0], [reach]]) * across + 0.5 * along
    thick = float(np.median(run_lengths(ink, False, starts, along, most)))
    return thick if thick < most else 0.0


def _is_between(room: Mask, way: _Doorway, cell_m: float) -> bool:
    """Return whether there is a room on both sides of a doorway."""
    places = np.arange(0.0, way.length + 1.0)
    reach = np.array(_BESIDE_M)[:, None] / cell_m
    beside = (way.at(places[None], at) for at in (way.low - reach, way.high + reach))
    return all(float(np.mean(values_at(room, rc, 0.0))) > _ROOM_SHARE for rc in beside)


def _lines(ink: Mask, way: _Doorway) -> int:
    """Return the number of lines that close a doorway, 0 if it is open or otherwise blocked."""
    offsets = np.arange(way.low - 1.0, way.high + 1.5, _STEP)
    places = np.arange(2.0, way.length - 1.0)
    if not len(places):
        return 0
    drawn = np.asarray(values_at(ink, way.at(places[None], offsets[:, None]), 0.0)) > 0
    # An oblique line of one cell falls between two rows of samples.
    is_line = (drawn | np.roll(drawn, -1, axis=0)).mean(axis=1) >= _DRAWN
    starts = np.count_nonzero(np.diff(np.concatenate([[0], is_line.astype(np.int8)])) == 1)
    near = grown(is_line[:, None], round(1.0 / _STEP))[:, 0]
    is_cluttered = not near.all() and drawn[~near].mean() > _EMPTY
    thickness = _STEP * len(offsets) * float(np.mean(drawn))
    is_thick = thickness > _THIN * (way.high - way.low) * float(max(1, int(starts)))
    return 0 if is_cluttered or is_thick or is_line.all() else int(starts)


def _swing(near: Mask, way: _Doorway) -> _Swing | None:
    """Return the open leaf or pair of leaves drawn in a doorway; None without one."""
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
    Return the drawn share of the arcs of ``leaves (N, 5)``, (N,): 0 for a bare leaf, -1 for none.

    The places beside a leaf and within its arc must be mostly blank; otherwise it is a pattern.
    """
    share = np.linspace(0.0, 1.0, _PLACES)
    out, turn = 0.2 + 0.75 * share, 0.1 + 0.85 * share

    def drawn(chosen: Array, angle: Array | float, length: Array | float) -> Array:
        """Return the drawn share (N,) at angles from the doorway and distances from the hinge."""
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
    """Return the leaf hypotheses (N, 5): length, hinge, side, face offset, opening angle."""
    length, hinge, side, face, opened = _LEAVES
    at = (1.0 - face) * way.low + face * way.high
    return np.stack([way.length * length, way.length * hinge, side, at, opened], axis=1)


def _best(swept: Array, is_whole: Mask, is_first: Mask) -> list[int]:
    """Return the drawn leaves: the best single one, else the best pair that meets, else none."""
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
