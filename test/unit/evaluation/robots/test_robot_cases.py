# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cases, outcomes and figures of ``bench matching --set robot`` on one drawn house."""

from collections import Counter
from dataclasses import replace
import json
from types import SimpleNamespace

import numpy as np
from planted import draw_building
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.localizer.maps import MapMatchStatus
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_lab.evaluation import matching_robot, raster_methods
from fpnet_lab.evaluation.matching_robot import bench_robot_maps, robot_cases
from fpnet_lab.evaluation.robots.robot_figures import Foreign, Outcome, robot_figures
from fpnet_lab.evaluation.robots.robot_pairs import (
    BANDS,
    SOURCES,
    read_drawings,
    read_robot_pairs,
    varied,
)

TUNE = {'bormann': ['lab_a_scan'], 'priormaps': ['basic_filled'], 'gdc': ['gdc1', 'gdc2']}
REPORT = {'bormann': ['Freiburg79_scan'], 'radish': ['Freiburg79_scan'], 'gdc': ['gdc4']}
STATED = ('gdc', 'g4s')
ORIGIN = SE2.from_xy_yaw(-1.0, -1.0, 0.0)


@pytest.fixture(scope='module')
def data(tmp_path_factory):
    """Each pair is the same house twice, so that the identity is the truth of all of them."""
    root = tmp_path_factory.mktemp('data')
    house = draw_building(Affine2D.identity(), 0.05, 'plan', ORIGIN, (300, 440))
    for source in SOURCES:
        names = [*TUNE.get(source, []), *REPORT.get(source, [])]
        for name in names:
            for kind in ('floorplan', 'robot_maps'):
                write_map(house, root / source / kind / f'{name}.yaml')
                if source not in STATED:
                    (root / source / kind / f'{name}.yaml').unlink()
        entries = [
            {
                'id': f'{source}__{name}',
                'floorplan': f'floorplan/{name}.png',
                'robot_map': f'robot_maps/{name}.png',
                'affine_2x3': [[1, 0, 0], [0, 1, 0]],
            }
            for name in names
        ]
        (root / source).mkdir(exist_ok=True)
        (root / source / 'pairs.json').write_text(json.dumps({'pairs': entries}))
    for name in ('NLB', 'office_b', 'office_i'):  # nobody drove there
        write_map(house, root / 'bormann' / 'floorplan' / f'{name}.yaml')
    return root


def test_a_half_has_its_pairs_and_each_drawing_once(data):
    pairs = read_robot_pairs(data, 'report')
    assert sorted(pair.building for pair in pairs) == [
        'Freiburg79_scan',
        'Freiburg79_scan',
        'gdc4',
    ]
    drawings = read_drawings(data, 'report', pairs)
    assert sorted(d.building for d in drawings) == ['Freiburg79_scan', 'gdc4', 'office_i']
    tune = read_drawings(data, 'tune', read_robot_pairs(data, 'tune'))
    assert {d.building for d in tune} == {
        'lab_a_scan', 'basic_filled', 'gdc1', 'gdc2', 'NLB', 'office_b'
    }  # fmt: skip
    assert {d.building for d in tune if d.is_metric} == {'gdc1', 'gdc2'}
    with pytest.raises(FpnetError, match='tune or report'):
        read_drawings(data, 'all', pairs)


def test_a_stated_scale_is_not_varied(data):
    for pair in read_robot_pairs(data, 'tune'):
        changed = varied(pair, np.random.default_rng(5), BANDS['20-35'])
        assert pair.is_metric == pair.name.startswith('gdc')
        assert (changed.robot.resolution == pair.robot.resolution) == pair.is_metric
        scale = changed.A_plan_robot.scale
        assert (scale == pytest.approx(1.0)) == pair.is_metric
        assert changed.kept < 0.36
        assert not np.allclose(changed.A_plan_robot.linear / scale, np.eye(2), atol=0.01)


def test_few_cases_are_spread_over_the_bands_and_equal_each_time(data):
    cases = robot_cases(data, 'tune', 12)
    assert Counter(case.band for case in cases) == dict.fromkeys(('whole', *BANDS), 3)
    assert all(len(case.foreign) == 3 for case in cases)
    again = robot_cases(data, 'tune', 12)
    for first, second in zip(cases, again, strict=True):
        assert (first.pair.name, first.band) == (second.pair.name, second.band)
        assert np.array_equal(first.pair.robot.cells, second.pair.robot.cells)
        assert [d.building for d in first.foreign] == [d.building for d in second.foreign]
    assert len(robot_cases(data, 'tune', None, 0)) == 4 * 31


