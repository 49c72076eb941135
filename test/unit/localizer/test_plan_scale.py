# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is searched for the scale of a drawing, and when it is settled."""

import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import drive, recorded
import pytest

from fpnet_core.config import PoseConfig, load_config
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.localizer import Localizer
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.scale import ScaleHistory, estimated_search
from fpnet_core.matches import MatchResult
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.segmentation.moved import rescaled
from fpnet_core.types import Status

CONFIG = PoseConfig()
WIDE = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 15.0], [0.0, 15.0]])
SLIVER = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 2.0], [0.0, 2.0]])
STRETCH = np.array([[1.05, 0.01], [0.01, 0.97]])


def placement(stretch, yaw=0.7):
    return Affine2D(stretch @ SE2.from_xy_yaw(0.0, 0.0, yaw).linear, np.array([3.0, 4.0]))


@pytest.mark.parametrize(('low', 'high'), [(0.9, 1.1), (0.95, 1.3), (0.5, 1.05)])
def test_an_unknown_scale_is_searched_as_far_as_its_interval_and_somewhat_further(low, high):
    """Plan metres per true metre: the inverse of true metres per nominal metre."""
    factors = ScaleHistory.begun(
        'unknown', CONFIG, ScaleEstimate(2.0, 2.0 * low, 2.0 * high)
    ).search
    refined = np.exp(0.03)
    assert 1 / (1.2 * high**1.4) < factors.factors.min() < refined / high
    assert 1.2 / low**1.4 > factors.factors.max() > 1 / low / refined
    assert np.isclose(factors.factors, 1.0).any()


def test_a_trusted_scale_is_never_asked_for():
    history = ScaleHistory.begun('trusted', CONFIG)
    for _ in range(10):
        history = history.followed(placement(STRETCH), WIDE)
    assert history.estimate is None
    np.testing.assert_array_equal(history.search.stretches, np.eye(2)[None])


def test_claims_that_agree_lock_the_stretch_whatever_the_heading():
    history = ScaleHistory.begun('approximate', CONFIG)
    wide = history.search.anisotropy_sigma
    for update in range(5):
        assert history.estimate is None or not history.estimate.is_locked
        history = history.followed(placement(STRETCH, yaw=update), WIDE)
    assert history.estimate.is_locked
    np.testing.assert_allclose(history.search.stretches, STRETCH[None], atol=1e-9)
    assert history.search.anisotropy_sigma < wide


@pytest.mark.parametrize(
    ('stretches', 'walls'),
    [([(1.0 + 0.04 * (k % 2)) * np.eye(2) for k in range(9)], WIDE), ([STRETCH] * 9, SLIVER)],
)
def test_claims_that_differ_or_see_little_lock_nothing(stretches, walls):
    history = ScaleHistory.begun('approximate', CONFIG)
    for stretch in stretches:
        history = history.followed(placement(stretch, yaw=0.0), walls)
    assert history.estimate.sigma > 0.01
    assert not history.estimate.is_locked


def test_a_claim_beyond_what_was_stated_goes_on_there_until_it_is_lost():
    history = ScaleHistory.begun('approximate', CONFIG)
    history = history.followed(placement(1.22 * np.eye(2)), SLIVER)
    assert history.search.bounds[1] > 1.25
    assert history.search.wide_scales is None
    history = history.forgotten()
    assert history.search.bounds[1] < 1.2


class IndifferentMatcher:
    def match(self, plan, sub, explored_area_m2):
        even = np.full((len(plan), len(sub)), 0.01)
        return MatchResult(np.zeros((0, 2)), np.zeros(0), even)


