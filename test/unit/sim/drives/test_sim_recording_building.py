# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Extruded buildings: closed prisms, lintels above doors, furniture out of the way."""

import numpy as np
import open3d as o3d
import pytest
import shapely

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.buildings.fittings import BUILDING_STYLES, BuildingStyle, cut_windows
from fpnet_lab.sim.buildings.furnishing import (
    DOOR_CLEARANCE_M,
    LOOSE_DOOR_CLEARANCE_M,
    furnish,
    furnish_loosely,
)
from fpnet_lab.sim.buildings.furniture import DRAWN
from fpnet_lab.sim.buildings.meshes import extrude_polygon, horizontal_sheet, merge_meshes
from fpnet_lab.sim.buildings.openings import opening_polygon, walkable_area
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom

CEILING_M, LINTEL_M = BuildingStyle().ceiling_m[0], BuildingStyle().lintel_m[0]
YAW_RAD = np.deg2rad(27.0)
ROTATION = np.array([[np.cos(YAW_RAD), -np.sin(YAW_RAD)], [np.sin(YAW_RAD), np.cos(YAW_RAD)]])


def turned(points):
    return np.asarray(points, dtype=np.float64) @ ROTATION.T


def three_rooms():
    """A 5 x 4 room, a door to a 3 x 4 room, and a full-height seam to a 2 x 4 room; turned."""

    def box(x0, x1):
        return turned([(x0, 0.0), (x1, 0.0), (x1, 4.0), (x0, 4.0)])

    rooms = (PlanRoom(box(0.0, 5.0)), PlanRoom(box(5.2, 8.2)), PlanRoom(box(8.4, 10.4)))
    doors = (
        PlanDoor((0, 1), turned([(5.1, 1.0), (5.1, 1.9)])),
        PlanDoor((1, 2), turned([(8.3, 0.1), (8.3, 3.9)]), is_open=True),
    )
    return BuildingPlan(rooms, doors, wall_m=0.2, family='test')


def cast(building, origin, direction):
    """Distance from ``origin`` (x, y before turning, z) along ``direction`` (likewise)."""
    mesh = merge_meshes(building.parts)
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32))
    ray = [*turned(origin[:2]), origin[2], *turned(direction[:2]), direction[2]]
    hit = scene.cast_rays(o3d.core.Tensor([ray], dtype=o3d.core.Dtype.Float32))
    return float(hit['t_hit'].numpy()[0])


@pytest.fixture(scope='module')
def empty_building():
    return extrude(three_rooms(), np.random.default_rng(0), is_furnished=False)


def test_prism_is_closed_and_faces_outwards():
    ring = turned([(0, 0), (4, 0), (4, 3), (0, 3)])
    hole = turned([(1, 1), (2, 1), (2, 2), (1, 2)])
    corners = extrude_polygon(shapely.Polygon(ring, [hole]), 0.5, 2.5).corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volume = np.einsum('ti,ti->', corners[:, 0], normals) / 6.0
    area = np.linalg.norm(normals, axis=1).sum() / 2.0
    assert volume == pytest.approx(11.0 * 2.0)
    assert area == pytest.approx(2.0 * 11.0 + (14.0 + 4.0) * 2.0)


def test_door_lets_through_below_the_lintel_only(empty_building):
    east = (1.0, 0.0, 0.0)
    assert cast(empty_building, (4.0, 1.45, 1.0), east) == pytest.approx(6.4, abs=1e-3)
    assert cast(empty_building, (4.0, 1.45, 2.3), east) == pytest.approx(0.99, abs=1e-3)
    assert cast(empty_building, (4.0, 3.0, 1.0), east) == pytest.approx(1.0, abs=1e-3)


def test_lintel_hangs_above_the_door_and_not_above_a_seam(empty_building):
    up, down = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
    assert cast(empty_building, (5.1, 1.45, 0.9), up) == pytest.approx(LINTEL_M - 0.9, abs=1e-3)
    assert cast(empty_building, (8.3, 2.0, 0.9), up) == pytest.approx(CEILING_M - 0.9, abs=1e-3)
    assert cast(empty_building, (2.0, 2.0, 0.9), up) == pytest.approx(CEILING_M - 0.9, abs=1e-3)
    assert cast(empty_building, (5.1, 1.45, 0.9), down) == pytest.approx(0.9, abs=1e-3)


def test_opening_joins_its_rooms():
    plan = three_rooms()
    assert walkable_area(plan).geom_type == 'Polygon'
    for door in plan.doors:
        opening = opening_polygon(plan, door)
        assert opening.area == pytest.approx(door.width_m * 0.22, rel=1e-6)


def test_lintel_above_the_ceiling_is_refused():
    with pytest.raises(ConfigError, match='lintel'):
        extrude(three_rooms(), np.random.default_rng(0), style=BuildingStyle(lintel_m=(2.7, 2.7)))


