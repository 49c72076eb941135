# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sensor models: where their rays go, and what their scans look like."""

import numpy as np
import pytest

from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.buildings.fittings import BuildingStyle
from fpnet_lab.sim.drives.scanning import cast_scan
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.lidars.lidar import LidarSimulator
from fpnet_lab.sim.lidars.sensors import SENSORS
from fpnet_lab.sim.plans import generate_plan


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
        ('beams16', -15.0, 15.0, 180.0),
        ('beams32', -22.5, 22.5, 180.0),
        ('beams64', -45.0, 45.0, 180.0),
        ('dome', -7.0, 52.0, 180.0),
        ('rosette', -35.0, 35.0, 35.0),
        ('planar', 0.0, 0.0, 180.0),
    ],
)
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
