# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Kinds of buildings that only varied sheets show."""

import networkx as nx
import numpy as np
import pytest
import shapely

from fpnet_lab.sim.plans.special import SPECIAL, generate_special_plan, special_plan


@pytest.mark.parametrize('name', list(SPECIAL))
def test_rooms_of_a_special_building_are_apart_and_can_be_reached(name):
    for seed in range(3):
        plan = special_plan(np.random.default_rng(seed), name)
        overlap = shapely.area(plan.outlines).sum() - shapely.union_all(plan.outlines).area
        assert overlap < 0.05
        if name != 'terraced':  # whose dwellings are joined by nothing
            assert nx.is_connected(nx.Graph(plan.room_graph()))


def test_a_door_to_the_outside_lies_in_an_outer_wall():
    seen = 0
    for seed in range(20):
        plan = generate_special_plan(np.random.default_rng(seed))
        for door in plan.doors:
            if door.is_outside:
                beyond = door.ends.mean(axis=0) + (plan.wall_m + 0.5) * door.normal
                within = door.ends.mean(axis=0) - plan.wall_m * door.normal
                assert not shapely.contains_xy(plan.outlines, *beyond).any()
                assert shapely.contains_xy(plan.outlines[door.rooms[0]], *within)
                seen += 1
    assert seen > 8
