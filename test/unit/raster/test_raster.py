# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blocks, distances, masks and labels, each held against the plainest way to say it."""

import cv2
import numpy as np
import pytest
from scipy.spatial.distance import cdist

from fpnet_core.raster.blocks import block_any, block_means, block_middles, thinned, unblocked
from fpnet_core.raster.distance import cells_to_nearest, near_code, nearest_labels
from fpnet_core.raster.morphology import closed, cross, grown, opened, shrunk, spread, square
from fpnet_core.raster.pieces import (
    label_figures,
    label_windows,
    looked_up,
    pieces_of,
    pieces_of_few,
    reached_from_edge,
    shared_cells,
)
from fpnet_core.raster.windows import cropped, first_of_each


def blocks_of(values, side, beyond):
    """Yield row, column and cells of each block, as a reader would cut them by hand."""
    rows, cols = values.shape
    for row in range(-(-rows // side)):
        for col in range(-(-cols // side)):
            block = np.full((side, side), beyond, dtype=values.dtype)
            part = values[row * side : (row + 1) * side, col * side : (col + 1) * side]
            block[: part.shape[0], : part.shape[1]] = part
            yield row, col, block


@pytest.mark.parametrize('side', [1, 2, 3, 5])
@pytest.mark.parametrize('beyond', [0.0, 1.0])
def test_means_are_those_of_the_blocks(side, beyond):
    values = np.random.default_rng(1).random((11, 7)).astype(np.float32)
    found = block_means(values, side, beyond)
    assert found.shape == (-(-11 // side), -(-7 // side))
    for row, col, block in blocks_of(values, side, beyond):
        assert found[row, col] == pytest.approx(block.mean(), abs=1e-6)


@pytest.mark.parametrize('side', [1, 2, 3, 5])
def test_any_of_a_block_and_back(side):
    mask = np.random.default_rng(2).random((11, 7)) < 0.1
    found = block_any(mask, side)
    for row, col, block in blocks_of(mask, side, False):
        assert found[row, col] == block.any()
    for row, col, block in blocks_of(mask, side, True):
        assert block_any(mask, side, is_beyond=True)[row, col] == block.any()
    back = unblocked(found, side, mask.shape)
    assert back.shape == mask.shape
    assert not (mask & ~back).any()
    np.testing.assert_array_equal(block_any(back, side), found)


def test_thinning_keeps_the_middle_of_what_is_there():
    mask = np.zeros((9, 9), dtype=bool)
    mask[0, 0] = mask[0, 2] = mask[7, 5] = True
    np.testing.assert_array_equal(thinned(mask, 3.0), [[0.0, 1.0], [7.0, 5.0]])
    assert thinned(np.zeros((4, 4), dtype=bool), 2.0).shape == (0, 2)
    # Finer than cells is cell by cell.
    assert len(thinned(mask, 0.3)) == 3


def test_the_first_of_each_key_in_the_order_of_the_visit():
    keys = np.array([7, 3, 7, 3, 9, 7])
    order = np.array([5, 4, 3, 0, 1, 2])
    found = first_of_each(keys, order)
    assert found.tolist() == [5, 4, 3]
    assert keys[found].tolist() == [7, 9, 3]
    assert first_of_each(np.zeros(0, int), np.zeros(0, int)).tolist() == []


@pytest.mark.parametrize('window', [np.s_[1:4, 0:5], np.s_[-2:3, 2:9], np.s_[-1:8, -3:7]])
def test_a_window_may_leave_the_raster(window):
    values = np.arange(1, 31).reshape(6, 5)
    around = np.pad(values, 4, constant_values=-7)
    inside = tuple(slice(side.start + 4, side.stop + 4) for side in window)
    np.testing.assert_array_equal(cropped(values, window, -7), around[inside])


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


@pytest.mark.parametrize('size', [1, 2, 3, 4, 5, 6, 10])
def test_a_rectangle_stays_where_it_is(size):
    mask = np.zeros((40, 50), dtype=bool)
    mask[10:30, 12:37] = True
    inner = opened(mask, size)
    assert not (inner & ~mask).any()
    assert np.argwhere(inner).min(axis=0).tolist() == [10, 12]
    assert np.argwhere(inner).max(axis=0).tolist() == [29, 36]
    assert (closed(mask, size) == mask).all()


def test_growing_and_shrinking_are_each_others_inverse_for_rectangles():
    mask = np.zeros((20, 30), dtype=bool)
    mask[8:12, 9:20] = True
    assert np.argwhere(grown(mask, 2)).min(axis=0).tolist() == [6, 7]
    assert np.count_nonzero(grown(mask, 2)) == 8 * 15
    np.testing.assert_array_equal(shrunk(grown(mask, 2), 2), mask)
    # What lies beyond the edge takes nothing away.
    assert shrunk(np.ones((5, 6), dtype=bool), 2).all()


@pytest.mark.parametrize('kernel', [cross(), square(3)])
def test_labels_spread_alike_within_and_at_the_edges(kernel):
    rng = np.random.default_rng(3)
    labels = rng.integers(1, 90, (30, 40), dtype=np.int32) * (rng.random((30, 40)) < 0.05)
    into = rng.random((30, 40)) < 0.8
    expected = labels.copy()
    for _ in range(3):
        grown_labels = cv2.dilate(expected.astype(np.float32), kernel).astype(np.int32)
        expected = np.where(into & (expected == 0), grown_labels, expected)
    np.testing.assert_array_equal(spread(labels, into, kernel, 3), expected)


def random_labels():
    rng = np.random.default_rng(8)
    labels = rng.integers(0, 9, (23, 31)).astype(np.int32)
    labels[labels == 4] = 0  # a label without cells
    return labels, rng.random(labels.shape).astype(np.float32)


def test_sizes_and_largest_values():
    labels, values = random_labels()
    sizes, largest = label_figures(labels, values, 10)
    for label in range(10):
        own = values[labels == label]
        assert sizes[label] == len(own)
        assert largest[label] == (own.max() if len(own) else 0.0)


def test_windows_are_the_smallest():
    labels, _ = random_labels()
    labels[:, :5] = 0
    windows = label_windows(labels)
    assert list(windows) == [1, 2, 3, 5, 6, 7, 8]
    for label, window in windows.items():
        rows, cols = np.nonzero(labels == label)
        assert window == (slice(rows.min(), rows.max() + 1), slice(cols.min(), cols.max() + 1))
    assert label_windows(np.zeros((3, 4), np.int32)) == {}


@pytest.mark.parametrize('share', [0.0, 0.02, 0.2, 0.6])
def test_pieces_of_few_cells_are_those_of_all(share):
    rng = np.random.default_rng(9)
    for shape in ((1, 40), (40, 1), (37, 53)):
        mask = rng.random(shape) < share
        labels, _ = pieces_of(mask)
        cells, piece = pieces_of_few(mask)
        np.testing.assert_array_equal(cells, np.argwhere(mask))
        np.testing.assert_array_equal(piece + 1, labels[mask])


@pytest.mark.parametrize('connectivity', [4, 8])
def test_figures_of_pieces_are_those_of_their_cells(connectivity):
    mask = np.random.default_rng(10).random((29, 41)) < 0.4
    labels, figures = pieces_of(mask, connectivity)
    np.testing.assert_array_equal(labels > 0, mask)
    assert len(figures) == labels.max() + 1
    for piece, found in enumerate(figures.tolist()):
        rows, cols = np.nonzero(labels == piece)
        left, top = cols.min(), rows.min()
        assert found == [left, top, np.ptp(cols) + 1, np.ptp(rows) + 1, len(rows)]


@pytest.mark.parametrize('share', [0.0, 0.3, 0.55, 1.0])
def test_what_the_edge_reaches_are_the_pieces_that_touch_it(share):
    mask = np.random.default_rng(13).random((37, 29)) < share
    labels, _ = pieces_of(mask, connectivity=4)
    edge = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    np.testing.assert_array_equal(reached_from_edge(mask), mask & np.isin(labels, edge[edge > 0]))


def test_labels_are_looked_up_and_counted_cell_by_cell():
    labels, values = random_labels()
    names = np.arange(10, 20, dtype=np.int32)
    np.testing.assert_array_equal(looked_up(labels, names), names[labels])
    np.testing.assert_array_equal(looked_up(labels, names > 14), (names > 14)[labels])
    others = (4 * values).astype(np.int32)
    shared = shared_cells(labels, others, 8, 3)
    for ours, theirs in np.ndindex(8, 3):
        both = (labels == ours + 1) & (others == theirs + 1)
        assert shared[ours, theirs] == np.count_nonzero(both)
