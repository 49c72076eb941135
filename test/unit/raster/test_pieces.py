# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures and windows of labels, against a search label by label."""

import numpy as np

from fpnet_core.raster.pieces import label_figures, label_windows


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
