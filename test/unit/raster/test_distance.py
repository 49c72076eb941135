# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distances are exact: equal to a brute-force search, to the last digit."""

import numpy as np
from scipy.spatial.distance import cdist

from fpnet_core.raster.distance import cells_to_nearest, clearance_of, nearest_labels


def test_distances_are_those_of_a_full_search():
    rng = np.random.default_rng(3)
    for shape in ((37, 53), (64, 16), (5, 201)):
        mask = rng.random(shape) < 0.02
        mask[rng.integers(shape[0]), rng.integers(shape[1])] = True
        cells = np.argwhere(np.ones(shape, dtype=bool))
        squared = cdist(cells, np.argwhere(mask), 'sqeuclidean').min(axis=1)
        exact = np.sqrt(squared.astype(np.float32)).reshape(shape)
        np.testing.assert_array_equal(cells_to_nearest(mask), exact)


def test_clearance_ends_at_the_edge():
    free = np.ones((5, 7), dtype=bool)
    free[2, 6] = False
    assert clearance_of(free)[2].tolist() == [1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.0]


def test_every_cell_gets_the_label_nearest_to_it():
    labels = np.zeros((3, 6), np.int32)
    labels[1, 0], labels[1, 5] = 7, 2
    distance, nearest = nearest_labels(labels)
    assert nearest[1].tolist() == [7, 7, 7, 2, 2, 2]
    assert distance[1].tolist() == [0.0, 1.0, 2.0, 2.0, 1.0, 0.0]
