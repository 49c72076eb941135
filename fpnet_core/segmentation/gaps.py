# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Gaps in walls: openings told by the walls that end at them, however wide they are.

Clearance alone cannot see them: where a cubicle's mouth is wider than the corridor in front,
no saddle lies in the mouth.
"""

from __future__ import annotations

from collections.abc import Iterator
import math

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.rays import draw_line, is_inside, run_length
from fpnet_core.segmentation.openings import MIN_DOOR_WIDTH_M, Opening

# Numerical: wider openings between the ends of walls are not looked at [m]; which of the others
# part rooms is learned.
GAP_WIDTH_M = 6.0

# Chosen, not measured:
# Outlines of walls are straightened by so much before their corners are looked for [m].
_STRAIGHTEN_M = 0.08
# A face's cells so near to its corners say nothing about its direction [m].
_SKIP_M = 0.15
# Where a wall ends its outline turns by more than this [rad].
_TURN_RAD = math.radians(40.0)
_BACK_RAD = math.radians(175.0)
# Where it turns by less the wall does not end but bends, as halls with cut-off corners do: square
# to the wall beyond the bend the gap is narrower than straight on [rad]. Both its faces are at
# least so long, as those of what clutters a drawing are not [m].
_BEND_RAD, _BENT_M = math.radians(65.0), 1.0
# The face that is continued is at least so long, and so much wall lies behind its end [m].
_FACE_M = 0.3
# The face is continued from so far inside the wall, to meet the wall on the other side [m].
_INSET_M = 0.05
# At a third, two thirds and all of this distance from the gap the space is wider than the gap
# by the second length, at two of its four corners at least [m]: a line across a corridor has none.
_DEPTH_M, _WIDER_M = 1.0, 0.25
_DEPTHS = 3  # numerical
_MIN_OPEN_CORNERS = 2
# Gaps whose middles are nearer than this are the two faces of one wall [m].
_SAME_GAP_M = 0.6
# A room is looked for at this distance from the gap at most [m].
_ROOM_REACH_M = 0.5


@njit(cache=True)
def _open_corners(
    free: NDArray[np.bool_],
    row: float,
    col: float,
    along: tuple[float, float],
    across: tuple[float, float],
    length: float,
    depth: float,
    wider: float,
) -> int:
    """Count the corners of a gap behind which there is free space beyond its jamb."""
    limit = 0.5 * length + wider
    count = 0
    for side in (-1.0, 1.0):
        d_row, d_col = side * across[0], side * across[1]
        if run_length(free, False, row, col, d_row, d_col, depth) < depth:
            return 0
        for end in (-1.0, 1.0):
            is_open = True
            for k in range(1, _DEPTHS + 1):
                offset = side * depth * k / _DEPTHS
                r, c = row + offset * across[0], col + offset * across[1]
                if run_length(free, False, r, c, end * along[0], end * along[1], limit) < limit:
                    is_open = False
                    break
            count += is_open
    return count


@njit(cache=True)
def _gaps_from(
    free: NDArray[np.bool_],
    solid: NDArray[np.bool_],
    starts: NDArray[np.float64],
    cell_m: float,
    longest: float,
    found: NDArray[np.float64],
) -> int:
    """
    Continue walls' faces to the next wall; write the gaps' ends to ``found (S, 4)``, count them.

    ``starts (S, 8)`` is a corner (row, col), the direction of the face that ends there, the
    direction into the wall and the direction in which the gap is looked for.
    """
    inset, face = _INSET_M / cell_m, _FACE_M / cell_m
    depth, wider = _DEPTH_M / cell_m, _WIDER_M / cell_m
    count = 0
    for k in range(len(starts)):
        row, col, d_row, d_col, n_row, n_col, g_row, g_col = starts[k]
        r, c = row + inset * (n_row - d_row), col + inset * (n_col - d_col)
        if not is_inside(solid, r, c, True):
            r, c = row - inset * d_row, col - inset * d_col
        if run_length(solid, True, r, c, -d_row, -d_col, face - inset) < face - inset:
            continue
        skin = run_length(solid, True, r, c, g_row, g_col, 4.0 * inset + 2.0)
        r, c = r + skin * g_row, c + skin * g_col
        length = run_length(free, False, r, c, g_row, g_col, longest + 1.0)
        if length * cell_m < MIN_DOOR_WIDTH_M or length > longest:
            continue
        far_r, far_c = r + length * g_row, c + length * g_col
        if not is_inside(solid, far_r, far_c, True):
            continue
        mid_r, mid_c = 0.5 * (r + far_r), 0.5 * (c + far_c)
        along, across = (g_row, g_col), (-g_col, g_row)
        if _open_corners(free, mid_r, mid_c, along, across, length, depth, wider) < (
            _MIN_OPEN_CORNERS
        ):
            continue
        found[count, 0], found[count, 1] = r - 0.5 * g_row, c - 0.5 * g_col
        found[count, 2], found[count, 3] = far_r - 0.5 * g_row, far_c - 0.5 * g_col
        count += 1
    return count


def find_gaps(free: Mask, solid: Mask, cell_m: float) -> list[NDArray[np.float64]]:
    """
    Find the openings at which walls end.

    A wall's face is continued straight on from a corner where the wall ends until it meets
    another wall. That is a gap if the space widens behind two of its corners: a line across a
    corridor continues walls as well, but the corridor goes on as wide as the line.

    Parameters
    ----------
    free, solid : (H, W) bool; cells that are neither are unseen, and no gap ends there
    cell_m : cell edge [true metres]

    Returns
    -------
    list of ends (2, 2) in fractional cells, narrowest gap first; no two cross each other
    """
    starts = _wall_ends(free, cell_m)
    found = np.empty((len(starts), 4))
    longest = GAP_WIDTH_M / cell_m
    count = _gaps_from(free, solid, starts, cell_m, longest, found)
    candidates = found[:count].reshape(-1, 2, 2)
    lengths = np.hypot(*(candidates[:, 1] - candidates[:, 0]).T)
    candidates = candidates[np.argsort(lengths, kind='stable')]
    distinct = candidates[_distinct(candidates, _SAME_GAP_M / cell_m)]
    return list(distinct)


def _wall_ends(free: Mask, cell_m: float) -> NDArray[np.float64]:
    """Return the rows (S, 8) that :func:`_gaps_from` starts at: the outlines' wall ends."""
    blocked = np.pad((~free).astype(np.uint8), 1, constant_values=1)
    contours, _ = cv2.findContours(blocked, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    epsilon = max(1.0, _STRAIGHTEN_M / cell_m)
    starts = [np.zeros((0, 8))]
    for contour in contours:
        corners = cv2.approxPolyDP(contour, epsilon, closed=True)
        if len(corners) >= 2:
            outline = contour[:, 0, ::-1].astype(np.float64) - 1.0
            ring = corners[:, 0, ::-1].astype(np.float64) - 1.0
            starts.append(_ends_of_faces(outline, ring, cell_m))
    return np.concatenate(starts)


@njit(cache=True)
def _ends_of_faces(
    outline: NDArray[np.float64], ring: NDArray[np.float64], cell_m: float
) -> NDArray[np.float64]:
    """
    Return rows as of :func:`_wall_ends` for the faces between the corners ``ring`` of an outline.

    A face's direction is that of the line through its cells, less those near its corners.
    """
    least_face, bent, skip = _FACE_M / cell_m, _BENT_M / cell_m, _SKIP_M / cell_m
    count, size = len(ring), len(outline)
    places = np.empty(count + 1, dtype=np.int64)
    at = 0
    for k in range(count):
        while outline[at % size, 0] != ring[k, 0] or outline[at % size, 1] != ring[k, 1]:
            at += 1
        places[k] = at
    places[count] = places[0] + size
    faces = np.empty((count, 4))
    lengths = np.empty(count)
    for k in range(count):
        edge = ring[(k + 1) % count] - ring[k]
        lengths[k] = np.hypot(edge[0], edge[1])
        # A thin spur's outline may visit a cell twice: such a face has no length and no direction.
        faces[k] = _line(outline, places[k], places[k + 1], skip, edge / max(lengths[k], 1.0))
    rows = np.empty((2 * count, 8))
    found = 0
    for k in range(count):
        behind, ahead = faces[k - 1, 2:], faces[k, 2:]
        turn = np.arctan2(
            behind[0] * ahead[1] - behind[1] * ahead[0],
            behind[0] * ahead[0] + behind[1] * ahead[1],
        )
        # Outlines turn one way where the wall is convex; a wall of one cell turns back on itself.
        if turn < _TURN_RAD and abs(turn) < _BACK_RAD:
            continue
        for sign, face in ((1.0, k - 1), (-1.0, k)):
            if lengths[face] >= least_face:
                centre, along = faces[face, :2], sign * faces[face, 2:]
                rows[found, :2] = centre + (ring[k] - centre) @ along * along
                rows[found, 2:4] = along
                rows[found, 4], rows[found, 5] = -sign * along[1], sign * along[0]
                rows[found, 6:] = along
                if 0.0 < turn < _BEND_RAD and min(lengths[k], lengths[k - 1]) >= bent:
                    beyond = k if face == k - 1 else k - 1
                    rows[found, 6], rows[found, 7] = faces[beyond, 3], -faces[beyond, 2]
                found += 1
    return rows[:found]


@njit(cache=True)
def _line(
    outline: NDArray[np.float64], first: int, last: int, skip: float, edge: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return centre and direction (4,) of the least-squares line, pointing as ``edge`` does."""
    size = len(outline)
    margin = min(int(skip), (last - first) // 4)
    n, s_r, s_c, s_rr, s_rc, s_cc = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(first + margin, last - margin + 1):
        r, c = outline[k % size] - outline[first % size]
        n += 1
        s_r, s_c = s_r + r, s_c + c
        s_rr, s_rc, s_cc = s_rr + r * r, s_rc + r * c, s_cc + c * c
    line = np.empty(4)
    line[:2], line[2:] = outline[first % size], edge
    if n == 0:  # a spur's outline passed the corner on its other visit of the cell
        return line
    v_rr, v_rc, v_cc = s_rr - s_r * s_r / n, s_rc - s_r * s_c / n, s_cc - s_c * s_c / n
    line[:2] += np.array([s_r, s_c]) / n
    if v_rr + v_cc == 0.0:
        return line
    angle = 0.5 * np.arctan2(2.0 * v_rc, v_cc - v_rr)
    direction = np.array([np.sin(angle), np.cos(angle)])
    line[2:] = direction if direction @ edge > 0.0 else -direction
    return line


@njit(cache=True)
def _distinct(lines: NDArray[np.float64], apart: float) -> NDArray[np.bool_]:
    """Tell which ``lines (C, 2, 2)`` neither cross an earlier one nor share its middle."""
    kept = np.zeros(len(lines), dtype=np.bool_)
    for k in range(len(lines)):
        a = lines[k]
        is_new = True
        for j in range(k):
            b = lines[j]
            offset = a[0] + a[1] - b[0] - b[1]
            if kept[j] and (
                np.hypot(offset[0], offset[1]) < 2.0 * apart
                or (
                    _side(a[0], a[1], b[0]) * _side(a[0], a[1], b[1]) < 0.0
                    and _side(b[0], b[1], a[0]) * _side(b[0], b[1], a[1]) < 0.0
                )
            ):
                is_new = False
                break
        kept[k] = is_new
    return kept


@njit(cache=True)
def _side(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> float:
    """Return the signed area that tells on which side of the line p-q the point r lies."""
    return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))


def closed_cells(shape: tuple[int, int], gaps: list[NDArray[np.float64]]) -> Mask:
    """Return the cells (H, W) of lines that no region crosses."""
    closed = np.zeros(shape, dtype=np.uint8)
    for ends in gaps:
        draw_line(closed, ends)
    return closed.astype(bool)


@njit(cache=True, nogil=True)
def _labels_beside(
    labels: NDArray[np.int32], ends: NDArray[np.float64], reach: float
) -> NDArray[np.int64]:
    """
    Return for each cell of the line the first labels (S, 2) met on both sides, 0 for none.

    They are looked for up to ``reach`` cells away.
    """
    d_row, d_col = ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1]
    length = np.hypot(d_row, d_col)
    count = max(3, int(np.rint(length)))
    found = np.zeros((count, 2), np.int64)
    for k in range(count):
        share = k / (count - 1)
        for side in range(2):
            sign = -1.0 if side == 0 else 1.0
            for offset in range(1, int(np.ceil(reach + 1.0))):
                row = ends[0, 0] + share * d_row - sign * offset * d_col / length
                col = ends[0, 1] + share * d_col + sign * offset * d_row / length
                r = int(min(max(np.rint(row), 0), labels.shape[0] - 1))
                c = int(min(max(np.rint(col), 0), labels.shape[1] - 1))
                if labels[r, c] > 0:
                    found[k, side] = labels[r, c]
                    break
    return found


def openings_across(
    gaps: list[NDArray[np.float64]], labels: NDArray[np.int32], cell_m: float
) -> list[Opening]:
    """
    Return the openings between different rooms of ``labels (H, W)`` along ``gaps``.

    A gap onto which a partition opens is one opening on either side of the partition.
    """
    openings = []
    for ends in gaps:
        pairs = _labels_beside(labels, ends, _ROOM_REACH_M / cell_m)
        has_both = pairs.min(axis=1) > 0
        if has_both.any():
            pairs[~has_both] = -1
        for first, last, pair in _stretches(pairs):
            part = ends[0] + np.array([[first], [last]]) * (ends[1] - ends[0])
            width = float(np.hypot(*(part[1] - part[0])))
            if pair[0] != pair[1] and width * cell_m >= MIN_DOOR_WIDTH_M:
                low, high = sorted(pair)
                openings.append(Opening((low, high), part, 0.5 * width * cell_m))
    return openings


def _stretches(pairs: NDArray[np.int64]) -> Iterator[tuple[float, float, tuple[int, int]]]:
    """Yield begin, end (shares of the line) and rooms of equal rows; rows of -1 join either."""
    known = np.flatnonzero(pairs[:, 0] >= 0)
    steps = np.abs(np.diff(pairs[known], axis=0)).sum(axis=1)
    changes = np.flatnonzero(steps) + 1
    bounds = [0, *changes.tolist(), len(known)]
    last = len(bounds) - 2
    for k in range(len(bounds) - 1):
        begin, end = known[bounds[k]], known[bounds[k + 1] - 1]
        first = 0.0 if k == 0 else begin / (len(pairs) - 1)
        until = 1.0 if k == last else end / (len(pairs) - 1)
        yield first, until, (int(pairs[begin, 0]), int(pairs[begin, 1]))
