# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What holds for every generated storey, whatever its family."""

from functools import cache

import networkx as nx
import numpy as np
import pytest
import shapely

from fpnet_lab.sim.plans import FAMILIES, generate_plan

SEEDS = range(3)
STOREYS = [(family, seed) for family in FAMILIES for seed in SEEDS]


@cache
def _storey(family, seed):
    return generate_plan(np.random.default_rng([seed, 11]), family)


@pytest.fixture(params=STOREYS, ids=lambda p: f'{p[0]}-{p[1]}')
def plan(request):
    return _storey(*request.param)


def _outlines(plan):
    return [shapely.Polygon(room.polygon) for room in plan.rooms]


def test_outlines_are_simple_and_counter_clockwise(plan):
    for outline in _outlines(plan):
        assert outline.is_valid
        assert outline.exterior.is_ccw
        assert outline.area > 1.0


def test_walls_keep_rooms_apart(plan):
    outlines = _outlines(plan)
    tree = shapely.STRtree(outlines)
    for a, b in tree.query(outlines, 'dwithin', 0.5 * plan.wall_m).T.tolist():
        assert a == b, f'rooms {a} and {b} are nearer than half a wall'


def test_each_door_leads_from_one_room_to_the_other(plan):
    outlines = _outlines(plan)
    for door in plan.doors:
        a, b = (outlines[i] for i in door.rooms)
        along = (door.ends[1] - door.ends[0]) / door.width_m
        normal = np.array([-along[1], along[0]]) * (0.5 * plan.wall_m + 0.1)
        middle = door.ends.mean(axis=0)
        sides = [shapely.Point(middle + normal), shapely.Point(middle - normal)]
        assert (a.contains(sides[0]) and b.contains(sides[1])) or (
            a.contains(sides[1]) and b.contains(sides[0])
        )


def test_doors_keep_clear_of_corners(plan):
    outlines = _outlines(plan)
    for door in plan.doors:
        if door.is_open:
            continue
        assert 0.7 < door.width_m < 2.5
        along = (door.ends[1] - door.ends[0]) / door.width_m
        normal = np.array([-along[1], along[0]]) * (0.5 * plan.wall_m + 0.1)
        for end, outwards in zip(door.ends, (-along, along), strict=True):
            jamb = end + 0.2 * outwards
            beside = [shapely.Point(jamb + normal), shapely.Point(jamb - normal)]
            rooms = [outlines[i] for i in door.rooms]
            assert all(any(room.contains(point) for room in rooms) for point in beside)


def test_every_room_is_reachable(plan):
    graph = nx.Graph()
    graph.add_nodes_from(range(len(plan.rooms)))
    graph.add_edges_from(door.rooms for door in plan.doors)
    parts = nx.number_connected_components(graph)
    assert parts == (2 if plan.family == 'disconnected' else 1)
