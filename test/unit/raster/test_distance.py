# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distances are exact: equal to a brute-force search, to the last digit."""

import numpy as np
from scipy.spatial.distance import cdist

from fpnet_core.raster.blocks import block_middles
from fpnet_core.raster.distance import cells_to_nearest, near_code, nearest_labels


def test_distances_are_those_of_a_full_search():
    rng = np.random.default_rng(3)
    for shape in ((37, 53), (64, 16), (5, 201)):
        mask = rng.random(shape) < 0.02
        mask[rng.integers(shape[0]), rng.integers(shape[1])] = True
        cells = np.argwhere(np.ones(shape, dtype=bool))
        squared = cdist(cells, np.argwhere(mask), 'sqeuclidean').min(axis=1)
        exact = np.sqrt(squared.astype(np.float32)).reshape(shape)
        np.testing.assert_array_equal(cells_to_nearest(mask), exact)


def test_distances_are_made_where_they_are_asked_for_and_in_the_middle_of_blocks():
    rng = np.random.default_rng(5)
    for share, step in ((0.0, 1), (0.01, 1), (0.01, 2), (0.2, 3)):
        mask, where = rng.random((61, 47)) < share, rng.random((61, 47)) < 0.5
        everywhere = cells_to_nearest(mask)
        np.testing.assert_array_equal(
            cells_to_nearest(mask, step), block_middles(everywhere, step)
        )
        asked = np.where(where, everywhere, 0.0)
        found = cells_to_nearest(mask, step, where)
        np.testing.assert_array_equal(found, block_middles(asked, step))


def test_distances_beyond_the_farthest_that_counts_are_only_known_to_be_so():
    mask = np.random.default_rng(6).random((90, 70)) < 0.002
    exact, found = cells_to_nearest(mask), cells_to_nearest(mask, most=6.5)
    near = exact <= 6.5
    assert 0 < near.sum() < near.size
    np.testing.assert_array_equal(found[near], exact[near])
    assert (found[~near] > 6.5).all()


def test_rasters_too_long_for_narrow_numbers_are_measured_as_well():
    mask = np.zeros((20_000, 2), dtype=bool)
    mask[0, 0] = True
    assert cells_to_nearest(mask)[-1].tolist() == [19_999.0, np.float32(np.hypot(19_999.0, 1.0))]


def test_every_cell_gets_the_label_nearest_to_it():
    labels = np.zeros((3, 6), np.int32)
    labels[1, 0], labels[1, 5] = 7, 2
    distance, nearest = nearest_labels(labels)
    assert nearest[1].tolist() == [7, 7, 7, 2, 2, 2]
    assert distance[1].tolist() == [0.0, 1.0, 2.0, 2.0, 1.0, 0.0]


def test_the_code_of_near_cells_is_their_squared_distance():
    rng = np.random.default_rng(4)
    mask = rng.random((40, 30)) < 0.05
    squared = np.rint(np.square(cells_to_nearest(mask)))
    np.testing.assert_array_equal(near_code(mask), np.where(squared <= 2, squared, 3))
