# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floor and ceiling from returns: what is lowest in view is not always the floor."""

import numpy as np
import pytest

from fpnet_core.config import SubmapConfig
from fpnet_core.submaps.heights import HeightTracker

SENSOR_M, CEILING_M = 0.6, 2.7


def bands_after(elevations_deg, half_m, sensor_m=SENSOR_M, tracker=None, scans=4):
    """Scans of a square room; sensor-frame z is the height in odom as well."""
    tracker = tracker or HeightTracker(SubmapConfig())
    azimuth, elevation = np.meshgrid(np.linspace(-np.pi, np.pi, 720), np.radians(elevations_deg))
    level, up = np.cos(elevation), np.sin(elevation)
    rays = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), up], axis=-1).reshape(-1, 3)
    reach = half_m / np.abs(rays[:, :2]).max(axis=1)
    ends = np.where(rays[:, 2] < 0, sensor_m, CEILING_M - sensor_m) / np.abs(rays[:, 2])
    points = rays * np.minimum(reach, ends)[:, None]
    for _ in range(scans):
        bands = tracker.update(points, points[:, 2], 0.0)
    return bands


def floor_m(bands):
    return bands.body_low - SubmapConfig().body_low_m


def test_a_visible_floor_and_ceiling_are_found():
    bands = bands_after(np.linspace(-45.0, 45.0, 64), half_m=4.0)
    assert floor_m(bands) == pytest.approx(-SENSOR_M, abs=0.05)
    assert bands.ceiling == pytest.approx(CEILING_M - SENSOR_M - 0.15, abs=0.06)


@pytest.mark.parametrize('beams', [16, 64])
def test_the_lowest_part_of_walls_is_no_floor(beams):
    """Within 1.5 m of its walls a sensor of 15 degrees sees neither floor nor ceiling."""
    bands = bands_after(np.linspace(-15.0, 15.0, beams), half_m=1.5, sensor_m=0.9)
    assert floor_m(bands) == pytest.approx(-SubmapConfig().sensor_height_m)


def test_the_floor_is_remembered_where_it_is_out_of_view():
    tracker = HeightTracker(SubmapConfig())
    bands_after(np.linspace(-45.0, 45.0, 64), half_m=4.0, tracker=tracker)
    bands = bands_after(np.linspace(-5.0, 5.0, 64), half_m=2.0, tracker=tracker, scans=400)
    assert floor_m(bands) == pytest.approx(-SENSOR_M, abs=0.05)
    restored = HeightTracker.restored(SubmapConfig(), **tracker.arrays())
    assert restored.arrays()['heights_m'].tolist() == tracker.arrays()['heights_m'].tolist()
