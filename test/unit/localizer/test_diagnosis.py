# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs that fail for a known cause, and what they say of it."""

from dataclasses import replace
from itertools import pairwise
import re

import numpy as np
from planted import plan_grid
from planted_drive import recorded, standing
import pytest

from fpnet_core.config import load_config
from fpnet_core.doctor import sensor
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.geometry import SE2
from fpnet_core.io.scans import Scan
from fpnet_core.localizer import Localizer, match_maps, replay
from fpnet_core.localizer.diagnosis import explain_match, explain_run
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.scoring.reasons import MIRRORED, UPSIDE_DOWN
from fpnet_core.segmentation.moved import rescaled
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import OCCUPIED, CauseKind, Status
from fpnet_lab.evaluation.localization.cases import plain_cases
from fpnet_lab.evaluation.localization.inputs import make_plan

CONFIG = load_config()
ASKED = Invocation(('fpnet', 'localize', 'drive', '--floorplan'), 'plan.png')
TICK_S = 3.0


@pytest.fixture(scope='module')
def matcher():
    return LearnedMatcher(CONFIG.matcher)


@pytest.fixture(scope='module')
def other_plan():
    return make_plan(plain_cases(0)[3])


def drive_on(plan, matcher, scans=None):
    localizer = Localizer(CONFIG, matcher)
    localizer.set_plan(plan)
    given = recorded() if scans is None else scans
    source = [Scan(stamp, points, T_odom_sensor=pose) for points, pose, stamp in given]
    return replay(source, localizer, TICK_S, None)


def explained(run, plan, matcher, reading=None, invocation=ASKED):
    assert run.outputs[-1].status is not Status.LOCALIZED
    return explain_run(run.outputs, plan, matcher, CONFIG, reading, invocation)


def turning(degrees_per_m):
    """Scans with odometry that turns more than the robot does."""
    poses, given = [np.eye(4)], recorded()
    for (_, before, _), (_, after, _) in pairwise(given):
        step = np.linalg.inv(before) @ after
        turn_rad = np.deg2rad(degrees_per_m) * np.linalg.norm(step[:2, 3])
        poses.append(poses[-1] @ step @ SE2.from_xy_yaw(0.0, 0.0, turn_rad).as_matrix4())
    return [(points, pose, stamp) for pose, (points, _, stamp) in zip(poses, given, strict=True)]


def test_a_plan_of_another_building(matcher, other_plan):
    causes = explained(drive_on(other_plan, matcher), other_plan, matcher)
    assert causes[0].kind is CauseKind.OTHER_PLAN
    assert 'it does not fit at other scales or mirrored' in causes[0].evidence
    assert causes[0].next == 'fpnet localize drive --floorplan OTHER_PLAN'


@pytest.mark.parametrize('factor', [1.5, 0.6])  # nearer ones are found all the same
def test_a_plan_at_another_scale(matcher, factor):
    plan = rescaled(plan_grid(), factor)
    causes = explained(drive_on(plan, matcher), plan, matcher)
    assert causes[0].kind is CauseKind.SCALE
    *_, metres = causes[0].next.split()
    assert float(metres) == pytest.approx(plan_grid().resolution, rel=0.03)
    assert causes[0].next == f'fpnet localize drive --floorplan plan.png --resolution {metres}'


def test_a_plan_whose_rooms_deny_its_scale(matcher, caplog):
    plan = rescaled(plan_grid(), 10.0)  # a slip of the pen: beyond all that is searched
    run = drive_on(plan, matcher)
    told = [record.message for record in caplog.records if 'is stated' in record.message]
    assert len(told) == 1
    causes = explained(run, plan, matcher)
    live = run.outputs[-1].causes
    assert [cause.kind for cause in live] == [CauseKind.SCALE]
    assert live[0].evidence.endswith(f'; {plan.resolution:.3g} was used')
    low, high = re.search(r'\((\S+) to (\S+)\)', live[0].evidence).groups()
    assert float(low) < plan_grid().resolution < float(high)
    assert live[0].next.endswith('--set localizer.scale_policy=unknown')
    # Looked at once more, the walls themselves tell which scale it is.
    assert [cause.kind for cause in causes] == [CauseKind.SCALE]
    *_, metres = causes[0].next.split()
    assert float(metres) == pytest.approx(plan_grid().resolution, rel=0.03)


def test_a_plan_at_its_scale_is_not_denied(matcher, caplog):
    drive_on(plan_grid(), matcher, recorded()[:2])
    assert not [record for record in caplog.records if 'is stated' in record.message]


def test_a_drawing_with_doubts(matcher):
    """Walls that were taken for paper; the reading says so, and the run finds nothing."""
    grid = plan_grid()
    kept = np.random.default_rng(0).random(grid.shape) < 0.9
    kept &= ~np.roll(grid.cells == OCCUPIED, 40, axis=0)
    plan = replace(grid, cells=np.where(kept & (grid.cells == OCCUPIED), 0, grid.cells))
    plan = replace(plan, cells=np.roll(plan.cells, 25, axis=1) | plan.cells)
    reading = Reading(
        plan,
        DrawingScale(0.05, 0.04, 0.06, ScaleSource.ESTIMATED),
        np.eye(3),
        'dark walls on light paper',
        Drawing(np.full((2, 2, 3), 255, np.uint8), 'plan.png', 'png'),
        doubts=('one room holds 95 % of the floor',),
    )
    causes = explained(drive_on(plan, matcher), plan, matcher, reading)
    assert causes[0].kind is CauseKind.DRAWING
    assert causes[0].evidence == 'one room holds 95 % of the floor'
    assert causes[0].next.startswith('fpnet plan plan.png --out out/plan.yaml')


