# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scan-to-map matching by branch and bound (Hess et al., ICRA 2016), here submap to plan.

The candidates are all rotations, allowed scales and translations of a grid. A pyramid of maxima
over growing windows gives an upper bound of the score of a block of translations, so the search
skips whole blocks and still returns the best candidate.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from fpnet_core.geometry import Affine2D, Similarity2D
from fpnet_core.pose import MapEvidence
from fpnet_lab.baselines.answer import Answer

CLAIM_SCORE = 0.6
"""Given: score from which a global match is accepted, published setting of Hess et al."""

# Chosen, not measured:
_MIN_SCORE = 0.45  # candidates below are discarded: bounds the search from the start
_SIGMA_M = 0.25
_STRIDE = 2  # numerical: subsampling of the plan's wall field, to cells of 0.2 m
_LEVELS = 7  # numerical: blocks of 64 x 64 cells at the top
_MAX_POINTS = 250  # numerical

Array = NDArray[np.float64]
Pyramid = NDArray[np.float32]


class BranchAndBound:
    """
    Localizer of submaps on one plan; the constructor builds the plan's pyramid once.

    Parameters
    ----------
    plan : evidence of the plan
    scales : (L,) plan metres per submap metre to try
    """

    def __init__(self, plan: MapEvidence, scales: Array) -> None:
        field = np.exp(-0.5 * (plan.wall_distance[::_STRIDE, ::_STRIDE] / _SIGMA_M) ** 2)
        self._pyramid = _pyramid(field.astype(np.float32))
        self._shape = field.shape
        self._A_rc_xy = plan.A_rc_xy / _STRIDE
        self._cell_m = plan.cell_m * _STRIDE
        self._scales = scales

    def place(self, sub: MapEvidence) -> Answer | None:
        """Return the placement with the most wall on wall; None if all scores are too low."""
        if len(sub.walls) == 0:
            return None
        step = max(1, len(sub.walls) // _MAX_POINTS)
        points = sub.walls[::step]
        centre = points.mean(axis=0)
        turned = self._turned(points - centre)
        row, col, variant, score = _search(
            self._pyramid, self._shape[0], self._shape[1], turned[0], np.float32(_MIN_SCORE)
        )
        if variant < 0:
            return None
        linear = turned[1][variant]
        placed = np.linalg.solve(self._A_rc_xy[:, :2], np.array([row, col]) - self._A_rc_xy[:, 2])
        S = Affine2D(linear, placed - linear @ centre)
        return Answer(S, float(score), is_accepted=bool(score >= CLAIM_SCORE))

    def _turned(self, points: Array) -> tuple[NDArray[np.int32], Array]:
        """Return the points' cells (V, P, 2) in every variant, and the linear maps (V, 2, 2)."""
        reach_m = float(np.linalg.norm(points, axis=1).max())
        turns = int(np.ceil(2.0 * np.pi * max(reach_m, 1.0) / self._cell_m))
        yaws = np.arange(turns) * (2.0 * np.pi / turns)
        linear = np.array(
            [Similarity2D.from_scale_yaw(s, a, [0, 0]).linear for s in self._scales for a in yaws]
        )
        cells = np.einsum('ij,vjk,pk->vpi', self._A_rc_xy[:, :2], linear, points)
        return np.rint(cells).astype(np.int32), linear


def _pyramid(field: NDArray[np.float32]) -> Pyramid:
    """
    Return maxima over windows of 2^h cells starting at each cell, ``(levels, H + pad, W + pad)``.

    The padding before the first row and column holds windows that start outside of the field.
    """
    pad = 2 ** (_LEVELS - 1)
    level = np.pad(field, ((pad, 0), (pad, 0)))
    levels = [level]
    for h in range(1, _LEVELS):
        window = 2**h
        forward = -(window // 2)  # the filter's window then starts at the cell itself
        padded = level
        for axis in range(2):
            padded = maximum_filter1d(padded, window, axis, mode='constant', origin=forward)
        levels.append(padded)
    return np.stack(levels)


@numba.njit(cache=True, nogil=True)
def _bound(pyramid: Pyramid, h: int, points: NDArray[np.int32], row: int, col: int) -> np.float32:
    """Return the mean over the points (P, 2) of level ``h`` at their cells moved by (row, col)."""
    pad = 2 ** (pyramid.shape[0] - 1)
    total = np.float32(0.0)
    for k in range(len(points)):
        r, c = points[k, 0] + row + pad, points[k, 1] + col + pad
        if 0 <= r < pyramid.shape[1] and 0 <= c < pyramid.shape[2]:
            total += pyramid[h, r, c]
    return np.float32(total / len(points))


@numba.njit(cache=True, nogil=True)
def _search(
    pyramid: Pyramid, rows: int, cols: int, turned: NDArray[np.int32], min_score: np.float32
) -> tuple[int, int, int, np.float32]:
    """Return the best (row, col) of the points' centre, its variant (-1: none) and score."""
    top = pyramid.shape[0] - 1
    size = 2**top
    down, across = (rows + size - 1) // size, (cols + size - 1) // size
    bounds = np.empty(len(turned) * down * across, dtype=np.float32)
    for index in range(len(bounds)):
        v, block = index // (down * across), index % (down * across)
        row, col = (block // across) * size, (block % across) * size
        bounds[index] = _bound(pyramid, top, turned[v], row, col)
    best, best_row, best_col, best_v = min_score, 0, 0, -1
    stack = np.empty((3 * pyramid.shape[0] + 4, 3), dtype=np.int64)
    scores = np.empty(len(stack), dtype=np.float32)
    for index in np.argsort(-bounds):
        if bounds[index] <= best:
            break
        v, block = index // (down * across), index % (down * across)
        stack[0] = (top, (block // across) * size, (block % across) * size)
        scores[0] = bounds[index]
        depth = 1
        while depth > 0:
            depth -= 1
            if scores[depth] <= best:
                continue
            h, row, col = stack[depth]
            if h == 0:
                best, best_row, best_col, best_v = scores[depth], row, col, v
                continue
            depth = _branch(pyramid, turned[v], h - 1, row, col, stack, scores, depth)
    return best_row, best_col, best_v, best


@numba.njit(cache=True, nogil=True)
def _branch(
    pyramid: Pyramid,
    points: NDArray[np.int32],
    h: int,
    row: int,
    col: int,
    stack: NDArray[np.int64],
    scores: NDArray[np.float32],
    depth: int,
) -> int:
    """Push a block's four quarters, the best one last; return the stack's new depth."""
    half = 2**h
    for quarter in range(4):
        r, c = row + half * (quarter // 2), col + half * (quarter % 2)
        score = _bound(pyramid, h, points, r, c)
        place = depth + quarter
        while place > depth and scores[place - 1] > score:
            stack[place] = stack[place - 1]
            scores[place] = scores[place - 1]
            place -= 1
        stack[place] = (h, r, c)
        scores[place] = score
    return depth + 4
