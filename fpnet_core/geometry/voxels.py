# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Voxel grid filter for point clouds."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

_BITS = 21
"""Numerical: bits of a voxel index per axis; a million voxels to both sides of the origin."""

HASH_FACTOR = np.uint64(0x9E3779B97F4A7C15)
"""Given: 2^64 over the golden ratio, for multiplicative hashing (Knuth)."""


def voxel_means(points: NDArray[np.float64], size_m: float) -> NDArray[np.float64]:
    """
    Return the means ``(V, 3)`` of the ``points (P, 3)`` in each voxel of edge ``size_m``.

    Voxels are aligned to the origin and ordered by their first point. Points must be finite.
    """
    number = np.floor(points / size_m).astype(np.int64) + (1 << (_BITS - 1))
    key = number[:, 0] << 2 * _BITS | number[:, 1] << _BITS | number[:, 2]
    # A hash table with at least twice as many slots as points keeps collisions rare.
    bits = max(1, int(2 * len(points) - 1).bit_length())
    place_of, key_of = np.full(1 << bits, -1, np.int64), np.empty(len(key), np.int64)
    total, count = np.zeros((len(key), 3)), np.zeros(len(key))
    found = _add_points(points, key, np.uint64(64 - bits), place_of, key_of, total, count)
    return np.asarray(total[:found] / count[:found, None])


@numba.njit(cache=True, nogil=True)
def _add_points(  # type: ignore[no-untyped-def]
    points, key, shift, place_of, key_of, total, count
):
    """Write the sums (P, 3) and the counts (P,) of the points in each voxel; count the voxels."""
    last, found = len(place_of) - 1, 0
    for i in range(len(key)):
        place = np.int64((np.uint64(key[i]) * HASH_FACTOR) >> shift)
        while place_of[place] >= 0 and key_of[place_of[place]] != key[i]:
            place = (place + 1) & last
        voxel = place_of[place]
        if voxel < 0:
            voxel, found = found, found + 1
            place_of[place], key_of[voxel] = voxel, key[i]
        for axis in range(3):  # adding slices takes twice as long
            total[voxel, axis] += points[i, axis]
        count[voxel] += 1.0
    return found
