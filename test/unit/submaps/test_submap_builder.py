# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans of an analytic two-room building: walls, free space, lintel, memory, bad input."""

import numpy as np
import pytest

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import CloudFormatError, OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.segmentation import segment_submap
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import FREE, OCCUPIED

SENSOR_HEIGHT_M = 0.9
CEILING_M = 2.7
LINTEL_M = 2.05
# Building frame: rooms 6 x 4 m and 3.5 x 4 m, wall 0.2 m thick at x = 6, door y 1.0 to 1.9.
OUTER = ((0.0, 9.7), (0.0, 4.0))
WALL_X = (6.0, 6.2)
DOOR_Y = (1.0, 1.9)
T_ODOM_BUILDING = SE2.from_xy_yaw(3.0, -7.0, np.deg2rad(27.0))


def boxes():
    """Axis-aligned boxes (low, high) of all solid parts, building frame, floor at z = 0."""
    (x0, x1), (y0, y1) = OUTER
    t = 0.2
    return np.array(
        [
            [[x0 - t, y0 - t, 0], [x0, y1 + t, CEILING_M]],
            [[x1, y0 - t, 0], [x1 + t, y1 + t, CEILING_M]],
            [[x0, y0 - t, 0], [x1, y0, CEILING_M]],
            [[x0, y1, 0], [x1, y1 + t, CEILING_M]],
            [[WALL_X[0], y0, 0], [WALL_X[1], DOOR_Y[0], CEILING_M]],
            [[WALL_X[0], DOOR_Y[1], 0], [WALL_X[1], y1, CEILING_M]],
            [[WALL_X[0], DOOR_Y[0], LINTEL_M], [WALL_X[1], DOOR_Y[1], CEILING_M]],
            [[x0 - t, y0 - t, -0.1], [x1 + t, y1 + t, 0.0]],
            [[x0 - t, y0 - t, CEILING_M], [x1 + t, y1 + t, CEILING_M + 0.1]],
        ]
    )


def cast(origin, directions, solids):
    """Distances to the first box along unit ``directions (P, 3)`` (slab method)."""
    with np.errstate(divide='ignore'):
        inverse = 1.0 / directions[:, None, :]
    a = (solids[None, :, 0] - origin) * inverse
    b = (solids[None, :, 1] - origin) * inverse
    enter = np.minimum(a, b).max(axis=2)
    leave = np.maximum(a, b).min(axis=2)
    distance = np.where((enter <= leave) & (enter > 0.0), enter, np.inf)
    return distance.min(axis=1)


def lidar_scan(rng, xy_building, yaw, columns=400, rings=24, half_fov_deg=22.5, tilt_rad=0.0):
    """Return points (sensor frame) and T_odom_sensor; odom z = 0 is the sensor's start."""
    azimuth = np.linspace(-np.pi, np.pi, columns, endpoint=False)
    elevation = np.deg2rad(np.linspace(-half_fov_deg, half_fov_deg, rings))
    azimuth, elevation = (g.ravel() for g in np.meshgrid(azimuth, elevation, indexing='ij'))
    azimuth = azimuth + rng.normal(0.0, 2e-3, azimuth.size)
    flat = np.cos(elevation)
    rays = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=1)
    c, s = np.cos(tilt_rad), np.sin(tilt_rad)
    tilt = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    T_building_sensor = SE2.from_xy_yaw(*xy_building, yaw).as_matrix4(SENSOR_HEIGHT_M)
    T_building_sensor[:3, :3] = T_building_sensor[:3, :3] @ tilt
    distance = cast(T_building_sensor[:3, 3], rays @ T_building_sensor[:3, :3].T, boxes())
    distance = distance + rng.normal(0.0, 0.01, distance.size)
    T_odom_sensor = T_ODOM_BUILDING.as_matrix4(-SENSOR_HEIGHT_M) @ T_building_sensor
    return (rays * distance[:, None]).astype(np.float32), T_odom_sensor


def tour(builder, waypoints, seed=0, **scan):
    rng = np.random.default_rng(seed)
    for k, (x, y, yaw) in enumerate(waypoints):
        points, pose = lidar_scan(rng, (x, y), yaw, **scan)
        builder.add_scan(points, pose, k * 100_000_000)


