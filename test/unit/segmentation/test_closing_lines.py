# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lines across doorways: where they end, and that leaps through open space change nothing."""

import numpy as np
import pytest

from fpnet_core.raster.morphology import grown
from fpnet_core.segmentation.openings import narrowest_line, roominess


def test_cells_are_roomy_where_all_around_are_free():
    free = np.ones((40, 50), dtype=bool)
    free[20, 25] = False
    space = roominess(free)
    assert space[20, 25] == 0
    assert space[20, 25 - 4] == 1
    assert space[20, 25 - 5] == 2
    assert (space[:, 3] == 1).all()  # what lies beyond the edge is not free
    assert space[10, 4] == 2


def test_the_line_across_a_doorway_ends_at_its_jambs():
    free = np.ones((60, 80), dtype=bool)
    free[28:32] = False
    free[28:32, 30:48] = True
    ends = narrowest_line(roominess(free), (25.0, 40.0), 60.0, 6.0, 12.0)
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(18.0, abs=0.3)
    assert sorted(ends[:, 1]) == pytest.approx([29.5, 47.5], abs=0.3)
    assert (abs(ends[:, 0] - 29.5) < 2.1).all()


def test_leaps_end_where_steps_do():
    rng = np.random.default_rng(11)
    free = ~grown(rng.random((300, 300)) < 0.0006, 2)
    space = roominess(free)
    assert (space == 2).mean() > 0.1
    for row, col in rng.uniform(0.0, 299.0, (60, 2)):
        if free[round(row), round(col)]:
            both = [
                narrowest_line(each, (row, col), 60.0, 6.0, 12.0)
                for each in (space, np.minimum(space, 1))
            ]
            np.testing.assert_array_equal(*both)
