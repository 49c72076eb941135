# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lines across doorways: where they end."""

import numpy as np
import pytest

from fpnet_core.segmentation.openings import narrowest_lines


def test_the_line_across_a_doorway_ends_at_its_jambs():
    free = np.ones((60, 80), dtype=bool)
    free[28:32] = False
    free[28:32, 30:48] = True
    ends = narrowest_lines(
        free, np.array([[25.0, 40.0]]), np.array([60.0]), 6.0, np.array([12.0])
    )[0]
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(18.0, abs=0.3)
    assert sorted(ends[:, 1]) == pytest.approx([29.5, 47.5], abs=0.3)
    assert (abs(ends[:, 0] - 29.5) < 2.1).all()
