# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What was seen last contradicts a claim, or lets it stand."""

from functools import cache

import numpy as np
from planted import A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2, Placement
from fpnet_core.localizer.kidnap import KidnapDetector, KidnapState
from fpnet_core.localizer.tracking import LocalizationState
from fpnet_core.pose import map_evidence
from fpnet_core.types import FREE, Status, Submap

ROBOT = np.zeros(2)


class Following:
    """Goes on from where each look has led."""

    def __init__(self, **settings):
        self._surroundings = KidnapDetector(LocalizerConfig(**settings))
        self._kidnap_state = KidnapState()

    @property
    def is_elsewhere(self):
        return self._surroundings.is_elsewhere(self._kidnap_state)

    def update(self, submap, estimate):
        self._kidnap_state, *found = self._surroundings.update(
            self._kidnap_state, plan(), submap, estimate, ROBOT
        )
        return found


@cache
def plan():
    return map_evidence(plan_grid())


@cache
def walls():
    return map_evidence(submap_grid()).walls


def claim(score=0.9):
    return LocalizationState(
        Status.LOCALIZED, Placement(A_PLAN_SUBMAP, score, np.eye(3)), 1.0, 'fits'
    )


def submap(newest, newest_walls=None):
    grid = submap_grid()
    nothing = np.zeros(grid.shape, dtype=bool)
    return Submap(
        grid,
        nothing,
        np.zeros((1, 2)),
        recent_xy=walls(),
        newest_xy=newest,
        newest_walls_xy=newest if newest_walls is None else newest_walls,
    )


def elsewhere():
    """Return the walls as a robot would report them that was turned without knowing it."""
    middle = walls().mean(axis=0)
    return SE2.from_xy_yaw(1.0, 0.7, 0.6).apply(walls() - middle) + middle


def test_walls_where_they_should_be_let_a_claim_stand():
    estimate, A = Following().update(submap(walls()), claim())
    assert (estimate.status, estimate.reason) == (Status.LOCALIZED, 'fits')
    assert np.linalg.norm(A.apply(ROBOT) - A_PLAN_SUBMAP.apply(ROBOT)) < 0.2


def test_a_contradicted_claim_is_withheld_with_its_reason():
    following = Following()
    estimate, A = following.update(submap(elsewhere()), claim())
    assert (estimate.status, estimate.probability, A) == (Status.LOST, 0.0, None)
    assert 'kidnapped' in estimate.reason
    assert not following.is_elsewhere


def test_a_contradiction_that_lasts_means_elsewhere():
    following = Following(doubt_updates=2)
    for _ in range(2):
        assert not following.is_elsewhere
        following.update(submap(elsewhere()), claim())
    assert following.is_elsewhere


def test_a_moment_of_doubt_passes():
    following = Following()
    for newest in (elsewhere(), walls()) * 4:
        estimate, _ = following.update(submap(newest), claim())
    assert estimate.status is Status.LOCALIZED
    assert not following.is_elsewhere


def test_a_cabinet_before_the_robot_is_not_another_place():
    """Half of the returns lie where the submap is free, as it is over furniture."""
    rng = np.random.default_rng(0)
    free = np.argwhere(submap_grid().cells == FREE)
    cabinet = submap_grid().rc_to_xy(free[rng.integers(0, len(free), len(walls()) // 2)])
    newest = np.concatenate([walls()[::2], cabinet])
    for is_furniture in (True, False):
        following = Following()
        following.update(submap(walls()), claim())
        seen_as_walls = walls()[::2] if is_furniture else newest
        estimate, _ = following.update(submap(newest, seen_as_walls), claim())
        assert estimate.status is (Status.LOCALIZED if is_furniture else Status.LOST)


def test_a_covered_lidar_contradicts_nothing():
    estimate, _ = Following().update(submap(walls()[:10]), claim())
    assert estimate.status is Status.LOCALIZED


def partly(share):
    """Return the newest walls, of which a share is where it should be."""
    rng = np.random.default_rng(0)
    return np.where(rng.random(len(walls()))[:, None] < share, walls(), elsewhere() + 60.0)


def in_free_space():
    """Return returns in the middle of what the submap has seen as free."""
    grid = submap_grid()
    free = grid.rc_to_xy(np.argwhere(grid.cells == FREE))
    away = np.linalg.norm(free[:, None] - walls()[None, ::5], axis=2).min(axis=1) > 0.5
    return free[away][:: max(1, away.sum() // 400)]


def test_walls_where_nothing_stood_speak_for_another_place():
    """What the drawing leaves open is decided by what the robot itself has seen before."""
    some = partly(0.68)
    for newest, expected in (
        (some, Status.LOCALIZED),
        (np.concatenate([some, np.tile(in_free_space(), (2, 1))]), Status.LOST),
    ):
        following = Following()
        following.update(submap(walls()), claim())
        estimate, _ = following.update(submap(newest), claim())
        assert estimate.status is expected


def test_a_doubt_is_given_up_only_for_a_good_reason():
    """What does not suffice for a doubt does not end one either."""
    unsure = np.concatenate([partly(0.55), in_free_space()[::4]])
    for first, expected in ((walls(), Status.LOCALIZED), (partly(0.2), Status.LOST)):
        following = Following()
        following.update(submap(walls()), claim())
        following.update(submap(first), claim())
        estimate, _ = following.update(submap(unsure), claim())
        assert estimate.status is expected
    estimate, _ = following.update(submap(walls()), claim())
    assert estimate.status is Status.LOCALIZED


@pytest.mark.parametrize('score', [0.9, 0.3])
def test_what_a_rough_drawing_explains_is_the_measure(score):
    """A third of the walls on drawn ones is little for a good drawing, enough for a poor one."""
    rng = np.random.default_rng(0)
    fits = rng.random(len(walls())) < 0.33
    newest = np.where(fits[:, None], walls(), elsewhere() + 60.0)
    estimate, _ = Following().update(submap(newest), claim(score))
    assert (estimate.status is Status.LOCALIZED) == (score < 0.5)


def test_what_was_usual_is_the_measure_not_a_claim_that_has_sunk():
    """Walls of another place lower the claim's own score before anybody asks them."""
    following = Following()
    for _ in range(5):
        following.update(submap(walls()), claim())
    estimate, _ = following.update(submap(partly(0.33)), claim(score=0.5))
    assert estimate.status is Status.LOST
    estimate, _ = Following().update(submap(partly(0.33)), claim(score=0.5))
    assert estimate.status is Status.LOCALIZED