@pytest.fixture
def planted(data, monkeypatch):
    """Cases whose claims are planted: on their own plan, and on that of gdc2; counts the cuts."""
    cut, count = Counter(), matching_robot.segment_plan
    place, claims = matching_robot.match_segmented, iter(())

    def counted(grid, config, is_metric=False):
        cut[id(grid)] += 1
        return count(grid, config, is_metric)

    def claimed(plan, sub, global_localizer, timer):
        status = MapMatchStatus.MATCHED if next(claims) else MapMatchStatus.AMBIGUOUS
        return replace(place(plan, sub, global_localizer, timer), status=status)

    cases = [case for case in robot_cases(data, 'tune', None, 3) if case.band == 'whole']
    order = [[d.building == 'gdc2' for d in case.foreign] + [True] for case in cases]
    # The warm-up is the first case on its own plan.
    claims = iter([True, *(said for case in order for said in case)])
    monkeypatch.setattr(matching_robot, 'segment_plan', counted)
    monkeypatch.setattr(matching_robot, 'match_segmented', claimed)
    nowhere = SimpleNamespace(A_plan_submap=SE2.from_xy_yaw(50.0, 0.0, 0.0), score=0.5)
    monkeypatch.setattr(raster_methods, 'search_placement', lambda plan, sub: nowhere)
    return cases, cut


def test_claims_are_counted_on_the_own_plan_and_on_others(planted):
    cases, cut = planted
    config, done = FpnetConfig(), []
    matcher = {'fpnet': LearnedMatcher(config.matcher)}
    report = bench_robot_maps(cases, matcher, config, ['correlative'], done.append)
    bands = {name: figures['bands']['whole'] for name, figures in report['methods'].items()}
    met = [(case.pair.building, d.building) for case in cases for d in case.foreign]
    others = [own for own, other in met if other == 'gdc2' and own != 'gdc1']
    assert sum(done) == len(cases) == bands['fpnet']['pairs'] == 4
    assert bands['fpnet']['right'] == bands['fpnet']['claimed_right'] == 1.0
    assert bands['fpnet']['wrong_and_claimed'] == 0.0
    assert bands['fpnet']['foreign_pairs'] == 12
    assert bands['fpnet']['foreign_same_architect_pairs'] == 2
    assert (
        bands['fpnet']['foreign_same_architect_claimed'] == 0.5
    )  # gdc1 on gdc2, not gdc2 on gdc1
    assert bands['fpnet']['foreign_random_claimed'] == len(others) / 10
    assert bands['correlative']['right'] == bands['correlative']['claimed_right'] == 0.0
    assert bands['correlative']['wrong_and_claimed'] == 1.0
    assert bands['correlative']['foreign_claimed'] is None
    assert bands['correlative']['foreign_pairs'] == 0
    # Once each, and once more for the warm-up.
    assert sorted(cut.values())[:-1] == [1] * (len(cut) - 1)
    assert max(cut.values()) == 2


SAME_CLAIMED, SAME_NOT = Foreign(True, True), Foreign(True, False)
OTHER_CLAIMED, OTHER_NOT = Foreign(False, True), Foreign(False, False)


def outcome(right, claimed, *foreign, band='20-35', building='a', distorted=False):
    return Outcome(band, building, distorted, right, claimed, foreign)


@pytest.fixture
def outcomes():
    return [
        outcome(True, True, OTHER_NOT, OTHER_NOT, SAME_CLAIMED),
        outcome(True, False, OTHER_CLAIMED, OTHER_NOT, SAME_NOT),
        outcome(False, True, OTHER_NOT, OTHER_NOT),
        outcome(False, False, building='b', distorted=True),
        outcome(False, True, OTHER_CLAIMED, building='b', distorted=True),
        outcome(True, True, band='whole', building='b', distorted=True),
    ]


def test_shares_are_of_all_pairs_and_of_all_foreign_pairs(outcomes):
    assert robot_figures(outcomes)['bands']['20-35'] == {
        'right': 2 / 5, 'claimed_right': 1 / 5, 'wrong_and_claimed': 2 / 5,
        'foreign_claimed': 3 / 9, 'foreign_random_claimed': 2 / 7,
        'foreign_same_architect_claimed': 1 / 2, 'pairs': 5, 'foreign_pairs': 9,
        'foreign_same_architect_pairs': 2,
    }  # fmt: skip


def test_distorted_drawings_are_left_out_of_one_summary_only(outcomes):
    figures = robot_figures(outcomes)
    left = figures['bands_undistorted']
    assert (left['20-35']['pairs'], left['20-35']['foreign_pairs']) == (3, 8)
    assert left['20-35']['right'] == 2 / 3
    assert left['20-35']['wrong_and_claimed'] == 1 / 3
    assert left['20-35']['foreign_random_claimed'] == 1 / 6
    assert (figures['bands']['whole']['pairs'], left['whole']['pairs']) == (1, 0)
