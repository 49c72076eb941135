# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recordings: scans agree with the truth and the mesh, the floorplan with its transform."""

from itertools import islice

import numpy as np
import open3d as o3d
import pytest
from scipy.spatial.transform import Rotation
import shapely

from fpnet_core.errors import ConfigError
from fpnet_core.io.recordings import open_scans
from fpnet_core.types import FREE, OCCUPIED
from fpnet_lab.sim.buildings.meshes import merge_meshes
from fpnet_lab.sim.buildings.openings import walkable_area
from fpnet_lab.sim.drives.driving import WALK
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording, write_recording
from fpnet_lab.sim.drives.scanning import EPOCH_NS
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.lidars.lidar import LidarModel

COARSE = LidarModel(beams=16, columns=180)
SEED = 7


@pytest.fixture(scope='module')
def recording():
    return make_recording(SEED, RecordingOptions(lidar=COARSE), threads=1)


def mesh_distance(recording, points):
    mesh = merge_meshes(recording.building.parts)
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32))
    return scene.compute_distance(points.astype(np.float32)).numpy()


def in_building(recording, scan, index):
    """Points (P, 3) of a scan through the sensor's true pose at each point's own time."""
    R, origin = recording.tour.sensor_poses(index * COARSE.period_s + scan.time_s)
    return np.einsum('pij,pj->pi', R, scan.points) + origin


def test_points_lie_on_the_mesh_within_the_noise(recording):
    index = len(recording) // 3
    distance = mesh_distance(recording, in_building(recording, recording.scan(index), index))
    assert np.median(distance) < COARSE.range_sigma_m
    assert np.percentile(distance, 99.0) < 4.0 * COARSE.range_sigma_m


def test_no_ray_escapes_or_ends_inside_a_wall(recording):
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(20000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    at = rng.integers(0, len(recording.tour.xy), len(directions))
    origins = np.column_stack([recording.tour.xy[at], np.full(len(at), 0.9)])
    mesh = merge_meshes(recording.building.parts)
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32))
    rays = np.hstack([origins, directions]).astype(np.float32)
    depth = scene.cast_rays(o3d.core.Tensor(rays))['t_hit'].numpy()
    assert np.isfinite(depth).all()
    ends = (origins + depth[:, None] * directions)[::20, :2]
    assert shapely.contains_xy(walkable_area(recording.building.plan).buffer(0.02), ends).all()


def test_motion_distorts_a_sweep(recording):
    # At a turn the pose at the sweep's end alone does not explain the points of its start.
    rate = np.abs(np.gradient(recording.tour.yaw_rad, recording.tour.time_s))
    index = int(recording.tour.time_s[np.argmax(rate)] / COARSE.period_s)
    scan = recording.scan(index)
    early = scan.time_s < 0.2 * COARSE.period_s
    T = scan.T_truth_sensor
    rigid = scan.points[early] @ T[:3, :3].T + T[:3, 3]
    assert np.percentile(mesh_distance(recording, rigid), 75) > 0.05
    moving = in_building(recording, scan, index)[early]
    assert np.percentile(mesh_distance(recording, moving), 75) < 0.03


def test_stamps_and_truth_are_the_sweeps_ends(recording):
    stamps, truth = recording.stamps_ns, recording.truth()
    assert len(recording) == len(stamps) == len(truth)
    assert len(recording) == pytest.approx(recording.tour.duration_s * 10.0, abs=1.0)
    assert set(np.diff(stamps)) == {100_000_000}
    scan = recording.scan(41)
    assert scan.stamp_ns == stamps[41] == EPOCH_NS + 4_200_000_000
    assert np.allclose(scan.T_truth_sensor, truth[41], atol=1e-12)
    expected = [np.interp(4.2, recording.tour.time_s, column) for column in recording.tour.xy.T]
    assert truth[41, :2, 3] == pytest.approx(expected)