def raised(plan=None, clear=None, seed=0, **style):
    """Return an empty building of a style; lintel and ceiling as in the other tests."""
    return extrude(
        plan or three_rooms(),
        np.random.default_rng(seed),
        keep_clear=clear,
        is_furnished=False,
        style=BuildingStyle(**style),
    )


def test_frameless_doors_reach_the_ceiling():
    up = (0.0, 0.0, 1.0)
    assert cast(raised(frameless=1.0), (5.1, 1.45, 0.9), up) == pytest.approx(1.8, abs=1e-3)


def test_a_shut_leaf_closes_its_door_and_never_that_on_the_way():
    east, low = (1.0, 0.0, 0.0), (4.0, 1.45, 1.0)
    assert cast(raised(leaves=1.0, closed=1.0), low, east) == pytest.approx(1.08, abs=0.01)
    way = shapely.LineString(turned([(3.0, 1.45), (7.0, 1.45)])).buffer(0.45)
    assert cast(raised(leaves=1.0, closed=1.0, clear=way), low, east) > 3.0


@pytest.mark.parametrize('swing', [0, 1])
@pytest.mark.parametrize('hinge', [0, 1])
def test_an_open_leaf_stands_in_the_room_it_swings_into(hinge, swing):
    plan = three_rooms()
    door = PlanDoor((0, 1), plan.doors[0].ends, hinge=hinge, swing=swing)
    plan = BuildingPlan(plan.rooms, (door,), plan.wall_m, plan.family)
    with_leaf, without = raised(plan, leaves=1.0), raised(plan)
    extra = with_leaf.walls.vertices[len(without.walls.vertices) :, :2] @ ROTATION
    x = extra[:, 0]
    assert (x < 5.03).all() if swing == 0 else (x > 5.17).all()
    hinge_y = 1.0 if hinge == 0 else 1.9
    assert np.abs(extra[:, 1] - hinge_y).min() < 0.1
    assert np.ptp(x) == pytest.approx(0.9, abs=0.06)
    assert cast(with_leaf, (4.0, 1.45, 1.0), (1.0, 0.0, 0.0)) == pytest.approx(4.2, abs=1e-3)


def test_windows_are_glass_between_sill_and_top_in_outer_walls_only():
    plan = three_rooms()
    building = raised(windows=1.0, sill_m=(0.8, 0.8))
    assert len(building.glass.triangles)
    z = building.glass.vertices[:, 2]
    assert (z.min(), z.max()) == pytest.approx((0.8, 2.1))
    hull = walkable_area(plan)
    rng = np.random.default_rng(0)
    rng.uniform(size=2)  # the heights that are drawn first
    for pane in cut_windows(plan, BuildingStyle(windows=1.0), 0.3, rng):
        assert pane.glass.distance(hull) == pytest.approx(0.15, abs=1e-6)
        middle = np.array(pane.glass.centroid.coords[0])
        inside = np.array(shapely.shortest_line(pane.glass.centroid, hull).coords[1])
        outwards = (middle - inside) / np.linalg.norm(middle - inside)
        level = [*(inside - outwards) @ ROTATION, 1.2]
        assert cast(building, level, [*outwards @ ROTATION, 0.0]) == np.inf
        low = [*level[:2], 0.4]
        assert cast(building, low, [*outwards @ ROTATION, 0.0]) == pytest.approx(1.0, abs=1e-2)


def test_glass_fronts_face_corridors():
    plan = generate_plan(np.random.default_rng(3), 'double_corridor')
    panes = cut_windows(plan, BuildingStyle(glass_fronts=1.0), 0.3, np.random.default_rng(0))
    ways = shapely.union_all(
        [o for o, r in zip(plan.outlines, plan.rooms, strict=True) if r.kind != 'room']
    )
    doors = [opening_polygon(plan, door) for door in plan.doors]
    assert len(panes) > 5
    for pane in panes:
        assert pane.hole.intersects(ways)
        assert not any(pane.hole.intersects(door) for door in doors)


def test_every_style_raises_another_building():
    plan = generate_plan(np.random.default_rng(2), 'bent')
    sizes = {}
    for name, style in BUILDING_STYLES.items():
        building = extrude(plan, np.random.default_rng(1), style=style)
        sizes[name] = (len(building.walls.triangles), len(building.glass.triangles))
    assert len(set(sizes.values())) == len(sizes)


