# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What makes each layout family that family."""

from functools import cache

import networkx as nx
import numpy as np
import pytest
import shapely
from shapely import Polygon

from fpnet_lab.sim.plans import generate_plan


@cache
def _plans(family):
    return [generate_plan(np.random.default_rng([seed, 3]), family) for seed in range(3)]


def _rooms(plan, *kinds):
    return [Polygon(r.polygon) for r in plan.rooms if r.kind in kinds]


@pytest.mark.parametrize(
    ('family', 'image'), [('mirrored', (-1.0, 1.0)), ('turned', (-1.0, -1.0))]
)
def test_symmetric_wings_fall_on_each_other(family, image):
    for plan in _plans(family):
        floor = shapely.union_all([Polygon(room.polygon) for room in plan.rooms])
        moved = shapely.union_all([Polygon(room.polygon * image) for room in plan.rooms])
        assert floor.symmetric_difference(moved).area < 1e-6 * floor.area


def test_disconnected_wings_share_no_door():
    for plan in _plans('disconnected'):
        assert nx.number_connected_components(plan.room_graph()) == 2


def test_homes_are_small_with_narrow_doors_around_one_hall():
    for plan in _plans('home'):
        rooms = _rooms(plan, 'room')
        assert plan.floor_area_m2 < 200.0
        assert np.median([room.area for room in rooms]) < 20.0
        assert max(door.width_m for door in plan.doors if not door.is_open) < 0.91
        assert len(_rooms(plan, 'hall')) == 1


def test_homes_are_drawn_where_they_are_asked_for():
    drawn = {generate_plan(np.random.default_rng(seed)).family for seed in range(40)}
    assert not drawn & {'home', 'practice'}
    assert len(drawn) > 5
