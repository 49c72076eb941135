# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distances are exact: equal to a brute-force search, to the last digit."""

import numpy as np
from scipy.spatial.distance import cdist

from fpnet_core.raster.distance import cells_to_nearest, near_code


def test_distances_are_those_of_a_full_search():
    rng = np.random.default_rng(3)
    for shape in ((37, 53), (64, 16), (5, 201)):
        mask = rng.random(shape) < 0.02
        mask[rng.integers(shape[0]), rng.integers(shape[1])] = True
        cells = np.argwhere(np.ones(shape, dtype=bool))
        squared = cdist(cells, np.argwhere(mask), 'sqeuclidean').min(axis=1)
        exact = np.sqrt(squared.astype(np.float32)).reshape(shape)
        np.testing.assert_array_equal(cells_to_nearest(mask), exact)


def test_the_code_of_near_cells_is_their_squared_distance():
    rng = np.random.default_rng(4)
    mask = rng.random((40, 30)) < 0.05
    squared = np.rint(np.square(cells_to_nearest(mask)))
    np.testing.assert_array_equal(near_code(mask), np.where(squared <= 2, squared, 3))