@pytest.mark.parametrize('seed', [0, 1, 2])
def test_furniture_stays_in_rooms_and_off_doors_and_path(seed):
    plan = generate_plan(np.random.default_rng(seed), 'double_corridor')
    outlines = plan.outlines
    path = shapely.LineString([outlines[0].centroid, outlines[1].centroid]).buffer(0.4)
    pieces = furnish(plan, np.random.default_rng(seed), path)
    assert len(pieces) > len(plan.rooms) / 2
    for piece in pieces:
        assert any(outline.covers(piece.footprint) for outline in outlines)
        assert not piece.footprint.intersects(path)
        bases = [shapely.Polygon(ring) for ring in piece.boxes.rings]
        assert piece.footprint.buffer(1e-6).covers(shapely.union_all(bases))
        bottom, top = piece.boxes.span.T
        assert ((bottom >= 0.0) & (bottom < top) & (top < CEILING_M)).all()
    for door in plan.doors:
        for sign in (-1.0, 1.0):
            before = door.ends.mean(axis=0) + sign * 0.9 * DOOR_CLEARANCE_M * door.normal
            assert not any(p.footprint.contains(shapely.Point(before)) for p in pieces)
    for a in range(len(pieces)):
        assert not any(pieces[a].footprint.intersects(p.footprint) for p in pieces[:a])


def test_loose_furniture_keeps_off_doors_and_is_sliced_by_height():
    plan = generate_plan(np.random.default_rng(1), 'double_corridor')
    boxes = furnish_loosely(plan, np.random.default_rng(1))
    again = furnish_loosely(plan, np.random.default_rng(1))
    np.testing.assert_array_equal(boxes.rings, again.rings)
    assert len(boxes.rings) > 5 * len(plan.rooms)
    reach = shapely.convex_hull(
        shapely.multipoints(np.concatenate([r.polygon for r in plan.rooms]))
    )
    assert reach.buffer(3.0).covers(shapely.multipoints(boxes.rings.reshape(-1, 2)))
    for height in (0.05, 0.4, 1.2):
        met = boxes.met_at(height)
        assert len(met) == ((boxes.span[:, 0] <= height) & (boxes.span[:, 1] >= height)).sum()
    assert not boxes.met_at(2.5)
    # A piece's own box may reach towards a door from behind the clearance, its middle hardly.
    for door in plan.doors:
        away = np.hypot(*(boxes.centre - door.ends.mean(axis=0)).T)
        assert np.quantile(away, 0.01) > LOOSE_DOOR_CLEARANCE_M / 2.0


def test_symbols_are_of_their_pieces_and_rooms_hold_what_their_size_allows():
    plan = generate_plan(np.random.default_rng(4), 'suites')
    outlines = plan.outlines
    ways = {number for number, room in enumerate(plan.rooms) if room.kind != 'room'}
    kinds = {True: set(), False: set()}
    for seed in range(6):
        for piece in furnish(plan, np.random.default_rng(seed), stocks=DRAWN, empty=ways):
            drawn = [shapely.Polygon(ring) for ring in piece.rings]
            drawn += [shapely.Point(x, y).buffer(r) for x, y, r in piece.discs.tolist()]
            assert drawn
            assert piece.footprint.buffer(1e-6).covers(shapely.union_all(drawn))
            assert len(piece.discs) == piece.rounded
            (room,) = np.flatnonzero(shapely.covers(outlines, piece.footprint)).tolist()
            assert room not in ways
            kinds[bool(outlines[room].area > DRAWN[0].most_m2)].add(piece.kind)
    assert kinds[False] == {'toilet', 'basin'}
    assert {'table', 'round table', 'counter', 'plant'} <= kinds[True]
    assert not kinds[False] & kinds[True]


def test_boxes_turn_about_their_own_origin():
    piece = furnish(generate_plan(np.random.default_rng(0), 'house'), np.random.default_rng(0))[0]
    turned = piece.moved(np.array([3.0, -2.0]), np.pi / 2.0).boxes.rings
    expected = piece.boxes.rings @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + [3.0, -2.0]
    np.testing.assert_allclose(turned, expected, atol=1e-9)


@pytest.mark.parametrize('seed', range(4))
def test_the_caps_of_a_prism_fill_its_area_and_no_more(seed):
    """A comb with a hole: Delaunay's triangles cross its edges."""
    rng = np.random.default_rng(seed)
    teeth = [shapely.box(x, 0.5, x + rng.uniform(0.1, 0.8), rng.uniform(1, 9)) for x in range(12)]
    comb = shapely.union_all([shapely.box(0, 0, 13, 1), *teeth, shapely.Point(6, 4).buffer(2)])
    comb = comb - shapely.Point(6, 4).buffer(rng.uniform(0.3, 1.8))
    area = shapely.transform(comb, lambda xy: xy @ np.array([[0.8, 0.6], [-0.6, 0.8]]))
    corners = horizontal_sheet(area, 1.5, faces_up=True).corners
    assert (corners[..., 2] == 1.5).all()
    triangles = shapely.polygons(corners[..., :2])
    assert shapely.area(triangles).sum() == pytest.approx(area.area, rel=1e-9)
    assert shapely.area(shapely.difference(triangles, area)).sum() < 1e-9
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] >= 0.0).all()
