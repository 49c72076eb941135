# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blocks, windows and the first of each, each held against the plainest way to say it."""

import numpy as np
import pytest

from fpnet_core.raster.blocks import block_any, block_means, thinned, unblocked
from fpnet_core.raster.windows import (
    cropped,
    first_of_each,
)


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
