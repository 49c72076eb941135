# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What is measured at a line that may part two rooms, whatever found it.

The space behind and beside the line, the walls at its ends, what was seen there and what was not.
Both sides of a line, and both its ends, come in order of size: nothing hangs on which is first.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.rays import is_inside, run_length

Array = NDArray[np.float64]

# Numerical: depths beside the line at which the space is measured [m].
_DEPTHS_M = (0.2, 0.4, 0.7, 1.0, 1.5, 2.2, 3.0)
_NARROW = 4  # numerical: so many of these depths say which side is narrower
_BESIDE_M = 1.5  # numerical: beyond the line's ends the space is measured so far
_AHEAD_M = 8.0  # numerical: and straight on so far
_WALL_M = 1.2  # numerical: the wall that goes on from its ends, so far
_THICK_M = 1.0  # numerical: its thickness is measured so far
_NEAR_M = 0.15  # numerical: an end meets a wall within so far
_BAND_M = 0.4  # numerical: furniture and lintels count so near to the line
_DISC_M = 1.2  # numerical: what is unseen is counted so far from its middle
_DISC_STEPS = 8.0  # numerical: in so many steps
_BLOCKED_M = -0.5  # numerical: said of the space beside a place that is not free
_BLUR_CELLS = 5  # numerical: over so many cells a wall's face has a direction
_LEAST_CELLS = 1e-6  # numerical: a line without length has a direction, too

_BESIDE = tuple(
    f'{end}_{side}_{depth}'
    for depth in range(len(_DEPTHS_M))
    for side in ('narrow', 'wide')
    for end in ('least', 'most')
)
LINE_FIGURES = (
    *_BESIDE,
    'ahead_least', 'ahead_most',
    'wall_least', 'wall_most',
    'thick_least', 'thick_most',
    'met_least', 'met_most',
    'unseen_least', 'unseen_most',
    'furniture', 'lintel', 'width', 'off_walls',
)  # fmt: skip
"""What is measured of a line; lengths in metres, the rest in [0, 1]."""


@dataclass(frozen=True, eq=False)
class LineMasks:
    """
    The masks (H, W) that lines are looked at in: what is ``passable``, what was ``unseen``, what
    was ``furniture`` until it was taken away, and which cells lie below a ``lintel``.
    """

    passable: Mask
    unseen: Mask
    furniture: Mask
    lintel: Mask
    cell_m: float


def line_figures(ends: Array, around: LineMasks) -> Array:
    """
    Return the :data:`LINE_FIGURES` (L, D) of lines.

    Parameters
    ----------
    ends : (L, 2, 2) row and column of their ends, fractional
    around : the masks they lie in
    """
    if not len(ends):
        return np.zeros((0, len(LINE_FIGURES)))
    cell_m, direction = around.cell_m, wall_direction(around.passable)
    values = _measured(
        np.ascontiguousarray(ends, dtype=np.float64),
        around.passable,
        around.unseen,
        around.furniture,
        around.lintel,
        cell_m,
        np.array(_DEPTHS_M),
    )
    along = ends[:, 1] - ends[:, 0]
    off = np.abs(np.sin(2.0 * (np.arctan2(along[:, 0], along[:, 1]) - direction)))
    return np.column_stack([values, off])


def wall_direction(passable: Mask) -> float:
    """Return the angle [rad] that most faces of walls have, but for quarter turns."""
    # Differences over a few cells tell angles that those of neighbours do not.
    size = (_BLUR_CELLS, _BLUR_CELLS)
    blurred = cv2.boxFilter(passable.astype(np.uint8), cv2.CV_16S, size, normalize=False)
    along, across = _slopes(np.asarray(blurred))
    return float(np.arctan2(across, along) / 4.0)


