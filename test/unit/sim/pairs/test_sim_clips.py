# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robot maps that are clips of the storey's own map."""

import numpy as np
import pytest

from fpnet_core.errors import ConfigError
from fpnet_core.types import FREE
from fpnet_lab.sim.config import ClipConfig, SimConfig
from fpnet_lab.sim.pairs.clips import clip_map
from fpnet_lab.sim.pairs.pair import generate_pair
from fpnet_lab.sim.pairs.presets import preset
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.sources import NamedPlan, generated_plans

EXACT = ClipConfig(
    clipped=0.0, bumps_cells=(0.0, 0.0), specks=(0.0, 0.0), furnished=0.0, resolution_m=(0.05,)
)


@pytest.fixture(scope='module')
def storey():
    return NamedPlan(generate_plan(np.random.default_rng(3), 'branched'), 'branched')


def test_an_exact_clip_shows_its_rooms_where_they_are(storey):
    submap, T_submap_building = clip_map(storey, None, np.random.default_rng(1), EXACT)

    rooms = submap.path_xy
    cells = np.rint(submap.grid.xy_to_rc(rooms)).astype(int)
    middles = T_submap_building.inv().apply(rooms)
    known = submap.grid.cells[cells[:, 0], cells[:, 1]]
    assert (known == FREE).all()
    everything = np.array([room.polygon.mean(axis=0) for room in storey.plan.rooms])
    assert np.linalg.norm(everything[None] - middles[:, None], axis=2).min(axis=1).max() < 1e-6


def test_pairs_of_clips_are_labelled_and_repeat():
    config = preset('paper-synthetic').config
    first, second = (generate_pair(5, 3, config) for _ in range(2))

    assert (first.sub_labels == second.sub_labels).all()
    assert (first.sub_labels >= 0).mean() > 0.6
    assert np.array_equal(first.A_plan_submap.matrix, second.A_plan_submap.matrix)


def test_an_unknown_family_is_named():
    source = generated_plans(SimConfig(families=('igloo',)))
    with pytest.raises(ConfigError, match='igloo'):
        source.storey(0, 0, 0)
