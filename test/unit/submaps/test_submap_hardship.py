# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans that no sensor should send: nothing hangs, memory stays bounded, results say why."""

import numpy as np
import pytest

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import CloudFormatError, OdometryError
from fpnet_core.segmentation import segment_submap
from fpnet_core.submaps import SubmapBuilder, raster, submap_from_cloud
from fpnet_core.types import FREE, OCCUPIED


def submap_of(points, scans=3, pose=None, config=None):
    builder = SubmapBuilder(config or SubmapConfig())
    for k in range(scans):
        builder.add_scan(points, np.eye(4) if pose is None else pose, k)
    return builder.take()


def room_scan(rng, half_m=3.0, points=12_000):
    """A square room around the sensor, 0.9 m above the floor, ceiling at 2.7 m."""
    rays = rng.normal(size=(points, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    walls = half_m / np.abs(rays[:, :2]).max(axis=1)
    floor = np.where(rays[:, 2] < 0, 0.9 / np.abs(rays[:, 2]), 1.8 / np.abs(rays[:, 2]))
    return (rays * np.minimum(walls, floor)[:, None]).astype(np.float32)


def test_one_point_is_no_room_and_says_so():
    segmentation = segment_submap(submap_of(np.array([[2.0, 0.0, 0.0]])))
    assert segmentation.regions == ()
    assert segmentation.reason


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_points_in_one_plane_are_one_room_of_what_was_seen(axis):
    points = np.random.default_rng(axis).uniform(-4.0, 4.0, (5000, 3))
    points[:, axis] = -0.9
    submap = submap_of(points)
    segmentation = segment_submap(submap)
    [room] = segmentation.rooms
    assert room.area_m2 == pytest.approx(submap.free_area_m2, rel=0.15)
    assert segmentation.portals == ()


def test_points_at_the_sensor_itself_are_dropped():
    assert submap_of(np.zeros((100, 3))) is None


def test_a_tilted_sensor_sees_the_same_room():
    rng = np.random.default_rng(3)
    level = submap_of(room_scan(rng))
    c, s = np.cos(0.3), np.sin(0.3)
    pose = np.eye(4)
    pose[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    tilted = submap_of(room_scan(rng) @ pose[:3, :3], pose=pose)
    areas = [segment_submap(submap).rooms[0].area_m2 for submap in (level, tilted)]
    assert areas[0] == pytest.approx(36.0, rel=0.08)
    assert areas[1] == pytest.approx(areas[0], rel=0.05)


def test_a_million_outliers_neither_stretch_the_raster_nor_hide_the_room():
    rng = np.random.default_rng(4)
    outliers = rng.uniform(-1000.0, 1000.0, (1_000_000, 3)).astype(np.float32)
    config = SubmapConfig()
    builder = SubmapBuilder(config)
    for k in range(6):
        builder.add_scan(room_scan(rng), np.eye(4), 2 * k)
    builder.add_scan(outliers, np.eye(4), 99)
    submap = builder.take()
    assert max(submap.grid.shape) * submap.grid.resolution < 2.0 * config.max_range_m + 1.0
    walls = np.count_nonzero(submap.grid.cells == OCCUPIED)
    assert walls > 200
    assert (submap.grid.cells == FREE).any()


def test_a_robot_that_drives_too_far_is_refused_and_keeps_its_map(monkeypatch):
    monkeypatch.setattr(raster, 'MAX_EXTENT_M', 60.0)
    builder = SubmapBuilder(SubmapConfig())
    scan = room_scan(np.random.default_rng(5), points=500)
    pose = np.eye(4)
    for k in range(6):
        pose[0, 3] = 8.0 * k
        builder.add_scan(scan, pose, k)
    pose[0, 3] = 80.0
    with pytest.raises(OdometryError, match='odometry has'):
        builder.add_scan(scan, pose, 99)
    assert builder.take().grid.shape[1] * 0.05 < 60.0


def test_a_start_far_from_the_origin_costs_no_memory():
    pose = np.eye(4)
    pose[:2, 3] = 5e5, 5e6
    submap = submap_of(room_scan(np.random.default_rng(6), points=3000), pose=pose)
    assert max(submap.grid.shape) < 200


@pytest.mark.parametrize(
    ('points', 'reason'),
    [
        (np.zeros((0, 3)), 'no points'),
        (np.full((9, 3), np.nan), 'NaN'),
        (np.array([[1.0, 2.0, 0.0]]), 'no floor'),
        (np.c_[np.random.default_rng(0).uniform(0, 5, (500, 2)), np.zeros(500)], 'no floor'),
        (np.random.default_rng(0).uniform(-1e5, 1e5, (100, 3)), 'crop it'),
    ],
)
def test_clouds_that_are_no_map_are_refused(points, reason):
    with pytest.raises(CloudFormatError, match=reason):
        submap_from_cloud(points, SubmapConfig())
