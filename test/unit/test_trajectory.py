# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lengths of paths."""

import numpy as np

from fpnet_core.trajectory import lengths_along, path_length


def test_a_path_is_as_long_as_its_steps():
    points = np.array([[1.0, 1.0, 0.0], [4.0, 5.0, 0.0], [4.0, 5.0, -12.0]])
    np.testing.assert_array_equal(lengths_along(points), [0.0, 5.0, 17.0])
    assert path_length(points) == 17.0
    assert path_length(points[:1]) == path_length(points[:0]) == 0.0