@njit(cache=True, nogil=True)
def _slopes(values: NDArray[np.int16]) -> tuple[float, float]:
    """Return the sum of all slopes of ``values (H, W)``, four times turned: x and y."""
    steepest = _BLUR_CELLS**2
    turned = _turned(steepest)
    x, y = 0.0, 0.0
    for row in range(1, values.shape[0] - 1):
        for col in range(1, values.shape[1] - 1):
            d_row = values[row + 1, col] - values[row - 1, col]
            d_col = values[row, col + 1] - values[row, col - 1]
            if d_row != 0 or d_col != 0:
                x += turned[d_row + steepest, d_col + steepest, 0]
                y += turned[d_row + steepest, d_col + steepest, 1]
    return x, y


@njit(cache=True, nogil=True)
def _turned(steepest: int) -> Array:
    """Return all slopes that there may be (N, N, 2), four times turned."""
    turned = np.zeros((2 * steepest + 1, 2 * steepest + 1, 2))
    for i in range(len(turned)):
        for j in range(len(turned)):
            d_row, d_col = float(i - steepest), float(j - steepest)
            square = d_row * d_row + d_col * d_col
            if square > 0.0:
                # The fourth power of a slope as a complex number, over its third.
                even, odd = d_col * d_col - d_row * d_row, 2.0 * d_col * d_row
                turned[i, j, 0] = (even * even - odd * odd) / square**1.5
                turned[i, j, 1] = 2.0 * even * odd / square**1.5
    return turned


@njit(cache=True, nogil=True)
def _measured(ends, passable, unseen, furniture, lintel, cell_m, depths):  # type: ignore[no-untyped-def]
    """Return all figures but the last; see :data:`LINE_FIGURES`."""
    count, n = len(ends), len(depths)
    out = np.zeros((count, 4 * n + 13))
    band = _BAND_M / cell_m
    for k in range(count):
        r0, c0, r1, c1 = ends[k, 0, 0], ends[k, 0, 1], ends[k, 1, 0], ends[k, 1, 1]
        length = max(np.hypot(r1 - r0, c1 - c0), _LEAST_CELLS)
        u_r, u_c = (r1 - r0) / length, (c1 - c0) / length
        row, col, half = 0.5 * (r0 + r1), 0.5 * (c0 + c1), 0.5 * length
        place = (row, col, u_r, u_c, half)
        _look_aside(passable, unseen, place, cell_m, depths, out[k])
        _look_along(passable, unseen, ends[k], u_r, u_c, cell_m, out[k, 4 * n + 2 :])
        out[k, 4 * n + 10] = _band_share(furniture, row, col, u_r, u_c, half + band, band, False)
        out[k, 4 * n + 11] = _band_share(lintel, row, col, u_r, u_c, half, band, True)
        out[k, 4 * n + 12] = length * cell_m
    return out


@njit(cache=True, nogil=True)
def _look_aside(passable, unseen, place, cell_m, depths, out):  # type: ignore[no-untyped-def]
    """Write what lies on both sides of a line: widths, how far it goes on, what is unseen."""
    row, col, u_r, u_c, half = place
    n, cap = len(depths), _BESIDE_M / cell_m
    extent, runs, hidden = np.zeros((2, n, 2)), np.zeros(2), np.zeros(2)
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        n_r, n_c = -sign * u_c, sign * u_r
        # The line's own cells may count as closed.
        runs[side] = run_length(passable, False, row + n_r, col + n_c, n_r, n_c, _AHEAD_M / cell_m)
        hidden[side] = _share_beside(unseen, row, col, n_r, n_c, _DISC_M / cell_m)
        for j in range(n):
            d = depths[j] / cell_m
            r, c = row + d * n_r, col + d * n_c
            if not is_inside(passable, r, c, False) or runs[side] < d - 2.0:
                extent[side, j] = _BLOCKED_M
                continue
            a = run_length(passable, False, r, c, u_r, u_c, half + cap) - half
            b = run_length(passable, False, r, c, -u_r, -u_c, half + cap) - half
            extent[side, j, 0] = max(min(a, b) * cell_m, _BLOCKED_M)
            extent[side, j, 1] = max(max(a, b) * cell_m, _BLOCKED_M)
    narrow = 0 if extent[0, :_NARROW].sum() <= extent[1, :_NARROW].sum() else 1
    for j in range(n):
        out[4 * j : 4 * j + 2] = extent[narrow, j]
        out[4 * j + 2 : 4 * j + 4] = extent[1 - narrow, j]
    out[4 * n], out[4 * n + 1] = runs.min() * cell_m, runs.max() * cell_m
    out[4 * n + 8], out[4 * n + 9] = hidden.min(), hidden.max()


