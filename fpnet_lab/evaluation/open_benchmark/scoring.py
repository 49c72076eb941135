# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scores of a program in the open benchmark.

A pose is right within 1 m and 10 degrees, wrong beyond 3 m or 30 degrees, in true metres. Scores
marked (any pose) use the stated pose of a scan whether it is claimed or not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet.accuracy import pose_errors
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.evaluation.localization.figures import median
from fpnet_lab.evaluation.localization.records import (
    RIGHT,
    MethodRun,
    Record,
    RunLabels,
    Truth,
    UpdateEstimate,
    score,
)
from fpnet_lab.evaluation.open_benchmark.protocol import (
    CaseSet,
    InputIs,
    OpenCase,
    PlanIs,
    StatedPoses,
)
from fpnet_lab.evaluation.open_benchmark.running import ProgramRun
from fpnet_lab.metrics import brier_score, expected_calibration_error, mean
from fpnet_lab.scores import Column, Figures, Row, Table, Units, columns, named, of

CHALLENGE_RATE = 0.4605
"""Given by the Hilti-Trimble-Oxford challenge of 2026: 10 of 100 points at an error of 5 m."""

SEQUENCE, SEQUENCE_END = 100, 10
"""
Given: sequences of UnLoc and F3Loc have 100 frames; a sequence succeeds if the last ten poses are
within a metre.
"""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CaseScore:
    """
    Score of one answer; None where there is nothing to measure.

    ``best_is_right``: the stated pose of the last scan is right (any pose). ``challenge`` is the
    mean of the challenge's score over all scans, 0 without a pose (any pose); ``is_success``:
    the last ten of the first hundred scans are within a metre (any pose).
    """

    plan_is: PlanIs
    input_is: InputIs
    record: Record
    best_is_right: bool
    first_pose_s: float | None
    challenge: float | None
    is_success: bool | None

    @property
    def is_claimed(self) -> bool:
        """Whether any pose was claimed."""
        return self.record.poses > 0

    @property
    def is_claimed_wrong(self) -> bool:
        """Whether a claimed pose was wrong."""
        return self.record.wrong_poses > 0


def score_case(cases: CaseSet, case: OpenCase, answer: StatedPoses) -> CaseScore:
    """Score the answer to a case."""
    hidden, A_plan_truth = cases.truths[case.name], cases.A_plan_truth(case)
    odometry = cases.odometry(case)
    true = cases.true_poses(case)
    labels = RunLabels(case.name, hidden.input_is, '', '', 0, '', hidden.plan_is)
    truth = None if A_plan_truth is None else Truth(true, A_plan_truth)
    record = score(labels, _as_run(answer, odometry), truth)
    claimed = answer.claimed
    first_s = (claimed.stamps_ns[0] - odometry.stamps_ns[0]) / NS_PER_S if len(claimed) else None
    challenge = is_success = None
    last_is_right = False
    if A_plan_truth is not None:
        position, yaw = _errors(answer.poses, odometry, true, A_plan_truth)
        challenge = float(np.mean(100.0 * np.exp(-CHALLENGE_RATE * position)))
        if len(position) >= SEQUENCE:
            ending = position[SEQUENCE - SEQUENCE_END : SEQUENCE]
            is_success = bool((ending <= RIGHT[0]).all())
        last_is_right = bool(position[-1] <= RIGHT[0] and yaw[-1] <= RIGHT[1])
    return CaseScore(
        hidden.plan_is, hidden.input_is, record, last_is_right, first_s, challenge, is_success
    )


def _errors(
    stated: PlanarTrajectory, odometry: PlanarTrajectory, true: PlanarTrajectory, A: Affine2D
) -> tuple[Array, Array]:
    """Return position [m] and yaw [rad] errors at each scan, infinite without a pose."""
    position = np.full(len(odometry), np.inf)
    yaw = np.full(len(odometry), np.inf)
    if len(stated):
        index = np.abs(stated.stamps_ns[:, None] - odometry.stamps_ns[None]).argmin(axis=1)
        position[index], yaw[index] = pose_errors(stated.mapped(A.inv()), true)
    return position, yaw


def _as_run(answer: StatedPoses, odometry: PlanarTrajectory) -> MethodRun:
    """Return an answer as a run: claims are its published poses, all poses its estimates."""
    poses, nothing = answer.poses, np.zeros(0)
    moved, _ = odometry.at(poses.stamps_ns)
    beliefs = tuple(
        UpdateEstimate(
            int(poses.stamps_ns[k]),
            float(answer.probability[k]),
            _pose(poses, k) @ _pose(moved, k).inv(),
        )
        for k in range(len(poses))
    )
    return MethodRun(answer.claimed, odometry, beliefs, nothing, nothing, 0.0)


def _pose(poses: PlanarTrajectory, index: int) -> SE2:
    x, y = poses.xy[index].tolist()
    return SE2.from_xy_yaw(x, y, float(poses.yaw[index]))


