# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drives: tours through doors, wheels that drift, meshes as buildings."""

import numpy as np
import open3d as o3d
import pytest
import shapely

from fpnet_core.errors import ConfigError, MapFormatError
from fpnet_lab.sim.buildings.meshes import (
    TriangleMesh,
    extrude_polygon,
    horizontal_sheet,
    merge_meshes,
)
from fpnet_lab.sim.buildings.openings import walkable_area
from fpnet_lab.sim.drives.drift import WheelErrors, wheel_odometry
from fpnet_lab.sim.drives.driving import MOTION
from fpnet_lab.sim.drives.mesh_worlds import CELL_M, read_mesh, survey_mesh
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.lidars.sensors import SENSORS
from fpnet_lab.sim.plans import generate_plan

EXACT = WheelErrors(length=0.0, turn=0.0, slip_rad_per_sqrt_m=0.0, slip_turn=0.0)


@pytest.fixture
def truth():
    """A drive of 40 m along an S, which starts somewhere and turned."""
    time = np.linspace(0.0, 40.0, 401)
    yaw = 0.7 + 1.2 * np.sin(time / 5.0)
    step = np.diff(time) * 1.0
    middle = (yaw[1:] + yaw[:-1]) / 2.0
    xy = np.cumsum(step[:, None] * np.stack([np.cos(middle), np.sin(middle)], 1), axis=0)
    poses = np.tile(np.eye(4), (401, 1, 1))
    poses[:, 0, 0], poses[:, 1, 1] = np.cos(yaw), np.cos(yaw)
    poses[:, 1, 0], poses[:, 0, 1] = np.sin(yaw), -np.sin(yaw)
    poses[:, :2, 3] = np.array([3.0, -8.0]) + np.concatenate([[[0.0, 0.0]], xy])
    poses[:, 2, 3] = 0.9
    return poses


def test_without_errors_it_is_the_truth_from_its_first_pose(truth):
    odometry = wheel_odometry(truth, np.random.default_rng(0), EXACT)
    expected = np.linalg.inv(truth[0]) @ truth
    assert np.allclose(odometry, expected, atol=1e-9)


def test_drift_is_that_of_wheels(truth):
    ends = [wheel_odometry(truth, np.random.default_rng(seed))[-1] for seed in range(40)]
    wanted = np.linalg.inv(truth[0]) @ truth[-1]
    away = [np.linalg.norm(end[:2, 3] - wanted[:2, 3]) for end in ends]
    assert 0.1 < np.median(away) < 4.0
    assert np.max(away) < 12.0
    again = wheel_odometry(truth, np.random.default_rng(5))
    assert np.array_equal(again[-1], ends[5])


SEEDS = (0, 1, 2, 3)
CLEARANCE_M = 0.2  # a robot's half width; the narrowest doors leave 0.375 m


@pytest.fixture(scope='module', params=SEEDS)
def plan_and_tour(request):
    family = ('double_corridor', 'bent', 'diagonal', 'bays')[request.param]
    plan = generate_plan(np.random.default_rng(request.param), family, min_rooms=13)
    return plan, plan_tour(plan, np.random.default_rng(request.param + 100))


def test_tour_stays_clear_of_walls(plan_and_tour):
    plan, tour = plan_and_tour
    area = walkable_area(plan)
    points = shapely.points(tour.xy)
    assert shapely.covers(area, points).all()
    assert shapely.distance(area.boundary, points).min() > CLEARANCE_M


def test_tour_respects_the_drive(plan_and_tour):
    _, tour = plan_and_tour
    limits = TourLimits()
    step = np.diff(tour.time_s)
    speed = np.linalg.norm(np.diff(tour.xy, axis=0), axis=1) / step
    rate = np.diff(tour.yaw_rad) / step
    assert speed.max() <= MOTION.speed_mps + 1e-6
    assert np.abs(rate).max() <= MOTION.turn_rate_radps + 1e-6
    assert np.abs(np.diff(speed) / step[1:]).max() <= MOTION.acceleration_mps2 * 1.01
    assert np.abs(np.diff(rate) / step[1:]).max() <= MOTION.turn_acceleration_radps2 * 1.01
    assert limits.shortest_s <= tour.duration_s <= limits.longest_s
    assert np.abs(tour.tilt_rad).max() < 6.0 * MOTION.sway_rad
    still = round(MOTION.standstill_s / MOTION.step_s)
    assert np.ptp(tour.xy[:still], axis=0).max() == 0.0


def test_equal_generators_give_equal_tours():
    plan = generate_plan(np.random.default_rng(4), 'bent', min_rooms=13)
    first, second = (plan_tour(plan, np.random.default_rng(5)) for _ in range(2))
    assert np.array_equal(first.xy, second.xy)
    assert np.array_equal(first.tilt_rad, second.tilt_rad)
    assert first.rooms == second.rooms


