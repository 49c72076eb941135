# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures and windows of labels, against a search label by label."""

import numpy as np
import pytest

from fpnet_core.raster.pieces import (
    label_figures,
    label_windows,
    looked_up,
    pieces_of,
    pieces_of_few,
    reached_from_edge,
    shared_cells,
)


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