def open_report(cases: CaseSet, runs: Sequence[ProgramRun]) -> dict[str, Any]:
    """Return the figures of each program with the description of the cases."""
    programs = {}
    for run in runs:
        scores = [score_case(cases, case, run.answer(cases, case)) for case in cases.cases]
        programs[run.name] = {**_figures(scores), 'failed': len(run.failures)}
    return {**cases.made, 'cases': len(cases.cases), 'programs': programs}


def _figures(scores: Sequence[CaseScore]) -> dict[str, Any]:
    own = [each for each in scores if each.plan_is is PlanIs.OWN]
    drives = [each for each in own if each.input_is is InputIs.DRIVE]
    sequences = [each for each in drives if each.is_success is not None]
    said = [line for each in scores for line in each.record.beliefs]
    probability = np.array([p for p, _ in said], dtype=np.float64)
    is_right = np.array([right for _, right in said], dtype=np.bool_)
    found: dict[str, Any] = {
        **_counts('drive', drives),
        'first_pose_m': median(each.record.path_to_first_pose_m for each in drives),
        'first_pose_s': median(each.first_pose_s for each in drives),
        'position_m': median(each.record.median_position_error_m for each in drives),
        'yaw_deg': median(each.record.median_yaw_error_deg for each in drives),
        'challenge': _rounded(mean(_known(each.challenge for each in drives))),
        'sequences': len(sequences),
        'successes': sum(bool(each.is_success) for each in sequences),
        'ece': _rounded(expected_calibration_error(probability, is_right)) if said else None,
        'brier': _rounded(brier_score(probability, is_right)) if said else None,
    }
    for input_is in list(InputIs)[1:]:
        found |= _counts(input_is.value, [each for each in own if each.input_is is input_is])
    for plan_is in list(PlanIs)[1:]:
        elsewhere = [each for each in scores if each.plan_is is plan_is]
        found[plan_is.value] = len(elsewhere)
        found[f'{plan_is.value}_claimed'] = sum(each.is_claimed for each in elsewhere)
    return found


def _counts(name: str, scores: Sequence[CaseScore]) -> dict[str, int]:
    """Return the cases of an input, and of them the right, claimed right and claimed wrong."""
    wrong = [each.is_claimed_wrong for each in scores]
    claimed = [each.is_claimed for each in scores]
    return {
        name: len(scores),
        f'{name}_right': sum(each.best_is_right for each in scores),
        f'{name}_claimed_right': sum(claimed) - sum(wrong),
        f'{name}_claimed_wrong': sum(wrong),
    }


def _known(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


# Numerical, digits:
_DRIVES = (
    Column('program', 'name'),
    Column('right', of('drive_right', 'drive')),
    Column('claimed, right', of('drive_claimed_right', 'drive')),
    Column('claimed, wrong', of('drive_claimed_wrong', 'drive')),
    Column('first pose', 'first_pose_m', Units.PATH.to(1, 'none')),
    Column('after', 'first_pose_s', Units.SECONDS.to(1, 'none')),
    Column('position', 'position_m', Units.METRES.to(2, 'none')),
    Column('yaw', 'yaw_deg', Units.DEGREES.to(1, 'none')),
    Column('challenge', 'challenge', Units.NUMBER.to(0)),
    Column('within 1 m, T = 100', of('successes', 'sequences')),
    *columns(Units.NUMBER.to(2, 'none'), {'ece': 'ECE', 'brier': 'Brier'}),
)
_MADE = ('track', 'seed', 'count', 'sensor')
_ELSEWHERE = {
    PlanIs.FOREIGN: "claimed on other buildings' plans",
    PlanIs.MIRRORED: 'on mirrored plans',
    PlanIs.OTHER_FLOOR: 'on other floors',
}
_INPUTS = {
    InputIs.MAP: 'finished map',
    InputIs.PATH_30: '30 m',
    InputIs.PATH_15: '15 m',
    InputIs.SCAN: 'one scan',
}


def open_figures(report: Row) -> Figures:
    """Return a row for each program: on drives, and on wrong plans and smaller inputs."""
    rows = list(named(report['programs'], '`{}`'))
    wrong = [
        Column(title, of(f'{kind.value}_claimed', kind.value))
        for kind, title in _ELSEWHERE.items()
        if any(row[kind.value] for row in rows)
    ]
    small = [
        Column(title, _right_and_wrong(kind.value))
        for kind, title in _INPUTS.items()
        if any(row[kind.value] for row in rows)
    ]
    options = ', '.join(f'{key} {report[key]}' for key in _MADE if key in report)
    note = f'{report["cases"]} cases: {options}.'
    return {
        '': Table.of(_DRIVES, rows, note),
        'more': Table.of([_DRIVES[0], *wrong, *small], rows),
    }, {}


def _right_and_wrong(name: str) -> Callable[[Row], str]:
    """Return a function that formats right cases, and the number of wrong claims."""

    def text(row: Row) -> str:
        return f'{row[f"{name}_right"]} of {row[name]}, {row[f"{name}_claimed_wrong"]} wrong'

    return text
