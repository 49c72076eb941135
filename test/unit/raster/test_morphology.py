# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Masks grown, shrunk, opened and closed with kernels of even and odd size."""

import cv2
import numpy as np
import pytest

from fpnet_core.raster.morphology import (
    closed,
    cross,
    disc,
    grown,
    grown_by,
    is_peak,
    opened,
    opened_by,
    shrunk,
    spread,
    square,
)
from fpnet_core.raster.pieces import longer_pieces


@pytest.mark.parametrize('size', [1, 2, 3, 4, 5, 6, 10])
def test_a_rectangle_stays_where_it_is(size):
    mask = np.zeros((40, 50), dtype=bool)
    mask[10:30, 12:37] = True
    inner = opened(mask, size)
    assert not (inner & ~mask).any()
    assert np.argwhere(inner).min(axis=0).tolist() == [10, 12]
    assert np.argwhere(inner).max(axis=0).tolist() == [29, 36]
    assert (closed(mask, size) == mask).all()


@pytest.mark.parametrize('size', [3, 4])
def test_only_what_is_narrower_goes(size):
    mask = np.zeros((20, 30), dtype=bool)
    mask[5 : 5 + size - 1, :] = True
    mask[12 : 12 + size, :] = True
    assert not opened(mask, size)[:9].any()
    assert (opened(mask, size)[12 : 12 + size, 5:25]).all()
    assert closed(~mask, size)[5 : 5 + size - 1].all()


def test_growing_and_shrinking_are_each_others_inverse_for_rectangles():
    mask = np.zeros((20, 30), dtype=bool)
    mask[8:12, 9:20] = True
    assert np.argwhere(grown(mask, 2)).min(axis=0).tolist() == [6, 7]
    assert np.count_nonzero(grown(mask, 2)) == 8 * 15
    np.testing.assert_array_equal(shrunk(grown(mask, 2), 2), mask)
    # What lies beyond the edge takes nothing away.
    assert shrunk(np.ones((5, 6), dtype=bool), 2).all()


def test_discs_are_round_and_crosses_have_no_corners():
    dot = np.zeros((21, 21), dtype=bool)
    dot[10, 10] = True
    assert np.count_nonzero(grown_by(dot, cross())) == 5
    reached = np.argwhere(grown_by(dot, disc(15)))
    assert np.hypot(*(reached - 10).T).max() < 8.2
    assert len(reached) > 0.9 * np.pi * 7.0**2


@pytest.mark.parametrize('is_beyond', [False, True])
def test_an_opening_at_the_edge_is_as_what_lies_beyond(is_beyond):
    mask = np.zeros((20, 20), dtype=bool)
    mask[:3] = True
    assert opened_by(mask, square(5), is_beyond).any() == is_beyond


def test_labels_spread_step_by_step_and_the_largest_wins():
    labels = np.zeros((1, 9), dtype=np.int32)
    labels[0, 0], labels[0, 8] = 2, 70_000
    into = np.ones((1, 9), dtype=bool)
    into[0, 6] = False
    one_way = spread(labels.copy(), into, square(3), 2)
    assert one_way.tolist() == [[2, 2, 2, 0, 0, 0, 0, 70_000, 70_000]]
    into[0, 6] = True
    assert spread(labels, into, square(3), 4).tolist() == [[2] * 4 + [70_000] * 5]


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


def test_peaks_are_as_high_as_all_around():
    values = np.array([[1.0, 2.0, 1.0], [0.0, 1.0, 3.0], [5.0, 1.0, 3.0]])
    assert np.argwhere(is_peak(values, 3)).tolist() == [[1, 2], [2, 0], [2, 2]]


def test_short_pieces_go_along_with_both_their_axes():
    mask = np.zeros((20, 30), dtype=bool)
    mask[2, 3:9] = mask[6:9, 20:23] = mask[15, 5] = True
    kept = longer_pieces(mask, 3.0)
    assert kept.sum() == 6
    assert kept[2].sum() == 6
