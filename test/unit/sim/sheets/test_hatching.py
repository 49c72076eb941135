# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Strokes that fill outlines."""

import numpy as np
import pytest

from fpnet_lab.sim.sheets.hatching import hatched


def test_strokes_fill_a_square():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    strokes = hatched([square], 0.0, 0.5)
    np.testing.assert_allclose(np.ptp(strokes[..., 0], axis=1), 2.0)
    np.testing.assert_allclose(np.unique(strokes[..., 1]), [0.0, 0.5, 1.0, 1.5])


@pytest.mark.parametrize('rings', [[], [np.zeros((0, 2))]])
def test_nothing_is_filled_with_nothing(rings):
    assert hatched(rings, np.pi / 4.0, 0.5).shape == (0, 2, 2)
