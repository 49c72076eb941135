# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localization benchmark's suite, plans, judgement, figures and resumption."""

from collections import Counter
from dataclasses import replace
import json
from pathlib import Path

import numpy as np
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import ConfigError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import FREE
from fpnet_lab.evaluation.localization import suite as suite_module
from fpnet_lab.evaluation.localization.cases import (
    GROUPS,
    PLAIN_FAMILIES,
    Case,
    CaseKind,
    Distortion,
    make_suite,
    plain_cases,
    select,
)
from fpnet_lab.evaluation.localization.figures import figures, report
from fpnet_lab.evaluation.localization.inputs import MissingDataError, make_inputs
from fpnet_lab.evaluation.localization.plans import draw_plan
from fpnet_lab.evaluation.localization.records import (
    MethodRun,
    RunLabels,
    Truth,
    UpdateEstimate,
    belief_errors,
    score,
)
from fpnet_lab.evaluation.localization.rivals import carried
from fpnet_lab.evaluation.localization.runs import Job
from fpnet_lab.evaluation.localization.suite import run_suite
from fpnet_lab.sim.plans import generate_plan

KEYS = {
    'recall_1m_10deg', 'recall_05m_5deg', 'path_to_first_pose_m_median', 'wrong_published_runs',
    'wrong_published_poses', 'median_position_error_m', 'median_yaw_error_deg',
    'nees_mean', 'inside_95', 'open_set_false_claims', 'ece', 'tick_ms_p50', 'tick_ms_p95',
    'add_scan_ms_p50', 'rss_mb_max', 'runs',
}  # fmt: skip


def test_suite_has_the_promised_breadth():
    suite = make_suite(0)
    assert len({case.name for case in suite}) == len(suite)
    plain = [case for case in suite if case.has_mirrored_plan]
    assert len(plain) >= 40
    assert {case.building for case in plain} == set(PLAIN_FAMILIES)
    assert len({case.sensor for case in plain}) == 5
    assert {case.distortion for case in plain} == set(Distortion)
    per_group = Counter(case.group for case in plain)
    assert min(per_group.values()) >= len(plain) // len(Distortion) - 1
    assert len({(case.sensor, case.distortion) for case in plain}) == 5 * len(Distortion)
    assert sum(len(case.wrong_cases) for case in suite) >= 200
    for number, case in enumerate(plain_cases(0)):
        assert number not in case.wrong_cases
        assert len(set(case.wrong_cases)) == len(case.wrong_cases)
    others = {'wrong_building', 'mirrored_plan', 'rough'}
    assert {case.group for case in suite} | others == set(GROUPS)


def test_suite_follows_from_its_seed_and_its_head_holds_most_groups():
    assert make_suite(4) == make_suite(4)
    assert {c.seed for c in plain_cases(4)}.isdisjoint({c.seed for c in plain_cases(5)})
    suite = make_suite(0)
    groups = {case.group for case in suite}
    assert {case.group for case in suite[: len(groups)]} == groups


def test_select_takes_groups_and_refuses_unknown_ones():
    suite = make_suite(0)
    assert {case.group for case in select(suite, ['logs', 'exact'], None)} == {'logs', 'exact'}
    assert all(case.wrong_cases for case in select(suite, ['wrong_building'], 3))
    assert len(select(suite, None, 7)) == 7
    with pytest.raises(ConfigError, match='unknown group'):
        select(suite, ['mars'], None)


@pytest.mark.parametrize('distortion', list(Distortion))
def test_drawn_plans_are_inexact_as_their_group_says(distortion):
    plan = generate_plan(np.random.default_rng(8), 'double_corridor')
    drawing = draw_plan(plan, distortion, 8)
    again = draw_plan(plan, distortion, 8)
    assert np.array_equal(drawing.grid.cells, again.grid.cells)
    x, y = np.linalg.norm(drawing.A_plan_building.linear, axis=0)
    if distortion in (Distortion.EXACT, Distortion.CHANGED_WALLS):
        assert (x, y) == pytest.approx((1.0, 1.0))
    elif distortion is Distortion.UNKNOWN_SCALE:
        assert x == pytest.approx(y)
        assert 0.67 <= x <= 1.5
    elif distortion is not Distortion.SKETCH:
        largest = 0.05 if distortion is Distortion.STRETCHED_5 else 0.1
        assert 0.5 * largest <= abs(x - 1.0) <= largest
        assert (x - 1.0) * (y - 1.0) < 0.0
    # Rooms are free where the transform says that they are, whatever was changed.
    middles = np.array([room.polygon.mean(axis=0) for room in plan.rooms if room.kind == 'room'])
    rc = np.rint(drawing.grid.xy_to_rc(drawing.A_plan_building.apply(middles))).astype(int)
    assert np.mean(drawing.grid.cells[rc[:, 0], rc[:, 1]] == FREE) > 0.8


def test_cases_without_their_data_are_missing(tmp_path):
    for kind, building in ((CaseKind.LOG, 'intel'), (CaseKind.MESH, 'willowgarage')):
        with pytest.raises(MissingDataError, match='missing'):
            make_inputs(Case('x', 'logs', kind, building, 0), tmp_path)


# A straight drive of 60 m at 1 m/s, a scan each second, on a plan twice as large and turned.
STAMPS = np.arange(61, dtype=np.int64) * 1_000_000_000
TRUE = PlanarTrajectory(STAMPS, np.column_stack([np.arange(61.0), np.zeros(61)]), np.zeros(61))
T_ODOM_TRUE = SE2.from_xy_yaw(5.0, -2.0, 0.4)
ODOMETRY = TRUE.mapped(T_ODOM_TRUE)
A_PLAN_TRUE = Affine2D(2.0 * SE2.from_xy_yaw(0, 0, 1.1).linear, np.array([30.0, 7.0]))
TRUTH = Truth(TRUE, A_PLAN_TRUE, 40.0)
RIGHT_CLAIM = A_PLAN_TRUE @ T_ODOM_TRUE.inv()
LABELS = RunLabels('c', 'exact', 'bays', 'dome', 1, 'fpnet', 'c')