@njit(cache=True, nogil=True)
def _look_along(passable, unseen, ends, u_r, u_c, cell_m, out):  # type: ignore[no-untyped-def]
    """Write what a line's ends meet: the wall that goes on, its thickness, whether any is met."""
    wall, thick, met = np.zeros(2), np.zeros(2), np.zeros(2)
    near = _NEAR_M / cell_m
    for end in range(2):
        sign = 1.0 if end == 1 else -1.0
        r, c, d_r, d_c = ends[end, 0], ends[end, 1], sign * u_r, sign * u_c
        wall[end] = _solid_share(passable, unseen, r, c, d_r, d_c, _WALL_M / cell_m)
        met[end] = _solid_share(passable, unseen, r, c, d_r, d_c, near)
        p_r, p_c = r + near * d_r, c + near * d_c
        thick[end] = _thickness(passable, p_r, p_c, -u_c, u_r, _THICK_M / cell_m) * cell_m
    out[0], out[1] = wall.min(), wall.max()
    out[2], out[3] = thick.min(), thick.max()
    out[4], out[5] = met.min(), met.max()


@njit(cache=True, nogil=True)
def _share_beside(mask, row, col, n_r, n_c, reach):  # type: ignore[no-untyped-def]
    """Return the share of True cells in the half disc around a place."""
    seen, count = 0, 0
    step = max(1, int(reach / _DISC_STEPS))
    size = int(reach)
    for d_r in range(-size, size + 1, step):
        for d_c in range(-size, size + 1, step):
            if d_r * n_r + d_c * n_c <= 0.0 or d_r * d_r + d_c * d_c > reach * reach:
                continue
            count += 1
            seen += is_inside(mask, row + d_r, col + d_c, True)
    return seen / max(count, 1)


@njit(cache=True, nogil=True)
def _solid_share(passable, unseen, row, col, d_r, d_c, reach):  # type: ignore[no-untyped-def]
    """Return the share of wall on a line that goes on from a place; one beside it counts."""
    solid, steps = 0, max(2, int(reach))
    for k in range(1, steps + 1):
        r, c = row + k * d_r, col + k * d_c
        for offset in (0.0, -1.0, 1.0):
            a, b = r - offset * d_c, c + offset * d_r
            if not is_inside(passable, a, b, False) and not is_inside(unseen, a, b, True):
                solid += 1
                break
    return solid / steps


@njit(cache=True, nogil=True)
def _thickness(passable, row, col, d_r, d_c, most):  # type: ignore[no-untyped-def]
    """Return how far it is through what is not passable, both ways [cells]."""
    if is_inside(passable, row, col, False):
        return 0.0
    total = 0.0
    for sign in (-1.0, 1.0):
        run = 0.0
        while run < most and not is_inside(
            passable, row + sign * run * d_r, col + sign * run * d_c, False
        ):
            run += 0.5
        total += run
    return total


@njit(cache=True, nogil=True)
def _band_share(mask, row, col, u_r, u_c, half, band, across):  # type: ignore[no-untyped-def]
    """Return the share of a band's cells in ``mask``, or of the line's places that have any."""
    along, wide = max(1, int(half)), max(1, int(band))
    found, count = 0, 0
    for k in range(-along, along + 1):
        here = 0
        for j in range(-wide, wide + 1):
            here += is_inside(mask, row + k * u_r - j * u_c, col + k * u_c + j * u_r, False)
        found += (here > 0) if across else here
        count += 1 if across else 2 * wide + 1
    return found / count