BOTH_ROOMS = [
    *((x, 2.4, 0.3) for x in np.linspace(1.0, 5.0, 12)),
    *((x, 1.45, 0.0) for x in np.linspace(5.2, 7.2, 10)),
    *((8.0, y, 1.1) for y in np.linspace(1.5, 2.8, 8)),
]


@pytest.fixture(scope='module')
def both_rooms():
    builder = SubmapBuilder(SubmapConfig())
    tour(builder, BOTH_ROOMS, tilt_rad=0.02)
    return builder.take()


def cell_values(submap, xy_building):
    rc = np.rint(submap.grid.xy_to_rc(T_ODOM_BUILDING.apply(xy_building))).astype(int)
    return submap.grid.cells[rc[:, 0], rc[:, 1]]


def test_free_space_is_where_the_rooms_are(both_rooms):
    inside = np.array([[1.0, 1.0], [3.0, 3.5], [5.5, 0.5], [6.1, 1.45], [8.5, 3.0]])
    assert (cell_values(both_rooms, inside) == FREE).all()
    assert both_rooms.free_area_m2 == pytest.approx(9.7 * 4.0 - 0.2 * 3.1, rel=0.06)


def test_walls_are_occupied_on_the_seen_side(both_rooms):
    rng = np.random.default_rng(1)
    y = rng.uniform(2.2, 3.8, 40)
    faces = np.stack([np.full_like(y, 5.98), y], axis=1)
    near = np.concatenate([faces + np.array([offset, 0.0]) for offset in (0.0, 0.03, 0.06)])
    occupied = (cell_values(both_rooms, near) == OCCUPIED).reshape(3, -1).any(axis=0)
    assert occupied.mean() > 0.9


def test_two_rooms_and_a_lintel_door_come_out(both_rooms):
    segmentation = segment_submap(both_rooms)
    areas = sorted(room.area_m2 for room in segmentation.rooms)
    assert areas == pytest.approx([14.0, 24.0], rel=0.06)
    (portal,) = segmentation.portals
    assert portal.has_lintel
    assert set(portal.rooms) == {0, 1}
    assert portal.width_m == pytest.approx(0.9, abs=0.15)
    middle = T_ODOM_BUILDING.inv().apply(portal.ends.mean(axis=0))
    assert middle == pytest.approx([6.1, 1.45], abs=0.15)
    assert all(room.observed_fraction > 0.95 for room in segmentation.rooms)


def test_a_glimpse_through_the_door_keeps_the_door_and_drops_the_room():
    builder = SubmapBuilder(SubmapConfig())
    tour(builder, [(x, 3.0, 0.2) for x in np.linspace(4.6, 5.4, 8)])
    segmentation = segment_submap(builder.take())
    assert len(segmentation.rooms) == 1
    assert [portal.rooms for portal in segmentation.portals] == [(0, None)]


def test_standing_still_does_not_erode_the_walls():
    config = SubmapConfig(max_rays=2000)
    areas = []
    for scans in (20, 400):
        builder = SubmapBuilder(config)
        rng = np.random.default_rng(3)
        points, pose = lidar_scan(rng, (2.0, 2.2), 0.4, columns=300)
        for k in range(scans):
            noise = rng.normal(0.0, 0.01, points.shape)
            builder.add_scan(points + noise, pose, k)
        segmentation = segment_submap(builder.take())
        areas.append(segmentation.rooms[0].area_m2)
    assert areas[1] == pytest.approx(areas[0], rel=0.05)


def test_planar_scans_build_the_same_room():
    builder = SubmapBuilder(SubmapConfig())
    tour(builder, BOTH_ROOMS, rings=1, half_fov_deg=0.0, columns=720)
    submap = builder.take()
    assert not submap.lintel.any()
    segmentation = segment_submap(submap)
    areas = sorted(room.area_m2 for room in segmentation.rooms)
    assert areas == pytest.approx([14.0, 24.0], rel=0.06)


def test_take_hands_out_only_news():
    builder = SubmapBuilder(SubmapConfig())
    assert builder.take() is None
    points, pose = lidar_scan(np.random.default_rng(0), (2.0, 2.0), 0.0, columns=100)
    builder.add_scan(points, pose, 5)
    first = builder.take()
    assert (first.id, first.stamp_ns) == (1, 5)
    assert builder.take() is None
    builder.add_scan(points, pose, 9)
    assert builder.take().id == 2
    assert first.path_xy == pytest.approx(pose[None, :2, 3])
    builder.reset()
    assert builder.take() is None


