# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drawing traced to a building is the building that was drawn."""

import numpy as np
import pytest
import shapely

from fpnet_core.errors import MapFormatError
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.buildings.openings import opening_polygon, walkable_area
from fpnet_lab.sim.config import BuildingConfig
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes
from fpnet_lab.sim.pairs.scan2d import EMPTY
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.traced import plan_from_grid


def ious(expected, got):
    """Best intersection over union of each expected polygon with one of the others."""
    best = []
    for polygon in expected:
        shared = shapely.area(shapely.intersection(polygon, got))
        best.append(float((shared / (polygon.area + shapely.area(got) - shared)).max()))
    return np.array(best)


@pytest.fixture(scope='module', params=['double_corridor', 'suites', 'ring_polygon'])
def drawn_and_traced(request):
    plan = generate_plan(np.random.default_rng(6), request.param, min_rooms=13)
    return plan, plan_from_grid(render_plan(plan, 0.05))


def test_rooms_are_where_they_were_drawn(drawn_and_traced):
    drawn, traced = drawn_and_traced
    rooms = [o for o, r in zip(drawn.outlines, drawn.rooms, strict=True) if r.kind == 'room']
    agreement = ious(rooms, traced.outlines)
    assert np.mean(agreement > 0.8) > 0.85
    assert np.median(agreement) > 0.93
    total = shapely.union_all(drawn.outlines).area
    assert shapely.union_all(traced.outlines).area == pytest.approx(total, rel=0.04)
    assert traced.wall_m == pytest.approx(drawn.wall_m, abs=0.06)


def test_doors_join_two_rooms_through_the_wall(drawn_and_traced):
    drawn, traced = drawn_and_traced
    outlines = traced.outlines
    for door in traced.doors:
        a, b = door.rooms
        assert a != b
        opening = opening_polygon(traced, door)
        assert opening.intersects(outlines[a])
        assert opening.intersects(outlines[b])
    middles = shapely.points([d.ends.mean(axis=0) for d in traced.doors])
    real = [d.ends.mean(axis=0) for d in drawn.doors if not d.is_open]
    near = shapely.distance(shapely.points(real)[:, None], middles[None]).min(axis=1) < 0.3
    assert near.mean() > 0.85


def test_a_traced_plan_does_all_that_a_generated_one_does():
    drawn = generate_plan(np.random.default_rng(6), 'double_corridor', min_rooms=13)
    traced = plan_from_grid(render_plan(drawn, 0.05))
    rng = np.random.default_rng(1)
    building = extrude(traced, rng)
    assert len(building.walls.triangles) > 100
    assert len(building.furniture) > 5
    world = build_world(traced, draw_changes(traced, rng, BuildingConfig(furnished=0.0)), 0.5)
    area = np.count_nonzero((world.room_of >= 0) & (world.body == EMPTY)) * 0.05**2
    assert area == pytest.approx(sum(o.area for o in traced.outlines), rel=0.1)
    tour = plan_tour(traced, rng, TourLimits(rooms=3, shortest_s=10.0, longest_s=200.0))
    assert walkable_area(traced).covers(tour.line())


@pytest.mark.parametrize('value', [FREE, OCCUPIED])
def test_a_drawing_without_rooms_is_refused(value):
    with pytest.raises(MapFormatError, match='no rooms'):
        plan_from_grid(GridMap(np.full((80, 90), value), 0.05))
