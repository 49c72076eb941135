# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Buildings, sensors and recordings: scans agree with the truth and the mesh."""

from itertools import islice

import numpy as np
import open3d as o3d
import pytest
from scipy.spatial.transform import Rotation
import shapely

from fpnet.recordings.opening import open_scans
from fpnet_core.errors import ConfigError
from fpnet_core.types import FREE, OCCUPIED
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.buildings.fittings import BUILDING_STYLES, BuildingStyle
from fpnet_lab.sim.buildings.furnishing import DOOR_CLEARANCE_M, furnish
from fpnet_lab.sim.buildings.meshes import merge_meshes
from fpnet_lab.sim.buildings.openings import walkable_area
from fpnet_lab.sim.drives.driving import WALK
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording, write_recording
from fpnet_lab.sim.drives.scanning import EPOCH_NS, cast_scan
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.lidars.lidar import LidarModel, LidarSimulator
from fpnet_lab.sim.lidars.sensors import SENSORS
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom

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


@pytest.fixture(scope='module')
def building_and_tour():
    plan = generate_plan(np.random.default_rng(0), 'double_corridor', min_rooms=13)
    rng = np.random.default_rng(1)
    tour = plan_tour(plan, rng, TourLimits(rooms=2, shortest_s=3.0, longest_s=40.0))
    return extrude(plan, rng, keep_clear=tour.line().buffer(0.45)), tour


def angles_deg(points):
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    elevation = np.arctan2(points[:, 2], np.linalg.norm(points[:, :2], axis=1))
    return np.rad2deg(azimuth), np.rad2deg(elevation)


@pytest.mark.parametrize(
    ('name', 'lowest', 'highest', 'widest'),
    [
        ('beams16', -15.0, 15.0, 180.0), ('beams32', -22.5, 22.5, 180.0),
        ('beams64', -45.0, 45.0, 180.0), ('dome', -7.0, 52.0, 180.0),
        ('rosette', -35.0, 35.0, 35.0), ('planar', 0.0, 0.0, 180.0),
    ],
)  # fmt: skip
def test_rays_fill_the_field_of_view(name, lowest, highest, widest):
    rays = SENSORS[name].directions(0.0, np.random.default_rng(0))
    assert rays.shape == (SENSORS[name].columns, SENSORS[name].beams, 3)
    assert np.linalg.norm(rays, axis=-1) == pytest.approx(1.0, abs=1e-6)
    azimuth, elevation = angles_deg(rays.reshape(-1, 3))
    assert elevation.min() == pytest.approx(lowest, abs=1.0)
    assert elevation.max() == pytest.approx(highest, abs=1.0)
    assert np.abs(azimuth).max() == pytest.approx(widest, abs=1.0)


@pytest.mark.parametrize('name', sorted(SENSORS))
def test_every_sensor_scans_a_building(name, building_and_tour):
    building, tour = building_and_tour
    model = SENSORS[name]
    lidar, rng = LidarSimulator(building, model), np.random.default_rng(3)
    scan, second = (cast_scan(lidar, tour, index, rng) for index in range(2))
    assert 0.6 * model.beams * model.columns < len(scan.points) <= model.beams * model.columns
    assert np.isfinite(scan.points).all()
    assert (np.diff(scan.time_s) >= 0.0).all()
    assert 0.9 * model.period_s < np.ptp(scan.time_s) < model.period_s
    if name == 'planar':
        assert not scan.points[:, 2].any()
    assert second.stamp_ns - scan.stamp_ns == 100_000_000
    again = cast_scan(LidarSimulator(building, model, 2), tour, 0, np.random.default_rng(3))
    assert again.points.tobytes() == scan.points.tobytes()


def test_rays_pass_glass_unless_it_faces_them(building_and_tour):
    building, tour = building_and_tour
    rng = np.random.default_rng(1)
    opaque = extrude(building.plan, rng, is_furnished=False)
    glazed = extrude(
        building.plan, rng, is_furnished=False, style=BuildingStyle(windows=1.0, glass_fronts=1.0)
    )
    first, second = (
        cast_scan(LidarSimulator(b, SENSORS['beams32']), tour, 0, np.random.default_rng(2))
        for b in (opaque, glazed)
    )
    assert 0.5 * len(first.points) < len(second.points) < 0.99 * len(first.points)