def test_a_stump_of_a_drive(matcher):
    run = drive_on(plan_grid(), matcher, recorded()[:2])
    causes = explained(run, plan_grid(), matcher)
    assert causes[0].kind is CauseKind.TOO_LITTLE
    assert causes[0].next.endswith('fpnet localize drive --floorplan plan.png')


def test_a_drive_that_has_hardly_begun(matcher):
    """The lidar sees half a room, which is less than a first look takes."""
    nearby = [(points[np.hypot(*points[:, :2].T) < 2.0], *rest) for points, *rest in recorded()]
    run = drive_on(plan_grid(), matcher, nearby[:2])
    assert run.outputs[-1].status is Status.WAITING
    assert [cause.kind for cause in run.outputs[-1].causes] == [CauseKind.TOO_LITTLE]
    assert 'the first update needs 12 m²' in run.outputs[-1].causes[0].evidence
    causes = explained(run, plan_grid(), matcher)
    assert [cause.kind for cause in causes] == [CauseKind.TOO_LITTLE]


def test_a_run_that_stands_still_says_so(matcher):
    run = drive_on(plan_grid(), matcher, standing())
    causes = explained(run, plan_grid(), matcher)
    for cause in (causes[0], run.outputs[-1].causes[0]):
        assert cause.kind is CauseKind.TOO_LITTLE
        assert cause.evidence.startswith('the robot stood still (0.0 m driven): ')
    assert causes[0].next.startswith('drive through at least two rooms and a corridor, then: ')
    for found in (causes, run.outputs[-1].causes):
        assert CauseKind.OTHER_PLAN not in [cause.kind for cause in found]


def test_a_run_without_a_scan(matcher):
    assert explain_run((), plan_grid(), matcher, CONFIG)[0].kind is CauseKind.TOO_LITTLE


@pytest.mark.parametrize('is_heard', [False, True])  # a covered lidar, a driver in millimetres
def test_scans_without_a_wall_are_the_inputs_fault(matcher, is_heard):
    """However far such a robot drives on, it will see no more."""
    scans = [(points[:0] if not is_heard else points * 1e3, *rest) for points, *rest in recorded()]
    run = drive_on(plan_grid(), matcher, scans)
    (cause,) = explained(run, plan_grid(), matcher)
    assert cause.kind is CauseKind.INPUT
    assert cause.next == 'fpnet doctor drive'
    if not is_heard:
        assert [cause.kind for cause in run.outputs[0].causes] == [CauseKind.INPUT]


def test_odometry_that_turns(matcher):
    run = drive_on(plan_grid(), matcher, turning(2.5))
    causes = explained(run, plan_grid(), matcher)
    assert causes[0].kind is CauseKind.DRIFT
    assert causes[0].next == 'fpnet localize drive --floorplan plan.png --poses POSES.tum'
    causes = explained(run, plan_grid(), matcher, invocation=replace(ASKED, of_bag=True))
    assert causes[0].next == 'fpnet localize drive --floorplan plan.png --odometry both'


def test_odometry_that_flips_is_named(matcher):
    flip = SE2.from_xy_yaw(50.0, 0.0, 0.0).as_matrix4()
    # Sooner than two looks at one submap, after which the robot is found between two flips.
    scans = [(p, flip @ T if k // 20 % 2 else T, ns) for k, (p, T, ns) in enumerate(recorded())]
    (cause, *_) = explained(drive_on(plan_grid(), matcher, scans), plan_grid(), matcher)
    assert cause.kind is CauseKind.DRIFT
    assert 'was restarted' in cause.evidence
    assert cause.next == 'fpnet doctor drive'


def test_a_claim_needs_no_cause(matcher):
    run = drive_on(plan_grid(), matcher)
    assert run.outputs[-1].status is Status.LOCALIZED
    assert run.outputs[-1].causes == ()
    assert any(output.causes for output in run.outputs)


def looked_at_often(plan, matcher):
    localizer = Localizer(load_config(None, {'localizer.mirror_check_updates': 1}), matcher)
    localizer.set_plan(plan)
    source = [Scan(stamp, points, T_odom_sensor=pose) for points, pose, stamp in recorded()]
    return replay(source, localizer, 0.5, None).outputs[-1]


def test_a_running_localizer_names_a_scanner_upside_down(matcher, monkeypatch):
    plan = plan_grid().mirrored()
    mirrored = looked_at_often(plan, matcher)
    assert (mirrored.is_mirrored, mirrored.reason) == (True, MIRRORED)
    assert CauseKind.MIRRORED in [cause.kind for cause in mirrored.causes]
    monkeypatch.setattr(sensor, 'upside_down_vote', lambda scan: 1)  # planted scans are flat
    hung = looked_at_often(plan, matcher)
    assert (hung.is_mirrored, hung.reason) == (True, UPSIDE_DOWN)
    assert hung.causes[0].kind is CauseKind.UPSIDE_DOWN
    assert CauseKind.MIRRORED not in [cause.kind for cause in hung.causes]
    right = looked_at_often(plan_grid(), matcher)
    assert right.status is Status.LOCALIZED


def test_two_maps_say_why_they_do_not_match(matcher, other_plan):
    run = drive_on(plan_grid(), matcher)
    seen = submap_from_grid(run.outputs[-1].submap.grid)
    for plan, kind in (
        (other_plan, CauseKind.OTHER_PLAN),
        (plan_grid().mirrored(), CauseKind.MIRRORED),
        (rescaled(plan_grid(), 1.5), CauseKind.SCALE),
    ):
        match = match_maps(plan, seen, matcher, CONFIG, True, True)
        causes = explain_match(match, matcher, CONFIG, invocation=ASKED)
        assert causes[0].kind is kind
