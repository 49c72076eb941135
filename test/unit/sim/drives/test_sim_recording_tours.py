# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tours: through doors, clear of walls, within what a robot can do."""

import numpy as np
import pytest
import shapely

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.buildings.openings import walkable_area
from fpnet_lab.sim.drives.driving import MOTION
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.plans import generate_plan

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
