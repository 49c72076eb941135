# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What makes each layout family that family."""

from functools import cache

import cv2
import networkx as nx
import numpy as np
import pytest
import shapely
from shapely import Polygon

from fpnet_lab.sim.plans import FAMILIES, generate_plan

NAMES = {
    'double_corridor',
    'racetrack',
    'branched',
    'central_hall',
    'ring_polygon',
    'diagonal',
    'suites',
    'apartments',
    'house',
    'open_plan',
    'repeated',
    'bent',
    'curved_facade',
    'bays',
    'mirrored',
    'turned',
    'disconnected',
    'home',
    'practice',
}


@cache
def _plans(family):
    return [generate_plan(np.random.default_rng([seed, 3]), family) for seed in range(3)]


def _rooms(plan, *kinds):
    return [Polygon(r.polygon) for r in plan.rooms if r.kind in kinds]


def _floor(plan, *kinds):
    """Return the rooms of some kinds as one area, walls between them filled."""
    grown = shapely.buffer(_rooms(plan, *kinds), plan.wall_m, join_style='mitre')
    return shapely.union_all(grown).buffer(-plan.wall_m, join_style='mitre')


def _edge_angles(plan, kind='room'):
    """Return the directions of walls over 1.5 m long, modulo 90 degrees, in degrees."""
    angles = []
    for room in plan.rooms:
        if room.kind == kind:
            edges = np.roll(room.polygon, -1, axis=0) - room.polygon
            edges = edges[np.hypot(*edges.T) > 1.5]
            angles.append(np.rad2deg(np.arctan2(edges[:, 1], edges[:, 0])) % 90.0)
    return np.concatenate(angles)


def _is_right_angled(plan):
    angles = _edge_angles(plan)
    return bool((np.minimum(angles, 90.0 - angles) < 1.0).all())


def test_all_families_are_tested():
    assert set(FAMILIES) == NAMES


@pytest.mark.parametrize('family', ['double_corridor', 'bays'])
def test_rooms_lie_on_both_sides_of_one_straight_corridor(family):
    for plan in _plans(family):
        (corridor,) = _rooms(plan, 'corridor')
        sides = sorted(cv2.minAreaRect(shapely.get_coordinates(corridor).astype('f4'))[1])
        assert sides[1] > 5.0 * sides[0]
        heights = np.array([room.centroid.y for room in _rooms(plan, 'room')])
        assert (heights > 0.0).any()
        assert (heights < 0.0).any()


def test_racetrack_corridors_close_a_loop():
    for family in ('racetrack', 'ring_polygon'):
        for plan in _plans(family):
            assert _floor(plan, 'corridor').interiors
            seams = nx.MultiGraph(d.rooms for d in plan.doors if d.is_open)
            assert nx.cycle_basis(nx.Graph(seams)) or seams.number_of_edges() > len(seams) - 1


def test_branched_corridors_turn_at_right_angles():
    for plan in _plans('branched'):
        corridor = _floor(plan, 'corridor')
        assert corridor.area < 0.8 * corridor.minimum_rotated_rectangle.area
        assert _is_right_angled(plan)


def test_a_central_hall_joins_most():
    for plan in _plans('central_hall'):
        hall = next(i for i, room in enumerate(plan.rooms) if room.kind == 'hall')
        assert Polygon(plan.rooms[hall].polygon).area > 40.0
        assert plan.room_graph().degree(hall) >= 5


def test_suites_and_flats_have_rooms_behind_rooms():
    for family in ('suites', 'house'):
        for plan in _plans(family):
            inner = [
                door for door in plan.doors if {plan.rooms[i].kind for i in door.rooms} == {'room'}
            ]
            assert len(inner) >= 3


def test_apartments_have_own_hallways():
    for plan in _plans('apartments'):
        assert len(_rooms(plan, 'corridor')) >= 4
        sizes = [room.area for room in _rooms(plan, 'corridor')]
        assert np.median(sizes) < 15.0 < max(sizes)


def test_open_plans_have_cubicles_inside_their_hall():
    for plan in _plans('open_plan'):
        hall = Polygon(_floor(plan, 'hall').exterior)
        cubicles = [r for r in _rooms(plan, 'room') if hall.contains(r.centroid)]
        assert len(cubicles) >= 4
        assert np.median([cubicle.area for cubicle in cubicles]) < 12.0


def test_repeated_rooms_are_alike():
    for plan in _plans('repeated'):
        areas = np.round([room.area for room in _rooms(plan, 'room')], 1)
        _, counts = np.unique(areas, return_counts=True)
        assert np.sort(counts)[-3:].sum() > 0.35 * len(areas)


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


def test_polygons_arcs_and_diagonals_leave_the_right_angle():
    for family in ('ring_polygon', 'bent', 'curved_facade', 'diagonal'):
        assert not all(_is_right_angled(plan) for plan in _plans(family))


def test_some_rings_are_pentagons():
    sides = []
    for seed in range(8):
        plan = generate_plan(np.random.default_rng([seed, 4]), 'ring_polygon')
        hull = _floor(plan, 'corridor').convex_hull.simplify(0.5)
        sides.append(len(hull.exterior.coords) - 1)
    assert 5 in sides


def test_bent_wings_follow_an_arc():
    corridors = [_floor(plan, 'corridor') for plan in _plans('bent')]
    assert min(floor.area / floor.convex_hull.area for floor in corridors) < 0.75
    assert all(len(floor.simplify(0.02).exterior.coords) > 8 for floor in corridors)


def test_bays_bulge_out_of_the_facade():
    for plan in _plans('bays'):
        extent = plan.extent[:, 1]
        heights = [room.bounds[3] for room in _rooms(plan, 'room') if room.centroid.y > 0.0]
        assert extent[1] - np.median(heights) > 0.3 or np.ptp(heights) > 0.3


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
