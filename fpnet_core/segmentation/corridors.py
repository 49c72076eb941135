# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames across corridors: constrictions behind which the same corridor goes on."""

from __future__ import annotations

from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.rays import run_length

# Chosen, not measured:
# A corridor goes on at least so far on both sides of a frame, of which the first bit is the
# frame's own depth [m].
_REACH_M, _FRAME_M = 3.0, 0.4
# Its width is this quantile of the widths along that reach: doors to its sides widen the rest.
_QUANTILE = 0.25
_STEP_M = 0.1  # numerical
# Wider spaces are no corridors [m].
_MAX_CORRIDOR_M = 4.0
# Of the corridor's width a frame leaves at least so much, and both sides differ by less.
_LEAST_OPEN = 0.78
_MOST_UNEQUAL = 1.3


def is_corridor_frame(ends: NDArray[np.float64], free: Mask, cell_m: float) -> bool:
    """
    Tell whether a line across an opening lies in the course of one corridor.

    A frame narrows a corridor a little and the corridor goes on straight and as wide behind it,
    as at fire doors: people call that one corridor.

    Parameters
    ----------
    ends : (2, 2) row and column of the line's ends, fractional
    free : (H, W) bool
    cell_m : cell edge [true metres]
    """
    length = float(np.hypot(*(ends[1] - ends[0])))
    if length == 0.0:
        return False
    widths = []
    for side in (-1.0, 1.0):
        along = _widths(free, ends, side, cell_m)
        if not len(along):
            return False
        widths.append(float(np.quantile(along, _QUANTILE)))
    low, high = min(widths), max(widths)
    is_corridor = high <= _MAX_CORRIDOR_M and high < _MOST_UNEQUAL * low
    return is_corridor and length * cell_m >= _LEAST_OPEN * high


@njit(cache=True)
def _widths(
    free: NDArray[np.bool_], ends: NDArray[np.float64], side: float, cell_m: float
) -> NDArray[np.float64]:
    """Return the widths [m] parallel to the line, one side of it; none if the space is short."""
    length = np.hypot(ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1])
    u_row, u_col = (ends[1, 0] - ends[0, 0]) / length, (ends[1, 1] - ends[0, 1]) / length
    n_row, n_col = -side * u_col, side * u_row
    row, col = 0.5 * (ends[0, 0] + ends[1, 0]), 0.5 * (ends[0, 1] + ends[1, 1])
    reach, limit = _REACH_M / cell_m, _MAX_CORRIDOR_M / cell_m
    if run_length(free, False, row, col, n_row, n_col, reach) < reach:
        return np.zeros(0)
    count = int((_REACH_M - _FRAME_M) / _STEP_M)
    widths = np.zeros(count)
    for k in range(count):
        depth = (_FRAME_M + k * _STEP_M) / cell_m
        r, c = row + depth * n_row, col + depth * n_col
        run = run_length(free, False, r, c, u_row, u_col, limit)
        run += run_length(free, False, r, c, -u_row, -u_col, limit)
        widths[k] = run * cell_m
    return widths
