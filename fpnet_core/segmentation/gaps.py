# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Gaps in walls: openings of any width between the ends of walls.

Clearance alone cannot find them: where a cubicle's opening is wider than the corridor in front,
the clearance has no saddle there.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry.distinct import first_distinct
from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.rays import cells_at, draw_line, marked, run_lengths
from fpnet_core.segmentation.openings import MIN_DOOR_WIDTH_M, THICK_WALL_M, Opening

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

# Numerical: wider openings between the ends of walls are ignored [m]; a learned model decides
# which of the others divide rooms.
GAP_WIDTH_M = 6.0

# Chosen, not measured:
# Tolerance to which wall outlines are straightened before corners are detected [m].
_STRAIGHTEN_M = 0.08
# Cells of a face this near to its corners are not used for its direction [m].
_SKIP_M = 0.15
# A wall ends where its outline turns by more than this [rad].
_TURN_RAD = math.radians(40.0)
_BACK_RAD = math.radians(175.0)
# Where it turns by less than this, the wall bends, as in halls with cut-off corners: the gap
# square to the wall beyond the bend is narrower than the one straight on [rad]. Both faces must
# have at least this length, which excludes clutter in drawings [m].
_BEND_RAD, _BENT_M = math.radians(65.0), 1.0
# Least length of the face that is continued, and of the wall behind its end [m].
_FACE_M = 0.3
# The face is continued from this far inside the wall, to meet the opposite wall [m].
_INSET_M = 0.05
# At one third, two thirds and all of the first distance from the gap, the space must be wider than
# the gap by the second, at two or more of its four corners [m]. A line across a corridor fails
# this.
_DEPTH_M, _WIDER_M = 1.0, 0.25
_DEPTHS = 3  # numerical
_BITS = 20  # numerical: bits of a cell's row and column in a key that also holds its outline
_MIN_OPEN_CORNERS = 2
# A room is searched for at most this far from the gap [m].
_ROOM_REACH_M = 0.5


def _open_corners(
    free: Mask, middles: Array, along: Array, across: Array, limits: Array, depth: float
) -> Cells:
    """Count the corners of gaps (N,) behind which free space extends beyond their jambs."""
    sides = np.array([-1.0, 1.0])[:, None]
    is_deep = run_lengths(free, False, middles[:, None], sides * across[:, None], depth) >= depth
    depths = np.arange(1, _DEPTHS + 1)[:, None, None, None, None]
    offsets = depth / _DEPTHS * depths * sides[:, None]
    starts = middles[:, None, None] + offsets * across[:, None, None]  # depth, gap, side, end
    wide = run_lengths(free, False, starts, sides * along[:, None, None], limits[:, None, None])
    is_open = (wide >= limits[:, None, None]).all(axis=0)
    return np.where(is_deep.all(axis=1), is_open.sum(axis=(1, 2)), 0)


def _gaps_from(free: Mask, solid: Mask, starts: Array, cell_m: float) -> Array:
    """
    Continue wall faces to the next wall; return the ends (N, 2, 2) of the gaps.

    ``starts (S, 4, 2)`` is a corner, the direction of the face that ends there, the direction into
    the wall and the search direction of the gap.
    """
    inset, face = _INSET_M / cell_m, _FACE_M / cell_m
    corners, along, into, ahead = starts.swapaxes(0, 1)
    places = corners + inset * (into - along)
    is_off = ~marked(solid, places, True)
    places[is_off] = (corners - inset * along)[is_off]
    is_face = run_lengths(solid, True, places, -along, face - inset) >= face - inset
    places, ahead = places[is_face], ahead[is_face]
    skin = run_lengths(solid, True, places, ahead, 4.0 * inset + 2.0)
    places = places + skin[:, None] * ahead
    lengths = run_lengths(free, False, places, ahead, GAP_WIDTH_M / cell_m + 1.0)
    ends = places + lengths[:, None] * ahead
    is_gap = (lengths * cell_m >= MIN_DOOR_WIDTH_M) & (lengths <= GAP_WIDTH_M / cell_m)
    is_gap &= marked(solid, ends, True)
    places, ends, ahead, lengths = places[is_gap], ends[is_gap], ahead[is_gap], lengths[is_gap]
    across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    limits = 0.5 * lengths + _WIDER_M / cell_m
    middles, depth = 0.5 * (places + ends), _DEPTH_M / cell_m
    is_open = _open_corners(free, middles, ahead, across, limits, depth) >= _MIN_OPEN_CORNERS
    return np.stack([places - 0.5 * ahead, ends - 0.5 * ahead], axis=1)[is_open]


