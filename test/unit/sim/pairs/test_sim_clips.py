# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robot maps that are clips of the storey's own map."""

import numpy as np
import pytest

from fpnet_core.errors import ConfigError
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.sim.config import ClipConfig, SimConfig
from fpnet_lab.sim.drawn.rough import roughened
from fpnet_lab.sim.pairs.clips import clip_map, draw_rooms
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


def test_what_was_not_chosen_is_unknown(storey):
    config = EXACT.model_copy(update={'share': (0.2, 0.2)})
    submap, _ = clip_map(storey, None, np.random.default_rng(1), config)

    whole = storey.plan.floor_area_m2
    assert 0.02 * whole < submap.free_area_m2 < 0.7 * whole
    assert (submap.grid.cells == UNKNOWN).any()


def test_rooms_are_connected_and_as_many_as_wanted(storey):
    config = EXACT.model_copy(update={'share': (0.5, 0.5)})
    rooms = draw_rooms(storey.plan, None, np.random.default_rng(4), config)

    assert len(rooms) == len(set(rooms)) == round(0.5 * len(storey.plan.rooms))
    reached = storey.plan.room_graph().subgraph(rooms)
    assert all(any(True for _ in reached.neighbors(room)) for room in rooms)


def test_rooms_come_from_the_area(storey):
    low, high = storey.plan.extent
    middle = 0.5 * (low + high)
    area = np.array([low, [middle[0], low[1]], middle, [low[0], middle[1]]])

    rooms = draw_rooms(storey.plan, area, np.random.default_rng(4), EXACT)

    middles = np.array([storey.plan.rooms[room].polygon.mean(axis=0) for room in rooms])
    assert (middles <= middle + 1e-9).all()


def test_roughness_moves_walls_by_cells_only():
    cells = np.full((60, 60), FREE, np.int8)
    cells[28:32] = OCCUPIED
    rough = roughened(
        cells, np.random.default_rng(2), EXACT.model_copy(update={'bumps_cells': (0.6, 0.6)})
    )

    changed = np.flatnonzero((rough != cells).any(axis=1))
    assert len(changed)
    assert changed.min() >= 25
    assert changed.max() <= 34
    assert (roughened(cells, np.random.default_rng(2), EXACT) == cells).all()


def test_a_cut_removes_a_side(storey):
    cut = EXACT.model_copy(update={'clipped': 1.0, 'clip_share': 0.6})
    areas = [
        clip_map(storey, None, np.random.default_rng(7), config)[0].free_area_m2
        for config in (EXACT, cut)
    ]
    assert areas[1] < areas[0]


def test_pairs_of_clips_are_labelled_and_repeat():
    config = preset('paper-synthetic').config
    first, second = (generate_pair(5, 3, config) for _ in range(2))

    assert (first.sub_labels == second.sub_labels).all()
    assert (first.sub_labels >= 0).mean() > 0.6
    assert np.array_equal(first.A_plan_submap.matrix, second.A_plan_submap.matrix)


def test_paper_sets_leave_out_storeys_without_a_single_answer():
    source = generated_plans(preset('paper-synthetic').config)
    names = {source.storey(1, number, 0).name for number in range(40)}
    assert 'turned' not in names
    assert len(names) > 8


def test_an_unknown_family_is_named():
    source = generated_plans(SimConfig(families=('igloo',)))
    with pytest.raises(ConfigError, match='igloo'):
        source.storey(0, 0, 0)