def test_scan_has_what_a_driver_reports(recording):
    scan = recording.scan(10)
    count = len(scan.points)
    assert 0.7 * 16 * 180 < count <= 16 * 180
    assert scan.points.dtype == np.float32
    assert scan.intensity.shape == scan.ring.shape == scan.time_s.shape == (count,)
    assert set(np.unique(scan.ring)) == set(range(16))
    assert (np.diff(scan.time_s) >= 0.0).all()
    assert 0.0 <= scan.time_s[0] < scan.time_s[-1] < COARSE.period_s
    assert scan.intensity.min() >= 0.0
    assert scan.intensity.max() <= 255.0
    elevation = np.arctan2(scan.points[:, 2], np.linalg.norm(scan.points[:, :2], axis=1))
    assert np.rad2deg(elevation[scan.ring == 0]) == pytest.approx(-22.5, abs=0.6)
    assert np.rad2deg(elevation[scan.ring == 15]) == pytest.approx(22.5, abs=0.6)
    assert scan.T_odom_sensor is None


def test_floorplan_shows_the_building_through_its_transform(recording):
    plan, grid, A = recording.building.plan, recording.floorplan, recording.A_plan_building
    rc = np.rint(grid.xy_to_rc(A.apply(recording.tour.xy[::50]))).astype(int)
    assert (grid.cells[rc[:, 0], rc[:, 1]] == FREE).all()
    for outline in plan.outlines:
        inner = shapely.get_coordinates(outline.buffer(-0.35).exterior.segmentize(0.5))
        rc = np.rint(grid.xy_to_rc(A.apply(inner))).astype(int)
        assert (grid.cells[rc[:, 0], rc[:, 1]] == FREE).mean() > 0.95
    walls = np.concatenate(
        [
            shapely.get_coordinates(
                outline.buffer(plan.wall_m / 2.0, join_style='mitre').exterior.segmentize(0.2)
            )
            for outline in plan.outlines
        ]
    )
    doors = shapely.union_all([shapely.LineString(d.ends).buffer(0.3) for d in plan.doors])
    walls = walls[~shapely.contains_xy(doors, walls)]
    rc = np.rint(grid.xy_to_rc(A.apply(walls))).astype(int)
    assert (grid.cells[rc[:, 0], rc[:, 1]] == OCCUPIED).mean() > 0.9


def test_same_seed_gives_the_same_bytes_in_any_order(recording):
    again = make_recording(SEED, RecordingOptions(lidar=COARSE), threads=2)
    assert again.scan(30).points.tobytes() == recording.scan(30).points.tobytes()
    for first, second in zip(islice(recording, 3), islice(again, 3), strict=True):
        assert first.points.tobytes() == second.points.tobytes()
        assert first.intensity.tobytes() == second.intensity.tobytes()
    assert np.array_equal(again.floorplan.cells, recording.floorplan.cells)
    assert again.summary() == recording.summary()
    other = make_recording(SEED + 1, RecordingOptions(lidar=COARSE))
    assert other.scan(0).points.tobytes() != recording.scan(0).points.tobytes()


def test_unknown_family_and_impossible_rooms_are_refused():
    with pytest.raises(ConfigError, match='igloo'):
        make_recording(0, RecordingOptions(family='igloo'))
    with pytest.raises(ConfigError, match='no plan of family'):
        make_recording(0, RecordingOptions(family='bent', rooms=(12, 11)))


def test_a_gyroscope_tells_the_turns_of_a_walk_with_its_bias(tmp_path):
    limits = TourLimits(rooms=2, shortest_s=5.0, longest_s=20.0, motion=WALK)
    recording = make_recording(3, RecordingOptions(lidar=COARSE, limits=limits), threads=1)
    write_recording(recording, tmp_path, with_imu=True)
    scans = list(open_scans(tmp_path / 'bag'))
    told = Rotation.from_matrix(scans[0].R_gyro_sensor.T @ scans[-1].R_gyro_sensor)
    truth = recording.truth()[:, :3, :3]
    true = Rotation.from_matrix(truth[0].T @ truth[-1])
    off_deg = np.rad2deg((told.inv() * true).magnitude())
    assert 0.0 < off_deg < 2.0 * 0.3 * recording.tour.duration_s, 'two deviations of the bias'
    assert recording.tour.path_m / recording.tour.duration_s > 0.7