def find_gaps(free: Mask, solid: Mask, cell_m: float) -> list[Array]:
    """
    Find the openings at which walls end.

    From a corner where a wall ends, its face is continued straight on to the next wall. This is a
    gap if the space widens behind two of its corners. A line across a corridor also continues
    walls, but the corridor behind it is as wide as the line.

    Parameters
    ----------
    free, solid : (H, W) bool; cells that are neither are unseen, and no gap ends there
    cell_m : cell edge [true metres]

    Returns
    -------
    list of ends (2, 2) in fractional cells, narrowest gap first; no two cross each other
    """
    candidates = _gaps_from(free, solid, _wall_ends(free, cell_m), cell_m)
    lengths = np.hypot(*(candidates[:, 1] - candidates[:, 0]).T)
    candidates = candidates[np.argsort(lengths, kind='stable')]
    apart = THICK_WALL_M / cell_m  # nearer gaps are the two faces of one wall

    def is_same(index: int, others: Cells) -> Mask:
        return _is_same_gap(candidates[index], candidates[others], apart)

    return list(candidates[first_distinct(len(candidates), is_same)])


def _wall_ends(free: Mask, cell_m: float) -> Array:
    """Return the wall ends of the outlines, the ``starts`` (S, 4, 2) of :func:`_gaps_from`."""
    blocked = np.pad((~free).astype(np.uint8), 1, constant_values=1)
    contours, _ = cv2.findContours(blocked, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    epsilon = max(1.0, _STRAIGHTEN_M / cell_m)
    outlines, rings = [], []
    for contour in contours:
        corners = cv2.approxPolyDP(contour, epsilon, closed=True)
        if len(corners) >= 2:
            outlines.append(contour[:, 0, ::-1].astype(np.int64) - 1)
            rings.append(corners[:, 0, ::-1].astype(np.int64) - 1)
    return _ends_of_faces(outlines, rings, cell_m) if rings else np.zeros((0, 4, 2))


def _ends_of_faces(outlines: list[Cells], rings: list[Cells], cell_m: float) -> Array:
    """Return the ``starts`` of :func:`_gaps_from` for the faces between corners of outlines."""
    counts = np.array([len(ring) for ring in rings])
    begins = np.repeat(np.cumsum(counts) - counts, counts)
    local = np.arange(len(begins)) - begins
    size = np.repeat(counts, counts)
    before, after = begins + (local - 1) % size, begins + (local + 1) % size
    ring = np.concatenate(rings).astype(np.float64)
    edges = ring[after] - ring
    lengths = np.hypot(*edges.T)
    # A thin spur's outline may visit a cell twice: such a face has no length and no direction.
    edges /= np.maximum(lengths, 1.0)[:, None]
    centres, along = _lines(outlines, counts, *_places(outlines, rings), edges, _SKIP_M / cell_m)
    turns = np.arctan2(
        along[before, 0] * along[:, 1] - along[before, 1] * along[:, 0],
        (along[before] * along).sum(axis=1),
    )
    # Outlines turn one way at convex walls; a wall of one cell turns back on itself.
    is_end = (turns >= _TURN_RAD) | (np.abs(turns) >= _BACK_RAD)
    is_bent = (turns > 0.0) & (turns < _BEND_RAD)
    is_bent &= np.minimum(lengths, lengths[before]) >= _BENT_M / cell_m
    own = np.arange(len(ring))
    starts = np.empty((len(ring), 2, 4, 2))
    is_kept = np.empty((len(ring), 2), np.bool_)
    for which, (sign, face, beyond) in enumerate(((1.0, before, own), (-1.0, own, before))):
        ahead = sign * along[face]
        off = ((ring - centres[face]) * ahead).sum(axis=1)
        starts[:, which, 0] = centres[face] + off[:, None] * ahead
        starts[:, which, 1] = ahead
        starts[:, which, 2] = np.stack([-along[face, 1], along[face, 0]], axis=1)
        square = np.stack([along[beyond, 1], -along[beyond, 0]], axis=1)
        starts[:, which, 3] = np.where(is_bent[:, None], square, ahead)
        is_kept[:, which] = is_end & (lengths[face] >= _FACE_M / cell_m)
    return starts[is_kept]


def _places(outlines: list[Cells], rings: list[Cells]) -> tuple[Cells, Cells]:
    """
    Return each corner's index in its outline's cells (R,), and that of the ring's next corner.

    Indices exceed the outline's length where corners on cells visited twice require it.
    """
    corners, cells = np.concatenate(rings) + 1, np.concatenate(outlines) + 1  # none is negative
    is_corner = np.zeros(corners.max(axis=0) + 1, np.bool_)
    is_corner[tuple(corners.T)] = True
    is_within = np.flatnonzero((cells < is_corner.shape).all(axis=1))
    visits = is_within[is_corner[tuple(cells[is_within].T)]]
    sizes, counts = (np.array([len(part) for part in parts]) for parts in (outlines, rings))
    begins = np.cumsum(sizes) - sizes
    each = np.arange(len(sizes))
    keys = _numbered(np.repeat(each, sizes)[visits], cells[visits])
    order = np.argsort(keys, kind='stable')
    wanted = _numbered(np.repeat(each, counts), corners)
    low, high = (np.searchsorted(keys[order], wanted, side).tolist() for side in ('left', 'right'))
    visited = visits[order].tolist()
    first, last, corner = [], [], 0
    for begin, size, count in zip(begins.tolist(), sizes.tolist(), counts.tolist(), strict=True):
        at, places = 0, []
        for k in range(corner, corner + count):
            if high[k] - low[k] == 1:
                at += (visited[low[k]] - begin - at) % size
            else:
                at += min((visit - begin - at) % size for visit in visited[low[k] : high[k]])
            places.append(at)
        corner += count
        first += places
        last += [*places[1:], places[0] + size]
    return np.array(first), np.array(last)


def _numbered(outline: Cells, cells: Cells) -> Cells:
    """Return a unique key (N,) for each cell (N, 2) of each outline (N,)."""
    return (outline << _BITS | cells[:, 0]) << _BITS | cells[:, 1]


def _lines(
    outlines: list[Cells], counts: Cells, first: Cells, last: Cells, edges: Array, skip: float
) -> tuple[Array, Array]:
    """
    Return centres and directions (R, 2) of least-squares lines, oriented as ``edges (R, 2)``.

    Each line fits an outline's cells from ``first (R,)`` to ``last``, without those near its ends;
    ``counts`` are the corners per outline.
    """
    each = np.repeat(np.arange(len(counts)), counts)
    sizes = np.array([len(outline) for outline in outlines])
    size, begin = sizes[each], (np.cumsum(sizes) - sizes)[each]
    cells = np.concatenate(outlines)
    r, c = cells.T
    sums = np.zeros((len(cells) + 1, 5), np.int64)
    np.cumsum(np.stack([r, c, r * r, r * c, c * c], axis=1), axis=0, out=sums[1:])

    def before(place: Cells) -> Cells:
        rounds, at = np.divmod(place, size)
        whole = rounds[:, None] * (sums[begin + size] - sums[begin])
        return np.asarray(whole + sums[begin + at] - sums[begin])

    margin = np.minimum(int(skip), (last - first) // 4)
    n = np.maximum(last - first - 2 * margin + 1, 0)
    s_r, s_c, s_rr, s_rc, s_cc = (before(last - margin + 1) - before(first + margin)).T
    origin = cells[begin + first % size]
    r, c = origin.T
    # Relative to the face's first cell, in integers: no rounding yet.
    s_rr, s_cc = s_rr - 2 * r * s_r + n * r * r, s_cc - 2 * c * s_c + n * c * c
    s_rc = s_rc - r * s_c - c * s_r + n * r * c
    s_r, s_c, least = s_r - n * r, s_c - n * c, np.maximum(n, 1)
    v_rr, v_rc, v_cc = s_rr - s_r * s_r / least, s_rc - s_r * s_c / least, s_cc - s_c * s_c / least
    # A spur's outline may have passed a corner on its other visit of the cell: no cells are left.
    is_known = n > 0
    centres = origin + np.where(is_known, [s_r, s_c] / least, 0.0).T
    angles = 0.5 * np.arctan2(2.0 * v_rc, v_cc - v_rr)
    along = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    along[(along * edges).sum(axis=1) <= 0.0] *= -1.0
    is_line = is_known & (v_rr + v_cc != 0.0)
    return centres, np.where(is_line[:, None], along, edges)


def _is_same_gap(line: Array, others: Array, apart: float) -> Mask:
    """Return which of ``others (N, 2, 2)`` cross a line (2, 2) or share its middle."""
    offsets = line.sum(axis=0) - others.sum(axis=1)
    (p, q), r, s = line, others[:, 0], others[:, 1]
    is_crossed = (_side(p, q, r) * _side(p, q, s) < 0.0) & (_side(r, s, p) * _side(r, s, q) < 0.0)
    return np.asarray((np.hypot(*offsets.T) < 2.0 * apart) | is_crossed)


def _side(p: Array, q: Array, r: Array) -> Array:
    """Return the signed area whose sign is the side of the line p-q on which r lies."""
    along, off = q - p, r - p
    return np.asarray(along[..., 0] * off[..., 1] - along[..., 1] * off[..., 0])


def closed_cells(shape: tuple[int, int], gaps: list[Array]) -> Mask:
    """Return the cells (H, W) of lines that no region crosses."""
    closed = np.zeros(shape, dtype=np.uint8)
    for ends in gaps:
        draw_line(closed, ends)
    return closed.astype(bool)


def labels_beside(labels: NDArray[np.int32], places: Array, across: Array, reach: float) -> Cells:
    """
    Return labels (2, R, S) on both sides of ``places (S, 2)`` on lines.

    They are sampled 1, 2, ... cells ``across (S, 2)``, up to ``reach``; beyond the raster the
    edge's label is repeated.
    """
    offsets = np.arange(1, int(np.ceil(reach + 1.0)))[:, None, None] * across
    both = np.stack([places - offsets, places + offsets])
    return labels[cells_at(both, labels.shape)].astype(np.int64)


def openings_across(gaps: list[Array], labels: NDArray[np.int32], cell_m: float) -> list[Opening]:
    """
    Return the openings between different rooms of ``labels (H, W)`` along ``gaps``.

    A gap that a partition meets gives one opening on either side of the partition.
    """
    if not gaps:
        return []
    ends = np.array(gaps)
    along = ends[:, 1] - ends[:, 0]
    lengths = np.hypot(*along.T)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / lengths[:, None]
    counts = np.maximum(np.rint(lengths).astype(np.int64), 3)
    gap = np.repeat(np.arange(len(gaps)), counts)
    shares = (np.arange(len(gap)) - (np.cumsum(counts) - counts)[gap]) / (counts[gap] - 1)
    places = ends[gap, 0] + shares[:, None] * along[gap]
    beside = labels_beside(labels, places, across[gap], _ROOM_REACH_M / cell_m)
    # The first label on each side, 0 for none.
    nearest = np.argmax(beside > 0, axis=1)[:, None]
    pairs = np.take_along_axis(beside, nearest, axis=1)[:, 0].T
    gap, rooms, first, last = _stretches(gap, shares, pairs)
    parts = ends[gap, :1] + np.stack([first, last], axis=1)[..., None] * along[gap, None]
    widths = np.hypot(*(parts[:, 1] - parts[:, 0]).T)
    is_opening = (rooms[:, 0] != rooms[:, 1]) & (widths * cell_m >= MIN_DOOR_WIDTH_M)
    sorted_rooms = np.sort(rooms[is_opening], axis=1).tolist()
    found = zip(sorted_rooms, parts[is_opening], widths[is_opening].tolist(), strict=True)
    return [Opening((low, high), part, 0.5 * width * cell_m) for (low, high), part, width in found]


def _stretches(gap: Cells, shares: Array, pairs: Cells) -> tuple[Cells, Cells, Array, Array]:
    """
    Return gap (N,), rooms (N, 2), begin and end (N,) of runs of equal ``pairs (S, 2)``.

    Begin and end are shares of the gap. Places without rooms on both sides join adjacent runs.
    """
    is_both = pairs.min(axis=1) > 0
    has_both = np.bincount(gap, is_both) > 0
    known = np.flatnonzero(is_both | ~has_both[gap])
    gap, shares, pairs = gap[known], shares[known], pairs[known]
    is_other = np.diff(gap) != 0
    begin = np.flatnonzero(np.r_[True, is_other | (np.diff(pairs, axis=0) != 0).any(axis=1)])
    end = np.r_[begin[1:] - 1, len(known) - 1]
    first = np.where(np.r_[True, is_other][begin], 0.0, shares[begin])
    last = np.where(np.r_[is_other, True][end], 1.0, shares[end])
    return gap[begin], pairs[begin], first, last