def test_impossible_tour_is_refused():
    plan = generate_plan(np.random.default_rng(0), 'bent', min_rooms=13)
    with pytest.raises(ConfigError, match='no tour through 500'):
        plan_tour(plan, np.random.default_rng(0), TourLimits(rooms=500))


FLOOR_Z = -0.7
SHORT = TourLimits(rooms=1, shortest_s=10.0, longest_s=60.0)


def flat_mesh(has_walls=True, ground=(-6.0, -6.0, 20.0, 14.0)):
    """Two rooms of 6 x 7 m with a door of 1 m, a table, and ground all around; no ceiling."""
    rooms = shapely.union_all(
        [shapely.box(0, 0, 6, 7), shapely.box(6.2, 0, 12, 7), shapely.box(5.9, 3, 6.3, 4)]
    )
    walls = shapely.difference(shapely.box(-0.3, -0.3, 12.3, 7.3), rooms)
    parts = [horizontal_sheet(shapely.box(*ground), FLOOR_Z, faces_up=True)]
    if has_walls:
        parts.append(extrude_polygon(walls, FLOOR_Z, FLOOR_Z + 2.5))
    parts.append(extrude_polygon(shapely.box(2, 3, 3.5, 4), FLOOR_Z + 0.7, FLOOR_Z + 0.75))
    return merge_meshes(parts)


@pytest.fixture(scope='module')
def world():
    return survey_mesh(flat_mesh())


def is_free(world, x, y):
    column, row = np.floor((np.array([x, y]) - world.origin) / CELL_M).astype(int)
    return bool(world.free[row, column])


def test_indoors_is_free_and_outside_is_not(world):
    for inside in ((1.0, 1.0), (5.0, 6.0), (9.0, 3.5), (6.1, 3.5)):
        assert is_free(world, *inside)
    for outside in ((-3.0, 3.0), (15.0, 5.0), (6.1, 1.0), (-0.15, 3.0), (2.7, 3.5)):
        assert not is_free(world, *outside)
    area = np.count_nonzero(world.free) * CELL_M**2
    assert area == pytest.approx(6 * 7 + 5.8 * 7 + 0.2 - 1.5, rel=0.05)


def test_a_mesh_is_recorded_with_its_own_floorplan(tmp_path):
    mesh = flat_mesh()
    legacy = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices), o3d.utility.Vector3iVector(mesh.triangles)
    )
    o3d.io.write_triangle_mesh(str(tmp_path / 'flat.ply'), legacy)
    options = RecordingOptions(lidar=SENSORS['planar'], limits=SHORT)
    recording = make_recording(3, options, threads=1, mesh=read_mesh(tmp_path / 'flat.ply'))
    assert len(recording.building.plan.rooms) == 2
    assert recording.tour.rooms
    scan = recording.scan(5)
    ends = scan.points @ scan.T_truth_sensor[:3, :3].T + scan.T_truth_sensor[:3, 3]
    assert len(ends) > 900
    assert ((ends[:, :2] > -0.2) & (ends[:, :2] < (12.2, 7.2))).all(axis=1).mean() > 0.98
    again = make_recording(3, options, threads=2, mesh=mesh)
    assert again.tour.path_m == pytest.approx(recording.tour.path_m, abs=1e-3)


@pytest.mark.parametrize(
    ('mesh', 'message'),
    [
        (flat_mesh(has_walls=False), 'enclosed'),
        (extrude_polygon(shapely.box(0, 0, 0.5, 0.5), 0.0, 2.0), 'enclosed'),
        (TriangleMesh(np.eye(3) * 5.0, np.array([[0, 1, 2]])), 'no horizontal surface'),
    ],
    ids=['open ground', 'a solid block', 'a slope'],
)
def test_a_mesh_without_closed_space_is_refused(mesh, message):
    with pytest.raises(MapFormatError, match=message):
        survey_mesh(mesh)


def test_unreadable_meshes_are_refused(tmp_path):
    with pytest.raises(MapFormatError, match='does not exist'):
        read_mesh(tmp_path / 'none.ply')
    (tmp_path / 'broken.ply').write_text('ply\nformat ascii 1.0\nend_header\n')
    with pytest.raises(MapFormatError, match='no triangles'):
        read_mesh(tmp_path / 'broken.ply')


def test_a_floorplan_of_another_building_is_refused(world):
    elsewhere = world.floorplan()
    far = type(elsewhere)(
        elsewhere.cells, elsewhere.resolution, type(elsewhere.T_frame_grid).from_xy_yaw(90, 0, 0)
    )
    with pytest.raises(MapFormatError, match='same building'):
        make_recording(3, RecordingOptions(limits=SHORT), mesh=flat_mesh(), floorplan=far)
