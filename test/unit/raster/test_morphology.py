# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Masks grown, shrunk, opened and closed with kernels of even and odd size."""

import cv2
import numpy as np
import pytest

from fpnet_core.raster.morphology import (
    closed,
    cross,
    grown,
    opened,
    shrunk,
    spread,
    square,
)


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
