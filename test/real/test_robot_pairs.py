# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The real pairs: split by building, and their truth survives cutting, turning and scaling."""

from dataclasses import replace
import json

import numpy as np
import pytest
from real_data import DATA, needs

from fpnet.cli import main
from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.types import FREE, OCCUPIED
from fpnet_lab.cli.bench_matching import matchers
from fpnet_lab.evaluation.matching_robot import bench_robot_maps, robot_cases
from fpnet_lab.evaluation.robots.robot_pairs import (
    BANDS,
    TUNE_PLANS,
    WHOLE,
    read_drawings,
    read_robot_pairs,
    varied,
)

pytestmark = [pytest.mark.real, needs('.')]


@pytest.fixture(scope='module')
def pairs():
    return read_robot_pairs(DATA, 'tune')


def free_on_free(pair):
    """Share of the robot map's free space that the truth places on free space of the plan."""
    free = pair.robot.rc_to_xy(np.argwhere(pair.robot.cells == FREE)[::7])
    rc = np.floor(pair.plan.xy_to_rc(pair.A_plan_robot.apply(free)) + 0.5).astype(int)
    inside = ((rc >= 0) & (rc < pair.plan.shape)).all(axis=1)
    return float((pair.plan.cells[tuple(rc[inside].T)] == FREE).sum() / len(free))


def test_no_building_is_in_both_halves(pairs):
    report = {pair.name for pair in read_robot_pairs(DATA, 'report')}
    assert len(pairs) == 12
    assert len(report) == 30
    assert all(pair.name.split('__')[1] in ' '.join(TUNE_PLANS) for pair in pairs)
    assert not report & {pair.name for pair in pairs}


def test_stated_scales_agree_to_two_per_cent(pairs):
    metric = [p for p in (*pairs, *read_robot_pairs(DATA, 'report')) if p.is_metric]
    assert [pair.building for pair in metric] == ['gdc1', 'gdc2', 'g4s', 'gdc4']
    for pair in metric:
        scale = pair.A_plan_robot.scale
        assert scale == pytest.approx(1.0, abs=0.02), pair.name


def test_the_distorted_drawings_are_those_of_the_notes(pairs):
    report = read_robot_pairs(DATA, 'report')
    assert not any(pair.is_distorted for pair in pairs)
    apart = {pair.name for pair in report if pair.is_distorted}
    named = {'freiburg_building79__Freiburg79_scan', 'lab_b__lab_b_scan', 'lab_e__lab_f_scan'}
    assert apart >= named
    assert all('Freiburg79' in name for name in apart - named)
    assert len(apart) == 10


def test_plans_without_a_robot_map_serve_as_foreign_ones(pairs):
    drawings = {split: read_drawings(DATA, split, read_robot_pairs(DATA, split))
                for split in ('tune', 'report')}  # fmt: skip
    names = {split: [d.building for d in each] for split, each in drawings.items()}
    assert {split: len(set(each)) for split, each in names.items()} == {'tune': 15, 'report': 13}
    assert not set(names['tune']) & set(names['report'])
    assert 'NLB' in names['tune']
    architects = {d.building: d.architect for d in drawings['tune']}
    assert architects['gdc1'] == architects['gdc2']
    assert architects['basic_filled'] == architects['office_filled'] != architects['office_a']
    assert architects['lab_a_scan'] != architects['lab_c_scan']


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


def bench(cases):
    config = FpnetConfig()
    matcher = matchers(config.matcher, ['fpnet'])
    report = bench_robot_maps(cases, matcher, config, (), lambda count: None)
    return report['methods']['fpnet']


def test_figures_are_kept_by_band_and_by_building(pairs):
    assert pairs
    cases = robot_cases(DATA, 'tune', 3, 1)
    said = bench(cases)
    buildings = said['buildings']
    assert set(buildings) == {case.pair.building for case in cases}
    for band, figures in said['bands'].items():
        of_band = [case for case in cases if case.band == band]
        assert figures['pairs'] == figures['foreign_pairs'] == len(of_band)
        each = [bands[band] for bands in buildings.values() if bands[band]['pairs']]
        assert sum(found['pairs'] for found in each) == len(of_band)
        right = sum(found['right'] * found['pairs'] for found in each)
        assert right == pytest.approx((figures['right'] or 0.0) * len(of_band))


def test_metric_maps_are_claimed_on_their_own_storey_and_not_on_another(pairs):
    assert pairs
    cases = [
        case
        for case in robot_cases(DATA, 'tune', None, 2)
        if case.band == WHOLE and case.pair.is_metric
    ]
    assert sorted(case.pair.building for case in cases) == ['g4s', 'gdc1', 'gdc2']
    whole = bench(cases)['bands'][WHOLE]
    assert whole['claimed_right'] == 1.0
    assert (whole['foreign_pairs'], whole['foreign_same_architect_pairs']) == (6, 2)
    assert whole['foreign_claimed'] == 0.0


def test_the_command_matches_two_maps_of_stated_scale(pairs, tmp_path):
    """The scale that comes out is that of the fitted truth, though both files state one."""
    assert pairs
    truth = next(pair for pair in pairs if pair.building == 'gdc1')
    out = tmp_path / 'match.json'
    plan, robot = (DATA / 'gdc' / kind / 'gdc1.yaml' for kind in ('floorplan', 'robot_maps'))
    with pytest.raises(SystemExit) as ended:
        main(['match', '--floorplan', str(plan), '--submap', str(robot), '--json', str(out)])
    assert ended.value.code in (0, None)
    said = json.loads(out.read_text())
    assert said['status'] == 'matched'
    assert said['plan_scale_stated']
    assert said['submap_scale_stated']
    scale = truth.A_plan_robot.scale
    assert said['scale'] == pytest.approx(scale, rel=0.01)
    in_pixels = Affine2D.from_matrix(said['affine_plan_from_submap_px'])
    placed = pixel_to_xy(truth.plan) @ in_pixels @ pixel_to_xy(truth.robot).inv()
    free = truth.robot.rc_to_xy(np.argwhere(truth.robot.cells == FREE)[::97])
    off = np.linalg.norm(placed.apply(free) - truth.A_plan_robot.apply(free), axis=1)
    assert np.median(off) < 0.5


def shift(metres):
    return SE2.from_xy_yaw(metres, metres, 0.0)


def test_an_unknown_half_is_refused():
    with pytest.raises(FpnetError, match='tune or report'):
        read_robot_pairs(DATA, 'all')