def off_by(metres):
    """A claim that puts the robot so many true metres ahead of its place."""
    return A_PLAN_TRUE @ SE2.from_xy_yaw(metres, 0.0, 0.0) @ T_ODOM_TRUE.inv()


def run_of(claims, stamps=(10, 30, 50), probabilities=(0.9, 0.9, 0.9)):
    stamps_ns = [s * 1_000_000_000 for s in stamps]
    beliefs = tuple(map(UpdateEstimate, stamps_ns, probabilities, claims))
    published = carried(ODOMETRY, stamps_ns, claims)
    return MethodRun(published, ODOMETRY, beliefs, np.array([5.0, 9.0]), np.array([1.0]), 100.0)


@pytest.mark.parametrize(
    ('claims', 'is_right', 'is_tight', 'wrong'),
    [
        ([RIGHT_CLAIM, off_by(0.8), off_by(9.0)], True, False, 11),
        ([off_by(4.0), off_by(0.3), off_by(0.3)], True, True, 20),
        ([RIGHT_CLAIM, None, RIGHT_CLAIM], False, False, 0),
        ([None, off_by(2.0), RIGHT_CLAIM], False, False, 0),
    ],
)
def test_runs_are_judged_after_40_m_in_true_metres(claims, is_right, is_tight, wrong):
    record = score(LABELS, run_of(claims), TRUTH)
    assert (record.is_right, record.is_tight, record.wrong_poses) == (is_right, is_tight, wrong)
    errors = belief_errors(run_of(claims), TRUTH)
    assert [error is None for error in errors] == [claim is None for claim in claims]


def test_on_another_building_every_claim_is_false():
    record = score(LABELS, run_of([None, RIGHT_CLAIM, None]), None)
    assert record.is_open_set
    assert (record.is_right, record.poses, record.wrong_poses) == (False, 20, 0)
    assert record.beliefs == ((0.9, False),)
    table = figures([record, score(LABELS, run_of([None] * 3), None)])
    assert (table['open_set_false_claims'], table['runs']) == (1, 2)
    assert table['recall_1m_10deg'] is None


def test_report_has_the_documented_keys_for_every_method_and_group():
    right = score(LABELS, run_of([RIGHT_CLAIM] * 3), TRUTH)
    wrong = score(replace(LABELS, method='rival'), run_of([off_by(5.0)] * 3), TRUTH)
    table = report([right, wrong])
    assert set(table['total']) == KEYS
    assert set(table['groups']['exact']) == KEYS
    assert set(table['families']['bays']) == set(table['sensors']['dome']) == KEYS
    rival = table['baselines']['rival']
    assert (table['total']['wrong_published_runs'], rival['total']['wrong_published_runs']) == (
        0,
        1,
    )
    assert (table['total']['recall_1m_10deg'], rival['total']['recall_1m_10deg']) == (1.0, 0.0)
    assert table['total']['tick_ms_p50'] == 7.0
    assert set(report([])['total']) == KEYS
    json.dumps(report([]), allow_nan=False)


def test_covariances_are_judged_and_rough_drawings_count_in_no_total():
    sure = replace(run_of([off_by(0.3)] * 3), covariances=np.tile(0.2**2 * np.eye(3), (51, 1, 1)))
    record = score(LABELS, sure, TRUTH)
    # 0.3 m ahead are 0.6 m of the plan, where a standard deviation is 0.2 m.
    assert record.nees_mean == pytest.approx(9.0)
    assert record.inside_95 == 0.0
    rough = replace(score(LABELS, run_of([None] * 3), TRUTH), group='rough')
    table = report([record, rough])
    assert (table['total']['runs'], table['groups']['rough']['runs']) == (1, 1)
    assert table['total']['nees_mean'] == pytest.approx(record.nees_mean, abs=1e-4)
    assert table['groups']['rough']['nees_mean'] is None


@pytest.fixture
def jobs(monkeypatch):
    """Three jobs, of which the second lacks data; a list of the cases that were really run."""
    ran = []

    def fake(job):
        if job.case.name == 'b':
            raise MissingDataError('meshes are absent')
        ran.append(job.case.name)
        labels = replace(LABELS, case=job.case.name)
        return (score(labels, run_of([RIGHT_CLAIM] * 3), TRUTH),)

    monkeypatch.setattr(suite_module, 'run_case', fake)
    cases = [Case(name, 'exact', CaseKind.GENERATED, 'bays', 0) for name in 'abc']
    return [Job(case, FpnetConfig(), 0, Path('none')) for case in cases], ran


def test_an_interrupted_suite_goes_on(tmp_path, jobs):
    todo, ran = jobs
    first, _ = run_suite(todo[:2], tmp_path)
    steps = []
    records, skipped = run_suite(todo, tmp_path, on_case=steps.append)
    assert ran == ['a', 'c']
    assert records[:1] == first
    assert [record.case for record in records] == ['a', 'c']
    assert skipped == {'b': 'meshes are absent'}
    assert len(steps) == 3


def test_kept_cases_of_another_configuration_are_run_again(tmp_path, jobs):
    todo, ran = jobs
    run_suite(todo[:1], tmp_path)
    run_suite([replace(todo[0], config=FpnetConfig(seed=3))], tmp_path)
    run_suite([replace(todo[0], with_baselines=False)], tmp_path)
    assert ran == ['a', 'a', 'a']
