# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Extruded buildings: closed prisms, lintels above doors, furniture out of the way."""

import numpy as np
import open3d as o3d
import pytest
import shapely

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.buildings.fittings import BUILDING_STYLES, BuildingStyle
from fpnet_lab.sim.buildings.furnishing import (
    DOOR_CLEARANCE_M,
    furnish,
)
from fpnet_lab.sim.buildings.meshes import extrude_polygon, merge_meshes
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


def test_a_shut_leaf_closes_its_door_and_never_that_on_the_way():
    east, low = (1.0, 0.0, 0.0), (4.0, 1.45, 1.0)
    assert cast(raised(leaves=1.0, closed=1.0), low, east) == pytest.approx(1.08, abs=0.01)
    way = shapely.LineString(turned([(3.0, 1.45), (7.0, 1.45)])).buffer(0.45)
    assert cast(raised(leaves=1.0, closed=1.0, clear=way), low, east) > 3.0


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
