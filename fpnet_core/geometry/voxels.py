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
    total, count = _sums(points, key, max(1, int(2 * len(points) - 1).bit_length()))
    return np.asarray(total / count[:, None])


@numba.njit(cache=True, nogil=True)
def _sums(points, key, bits):  # type: ignore[no-untyped-def]
    """Return the sums (V, 3) and the counts (V,) of the points in each voxel."""
    place_of = np.full(1 << bits, -1, dtype=np.int64)
    key_of = np.empty(len(key), dtype=np.int64)
    total, count = np.zeros((len(key), 3)), np.zeros(len(key))
    shift, last, found = np.uint64(64 - bits), (1 << bits) - 1, 0
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
    return total[:found], count[:found]