@pytest.mark.parametrize('factor', [0.8, 1.22])
def test_a_misstated_scale_is_found_out(factor):
    localizer = Localizer(load_config(), IndifferentMatcher())
    localizer.set_plan(rescaled(plan_grid(), factor))
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % 5 == 4:
            output = localizer.update(stamp_ns)
    assert output.status is Status.LOCALIZED
    assert f'{output.estimates.scale[0]:.2f} times the stated scale' in output.reason
    assert output.estimates.scale[0] == pytest.approx(factor, rel=0.02)
    in_building = A_BUILDING_PLAN.apply(
        localizer.output.pose(recorded()[-1][1]).translation / factor
    )
    assert np.linalg.norm(in_building - drive()[-1][:2]) < 0.3


def test_a_drawing_of_unknown_scale_is_placed_in_its_own_units():
    factor = 2.5  # nominal metres per true metre
    enlarged = rescaled(plan_grid(), factor)
    config = load_config(None, {'localizer.scale_policy': 'unknown'})
    localizer = Localizer(config, IndifferentMatcher())
    localizer.set_plan(enlarged)
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % 5 == 4:
            output = localizer.update(stamp_ns)
    assert output.status is Status.LOCALIZED
    assert output.scale.factor == pytest.approx(factor, rel=0.03)
    x, y, _ = drive()[-1]
    pose = localizer.output.pose(recorded()[-1][1])
    in_building = A_BUILDING_PLAN.apply(pose.translation / factor)
    assert np.linalg.norm(in_building - (x, y)) < 0.3


def test_drawn_and_working_plan_have_the_same_rooms_and_doors():
    grid = rescaled(plan_grid(), 2.5)
    plan = Floorplan.prepared(grid, load_config(None, {'localizer.scale_policy': 'unknown'}))
    drawn, working = plan.nominal.segmentation, plan.working.segmentation
    assert drawn.grid.resolution == grid.resolution
    assert drawn.grid.T_frame_grid is grid.T_frame_grid
    assert plan.given is grid
    assert len(drawn.regions) == len(working.regions) > 3
    factor = working.grid.resolution / grid.resolution
    assert factor == pytest.approx(1 / 2.5, rel=0.2)
    for region, same in zip(drawn.regions, working.regions, strict=True):
        assert region.label is same.label
        assert region.centroid * factor == pytest.approx(same.centroid)


def test_a_lost_claim_takes_the_lock_with_it():
    history = ScaleHistory.begun('approximate', CONFIG)
    for _ in range(5):
        history = history.followed(placement(STRETCH), WIDE)
    history = history.forgotten()
    assert history.estimate is None
    assert len(history.search) > 1


def test_a_stated_scale_is_doubted_at_the_odds_of_its_being_so_wrong():
    search = ScaleHistory.begun('approximate', CONFIG).search
    farther = ScaleHistory.begun(
        'approximate', CONFIG.model_copy(update={'scale_tolerance': 0.2})
    ).search
    assert search.bounds[1] < search.wide_scales.bounds[1] < 1.4
    assert -6.0 < farther.log_odds < search.log_odds < -2.0
    assert search.as_stated.wide_scales is None
    for settings in ('trusted', CONFIG), ('unknown', CONFIG):
        assert ScaleHistory.begun(*settings).search.wide_scales is None
    told = CONFIG.model_copy(update={'scale_tolerance': 0.4})
    assert ScaleHistory.begun('approximate', told).search.wide_scales is None


def test_intervals_of_two_maps_add_like_independent_errors():
    known, plan, sub = ScaleEstimate(1, 1, 1), ScaleEstimate(3, 2.7, 3.3), ScaleEstimate(7, 6, 8)
    both = estimated_search(plan, sub, CONFIG).log_range
    one, other = (
        estimated_search(*pair, CONFIG).log_range for pair in ((plan, known), (known, sub))
    )
    assert both == pytest.approx(np.hypot(one, other), abs=0.12)
    assert max(one, other) < both < one + other


def test_nothing_known_of_a_scale_does_not_search_forever():
    wide = estimated_search(ScaleEstimate(1, 0.1, 10), ScaleEstimate(1, 0.1, 10), CONFIG)
    assert 2.0 < wide.factors.max() < 2.5
    assert len(wide) < 32
