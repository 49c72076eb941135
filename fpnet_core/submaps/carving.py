# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compiled ray casting through the count raster."""

from __future__ import annotations

from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

Counts = NDArray[np.uint16]

# Given: layers of the count raster: crossings of all bands, returns at body height and at lintel
# height, and crossings at lintel height.
CROSSED, MID_HIT, HIGH_HIT, HIGH_CROSSED = 0, 1, 2, 3
LAYERS = 4  # given

# A cell crossed by at least this many rays at lintel height, with at most this share of returns
# among them, is furniture. Chosen.
_LOW_PASSES, _LOW_SHARE = 3, 0.2

# Numerical: a cell's counts are halved when one of them reaches this, so uint16 never wraps and
# ratios stay.
_SATURATION = 60000


@njit(cache=True, nogil=True, inline='always')
def _count(counts: Counts, row: int, col: int, layer: int) -> None:
    if counts[row, col, layer] >= _SATURATION:
        for k in range(LAYERS):
            counts[row, col, k] //= 2
    counts[row, col, layer] += np.uint16(1)


@njit(cache=True, nogil=True)
def carve_rays(
    counts: Counts,
    origin: NDArray[np.float64],
    ends: NDArray[np.float64],
    is_return: NDArray[np.bool_],
    bands: tuple[float, float, float, float, float],
    end_margin: float,
) -> None:
    """
    Count crossings and returns of rays, in place.

    Parameters
    ----------
    counts : (H, W, LAYERS) uint16
    origin : (3,) column, row [fractional cells, integers at cell corners] and z [m]
    ends : (P, 3), the same for the rays' ends; all inside the raster
    is_return : (P,), False if the ray was cut at the maximum range
    bands : body low, body high, high low, high high, ceiling [m]
    end_margin : length before a return that does not count as crossed [cells]
    """
    for i in range(ends.shape[0]):
        d_col, d_row = ends[i, 0] - origin[0], ends[i, 1] - origin[1]
        d_z = ends[i, 2] - origin[2]
        length = np.hypot(d_col, d_row)
        stop = 1.0
        if is_return[i]:
            stop, z = 1.0 - end_margin / max(length, 1e-9), ends[i, 2]
            is_mid = bands[0] <= z <= bands[1]
            if is_mid or bands[2] <= z <= bands[3]:
                hit = MID_HIT if is_mid else HIGH_HIT
                _count(counts, int(ends[i, 1]), int(ends[i, 0]), hit)
        if stop <= 0.0:
            continue
        col, row = int(origin[0]), int(origin[1])
        step_col, step_row = (1 if d_col > 0 else -1), (1 if d_row > 0 else -1)
        grow_col = abs(1.0 / d_col) if d_col != 0.0 else np.inf
        grow_row = abs(1.0 / d_row) if d_row != 0.0 else np.inf
        to_col = (col + 1 - origin[0] if d_col > 0 else origin[0] - col) * grow_col
        to_row = (row + 1 - origin[1] if d_row > 0 else origin[1] - row) * grow_row
        to_col, to_row = to_col if d_col != 0.0 else np.inf, to_row if d_row != 0.0 else np.inf
        lowest, highest = min(origin[2], ends[i, 2]), max(origin[2], ends[i, 2])
        is_level = bands[0] <= lowest and highest <= bands[1] and highest < bands[2]
        t = 0.0
        while True:
            leave = min(to_col, to_row, stop)
            z = origin[2] + 0.5 * (t + leave) * d_z
            if is_level or bands[0] <= z <= bands[1] or bands[2] <= z <= bands[4]:
                _count(counts, row, col, CROSSED)
                if not is_level and bands[2] <= z <= bands[3]:
                    _count(counts, row, col, HIGH_CROSSED)
            t = leave
            if t >= stop:
                break
            if to_col < to_row:
                col += step_col
                to_col += grow_col
            else:
                row += step_row
                to_row += grow_row


@njit(cache=True, nogil=True)
def classify(
    counts: Counts,
    cells: NDArray[np.int8],
    lintel: NDArray[np.bool_],
    wall_share: float,
    lintel_share: float,
    lintel_min_hits: int,
) -> bool:
    """
    Convert counts to cell values and the lintel mask, in place; return whether any is not zero.

    A wall has a share of at least ``wall_share`` returns among returns and crossings, unless rays
    cross it at lintel height: furniture is lower than walls. A lintel lies over free space and
    returns at least ``lintel_share`` of the rays at its height. High returns that most rays pass
    are noise on the face of a wall, or clutter.

    Parameters
    ----------
    counts : (H, W, LAYERS) uint16
    cells : (H, W) int8, receives the values of a ``GridMap``
    lintel : (H, W) bool, receives the mask
    wall_share, lintel_share, lintel_min_hits : see :mod:`fpnet_core.submaps.raster`
    """
    is_seen = False
    for row in range(counts.shape[0]):
        for col in range(counts.shape[1]):
            crossed, mid = counts[row, col, CROSSED], counts[row, col, MID_HIT]
            high, passed = counts[row, col, HIGH_HIT], counts[row, col, HIGH_CROSSED]
            is_low = passed >= max(_LOW_PASSES, mid / 2) and high <= _LOW_SHARE * (high + passed)
            is_wall = mid > 0 and not is_low and mid >= wall_share * (mid + crossed)
            is_free = crossed > 0 and not is_wall
            cells[row, col] = OCCUPIED if is_wall else (FREE if is_free else UNKNOWN)
            is_high = high >= lintel_min_hits and high >= lintel_share * (high + passed)
            lintel[row, col] = is_free and is_high and high > mid
            is_seen = is_seen or crossed + mid + high > 0
    return is_seen
