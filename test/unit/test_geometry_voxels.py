# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Clouds thinned to the means of voxels."""

import numpy as np

from fpnet_core.geometry.voxels import voxel_means


def _expected(points, size_m):
    """Return the means by a dictionary, in the order of the first points."""
    voxels = {}
    for point in points:
        voxels.setdefault(tuple(np.floor(point / size_m).astype(int)), []).append(point)
    return np.array([np.mean(inside, axis=0) for inside in voxels.values()])


def test_each_voxel_gives_the_mean_of_its_points():
    rng = np.random.default_rng(0)
    for size_m, spread_m in ((0.2, 1.0), (1.5, 20.0), (0.05, 90.0)):
        points = rng.normal(0.0, spread_m, (2000, 3))
        np.testing.assert_allclose(voxel_means(points, size_m), _expected(points, size_m))


def test_voxels_do_not_move_with_the_points():
    """Two parts of a wall seen from two places share means where they overlap."""
    wall = np.stack([np.linspace(0.0, 6.0, 601), np.full(601, 2.03), np.zeros(601)], axis=1)
    first, second = (voxel_means(wall[start : start + 400], 0.5) for start in (0, 200))
    shared = [mean for mean in second if (np.abs(first - mean).max(axis=1) < 1e-12).any()]
    assert len(shared) >= 3
