# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arrays of frozen values: nobody can change them, and nothing is copied twice."""

import numpy as np

from fpnet_core.frozen import frozen_array


def test_a_frozen_array_is_taken_as_it_is():
    first = frozen_array([[1.0, 2.0]], np.float64, (None, 2), 'x')
    assert frozen_array(first, np.float64, (None, 2), 'x') is first


def test_what_somebody_may_still_write_to_is_copied():
    own = np.ones((3, 2))
    view = own[:2]
    view.setflags(write=False)
    for value in (own, view):
        frozen = frozen_array(value, np.float64, (None, 2), 'x')
        own[0, 0] = 7.0
        assert frozen[0, 0] == 1.0
        own[0, 0] = 1.0
