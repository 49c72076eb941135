# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Openings and closings with kernels of even and odd size."""

import numpy as np
import pytest

from fpnet_core.submaps.morphology import closed, opened


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
