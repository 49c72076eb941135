# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The real pairs: split by building, and their truth survives cutting, turning and scaling."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fpnet_core.cli.bench_matching import matchers
from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError
from fpnet_core.evaluation.matching_robot import bench_robot_maps, robot_cases
from fpnet_core.evaluation.robot_pairs import BANDS, TUNE_PLANS, read_robot_pairs, varied
from fpnet_core.geometry import SE2
from fpnet_core.types import FREE, OCCUPIED

pytestmark = pytest.mark.real
DATA = Path(__file__).parents[3] / 'shared' / 'data'


@pytest.fixture(scope='module')
def pairs():
    if not DATA.is_dir():
        pytest.skip(f'no shared data at {DATA}')
    return read_robot_pairs(DATA, 'tune')


def free_on_free(pair):
    """Share of the robot map's free space that the truth places on free space of the plan."""
    free = pair.robot.rc_to_xy(np.argwhere(pair.robot.cells == FREE)[::7])
    rc = np.floor(pair.plan.xy_to_rc(pair.A_plan_robot.apply(free)) + 0.5).astype(int)
    inside = ((rc >= 0) & (rc < pair.plan.shape)).all(axis=1)
    return float((pair.plan.cells[tuple(rc[inside].T)] == FREE).sum() / len(free))


def test_no_building_is_in_both_halves(pairs):
    report = {pair.name for pair in read_robot_pairs(DATA, 'report')}
    assert len(pairs) == 9
    assert len(report) == 29
    assert all(pair.name.split('__')[1] in ' '.join(TUNE_PLANS) for pair in pairs)
    assert not report & {pair.name for pair in pairs}


@pytest.mark.parametrize('band', BANDS)
def test_the_truth_follows_the_variation(pairs, band):
    for index, pair in enumerate(pairs[:5]):
        changed = varied(pair, np.random.default_rng([index, 3]), BANDS[band])
        whole = int((pair.robot.cells == FREE).sum())
        left = int((changed.robot.cells == FREE).sum())
        assert BANDS[band][0] * 0.85 < left / whole < BANDS[band][1] * 1.05
        assert free_on_free(changed) > free_on_free(pair) - 0.12
        assert changed.A_plan_robot.is_mirrored == pair.A_plan_robot.is_mirrored
        shifted = replace(changed, A_plan_robot=changed.A_plan_robot @ shift(3.0))
        assert free_on_free(shifted) < free_on_free(changed)


@pytest.mark.parametrize('split', ['tune', 'report'])
def test_every_robot_map_has_walls(pairs, split):
    """One of the published maps has two tones only, free space and the rest."""
    assert pairs
    for pair in read_robot_pairs(DATA, split):
        assert (pair.robot.cells == OCCUPIED).mean() > 0.005, pair.name


def test_figures_are_kept_by_band_and_by_building(pairs):
    assert pairs
    cases, config = robot_cases(DATA, 'tune', 3), FpnetConfig()
    matcher = matchers(config.matcher, ['fpnet'])
    said = bench_robot_maps(cases, matcher, config, False, lambda count: None)['methods']['fpnet']
    buildings = said['buildings']
    assert set(buildings) == {case.pair.building for case in cases}
    for band, figures in said['bands'].items():
        of_band = [case for case in cases if case.band == band]
        assert figures['pairs'] == len(of_band)
        assert sum(each[band]['pairs'] for each in buildings.values()) == len(of_band)
        right = sum(each[band]['right'] * each[band]['pairs'] for each in buildings.values())
        assert right == pytest.approx(figures['right'] * len(of_band))


def shift(metres):
    return SE2.from_xy_yaw(metres, metres, 0.0)


def test_an_unknown_half_is_refused():
    with pytest.raises(FpnetError, match='tune or report'):
        read_robot_pairs(DATA, 'all')
