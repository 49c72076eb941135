# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys of a generated site: equal, alike and other ones, each on a sheet of its own."""

import numpy as np
import pytest

from fpnet_lab.evaluation.sites.site_drives import SIZES, site_likenesses
from fpnet_lab.sim.drawn.storeys import DIFFERENT, Likeness, draw_storeys, share_apart
from fpnet_lab.sim.plans import generate_plan

KINDS = (Likeness.OTHER, Likeness.TRUE, Likeness.EQUAL, Likeness.ALIKE)


@pytest.fixture(scope='module')
def storeys():
    rng = np.random.default_rng(11)
    return draw_storeys(generate_plan(rng, 'double_corridor'), KINDS, rng)


def test_storeys_differ_as_they_should(storeys):
    other, true, equal, alike = storeys
    assert [storey.name for storey in storeys] == ['L0', 'L1', 'L2', 'L3']
    assert (true.different, equal.different, other.different) == (0.0, 0.0, 1.0)
    assert DIFFERENT <= alike.different < 0.7
    np.testing.assert_array_equal(equal.drawn.grid.cells, true.drawn.grid.cells)
    assert alike.drawn.grid.shape == true.drawn.grid.shape
    apart = share_apart(true.drawn.grid, alike.drawn.grid)
    assert DIFFERENT <= apart < 0.7


def test_every_storey_has_a_sheet_of_its_own(storeys):
    poses = [storey.drawn.grid.T_frame_grid for storey in storeys]
    for k, pose in enumerate(poses):
        for other in poses[:k]:
            assert np.abs(pose.matrix - other.matrix).max() > 0.1


@pytest.mark.parametrize('count', SIZES)
@pytest.mark.parametrize('has_equal', [True, False])
def test_sites_hold_what_was_asked_for(count, has_equal):
    kinds = site_likenesses(count, np.random.default_rng(count), has_equal)
    assert len(kinds) == count
    assert kinds.count(Likeness.TRUE) == 1
    assert kinds.count(Likeness.EQUAL) == int(has_equal)
    assert kinds.count(Likeness.ALIKE) + kinds.count(Likeness.EQUAL) == 1 + (count - 1) // 2