def test_rays_beyond_the_range_carve_but_leave_no_wall():
    builder = SubmapBuilder(SubmapConfig(max_range_m=5.0))
    angle = np.linspace(0.0, 2.0 * np.pi, 720)
    far = np.stack([20.0 * np.cos(angle), 20.0 * np.sin(angle), 0.0 * angle], axis=1)
    builder.add_scan(far, np.eye(4), 0)
    submap = builder.take()
    assert (submap.grid.cells == OCCUPIED).sum() == 0
    assert max(submap.grid.shape) * submap.grid.resolution == pytest.approx(10.0, abs=0.3)
    rc = np.rint(submap.grid.xy_to_rc([4.5, 0.5])).astype(int)
    assert submap.grid.cells[tuple(rc)] == FREE


@pytest.mark.parametrize(
    'points',
    [np.zeros((5, 2)), np.zeros(3), np.array([[1.0, np.nan, 0.0]]), np.full((1, 3), np.inf)],
)
def test_bad_points_are_refused_and_change_nothing(points):
    builder = SubmapBuilder(SubmapConfig())
    with pytest.raises(CloudFormatError):
        builder.add_scan(points, np.eye(4), 0)
    assert builder.take() is None


@pytest.mark.parametrize(
    'pose', [np.eye(3), np.eye(4) * 2.0, np.diag([1.0, 1.0, -1.0, 1.0]), np.full((4, 4), np.nan)]
)
def test_bad_poses_are_refused(pose):
    with pytest.raises(OdometryError):
        SubmapBuilder(SubmapConfig()).add_scan(np.ones((1, 3)), pose, 0)


def test_diverged_odometry_is_refused_before_memory_is_taken():
    builder = SubmapBuilder(SubmapConfig())
    builder.add_scan(np.ones((4, 3)), np.eye(4), 0)
    far = np.eye(4)
    far[0, 3] = 1e6
    with pytest.raises(OdometryError, match='diverged'):
        builder.add_scan(np.ones((4, 3)), far, 1)
    assert builder.take() is not None


def test_rays_begin_at_their_viewpoints():
    """Two scanners side by side look along x; nothing is carved from the place between them."""
    y = np.repeat([1.0, -1.0], 40)
    wall = np.stack([np.full(80, 4.0), y + np.tile(np.linspace(-0.1, 0.1, 40), 2)], axis=1)
    points, begins = np.pad(wall, ((0, 0), (0, 1))), np.stack([0 * y, y, 0 * y], axis=1)
    builder = SubmapBuilder(SubmapConfig(resolution_m=0.1))
    pose = T_ODOM_BUILDING.as_matrix4(0.3)
    builder.add_scan(points.astype(np.float32), pose, 0, begins.astype(np.float32))
    grid = builder.take().grid
    along = np.linspace(0.3, 3.6, 30)

    def cells(y_m):
        xy = T_ODOM_BUILDING.apply(np.stack([along, np.full(30, y_m)], axis=1))
        rows, columns = np.floor(grid.xy_to_rc(xy)).astype(int).T
        return grid.cells[rows, columns]

    assert (cells(1.0) == FREE).mean() > 0.9
    assert (cells(-1.0) == FREE).mean() > 0.9
    assert (cells(0.5) != FREE).all()
    with pytest.raises(CloudFormatError, match='80 points but 79 viewpoints'):
        builder.add_scan(points, pose, 1, begins[:79])


@pytest.mark.parametrize(
    ('name', 'bad'),
    [
        ('scans', np.zeros((3, 3), np.int64)),
        ('scans', np.zeros(3)),
        ('heights_m', np.zeros((2, 2))),
        ('histogram', np.array('x')),
    ],
)
def test_saved_arrays_of_another_shape_are_refused(name, bad):
    arrays = SubmapBuilder(SubmapConfig()).arrays()
    SubmapBuilder.restored(SubmapConfig(), arrays)
    with pytest.raises(ValueError, match=name.removesuffix('_m')):
        SubmapBuilder.restored(SubmapConfig(), {**arrays, name: bad})


def test_empty_scan_is_accepted():
    builder = SubmapBuilder(SubmapConfig())
    builder.add_scan(np.zeros((0, 3)), np.eye(4), 0)
    assert builder.take() is None
