# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Files of the open benchmark: cases, their truth, and the answers of a program.

A folder of cases holds ``cases.json`` with the plan and the scans of each case, both folders
``plans`` and ``scans``, and the truth in ``truth``, which no program gets. Names are numbers in
random order, so that none reveals an answer.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
import json
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fpnet.recordings.trajectories import parse_poses, read_rows, write_tum
from fpnet.recordings.truth import read_json, read_planar
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Status

FORMAT = 'fpnet_open_1'
"""Version of these files."""

CASES_NAME, TRUTH_NAME = 'cases.json', 'truth/truth.json'
ODOMETRY_NAME, SCANS_NAME, MAP_NAME = 'odometry.tum', 'scans.npz', 'map.yaml'

# Given by the format: words of a plain TUM line, and of one with status and probability.
_PLAIN, _FULL = 8, 10
_CANNOT_SAY = ['cannot', 'say']
_REMEDY = 'make the cases with: fpnet bench open make'


class PlanIs(StrEnum):
    """Relation of a case's plan to the building of its scans; only ``own`` has a right answer."""

    OWN = 'own'
    FOREIGN = 'foreign'
    MIRRORED = 'mirrored'
    OTHER_FLOOR = 'other_floor'


class InputIs(StrEnum):
    """Input of a case: a whole drive, a finished map, a part of the path, or a single scan."""

    DRIVE = 'drive'
    MAP = 'map'
    PATH_30 = 'path_30_m'
    PATH_15 = 'path_15_m'
    SCAN = 'one_scan'


@dataclass(frozen=True)
class OpenCase:
    """A case as a program gets it: its name, and the paths of plan and scans in the folder."""

    name: str
    plan: str
    scans: str


@dataclass(frozen=True)
class CaseTruth:
    """
    Truth of a case.

    ``poses`` is the TUM file of the true poses, in true metres; ``A_plan_truth`` (2 x 3) maps them
    to the plan, None on a plan that does not show their building.
    """

    plan_is: PlanIs
    input_is: InputIs
    poses: str
    A_plan_truth: list[list[float]] | None = None


@dataclass(frozen=True)
class CaseSet:
    """A folder of cases with their truth by name; ``made`` holds track, seed and options."""

    folder: Path
    made: Mapping[str, Any]
    cases: tuple[OpenCase, ...]
    truths: Mapping[str, CaseTruth]

    def write(self) -> None:
        """Write ``cases.json`` and the truth; the files that they name exist."""
        public = {'format': FORMAT, **self.made, 'cases': [asdict(case) for case in self.cases]}
        truths = {name: asdict(truth) for name, truth in self.truths.items()}
        for name, content in ((CASES_NAME, public), (TRUTH_NAME, {'cases': truths})):
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read a folder of cases; raise FpnetError if it is not one."""
        public = read_json(folder / CASES_NAME, _REMEDY)
        if public.pop('format', None) != FORMAT:
            raise FpnetError(f'{folder / CASES_NAME} is not of format {FORMAT}; {_REMEDY}')
        try:
            cases = tuple(OpenCase(**case) for case in public.pop('cases'))
            hidden = read_json(folder / TRUTH_NAME, _REMEDY)['cases']
            truths = {case.name: _truth_of(hidden[case.name]) for case in cases}
        except (KeyError, TypeError, ValueError) as error:
            raise FpnetError(f'{folder} is no folder of cases ({error!r}); {_REMEDY}') from None
        return cls(folder, public, cases, truths)

    def odometry(self, case: OpenCase) -> PlanarTrajectory:
        """Return the sensor poses of a case's scans in ``odom``, or in the frame of its map."""
        return read_planar(self.folder / case.scans / ODOMETRY_NAME)

    def true_poses(self, case: OpenCase) -> PlanarTrajectory:
        """Return the true sensor poses, in true metres."""
        return read_planar(self.folder / self.truths[case.name].poses)

    def A_plan_truth(self, case: OpenCase) -> Affine2D | None:
        """Return the map from true metres to the plan; None on the plan of another building."""
        matrix = self.truths[case.name].A_plan_truth
        return None if matrix is None else Affine2D.from_matrix(matrix)


def _truth_of(values: Mapping[str, Any]) -> CaseTruth:
    kinds = {'plan_is': PlanIs(values['plan_is']), 'input_is': InputIs(values['input_is'])}
    return CaseTruth(**{**values, **kinds})


@dataclass(frozen=True, eq=False)
class StatedPoses:
    """
    Answer of a program: sensor poses on the plan at the stamps of scans.

    ``is_claimed (S,)``: the program claims the pose, otherwise it is a guess; ``probability (S,)``
    that it is right. A scan without a pose means "cannot say".
    """

    poses: PlanarTrajectory
    is_claimed: NDArray[np.bool_]
    probability: NDArray[np.float64]

    @classmethod
    def nothing(cls) -> Self:
        """Return the answer "cannot say"."""
        return cls(PlanarTrajectory.empty(), np.zeros(0, dtype=np.bool_), np.zeros(0))

    @property
    def claimed(self) -> PlanarTrajectory:
        """The claimed poses."""
        return self.poses.take(self.is_claimed)


def write_answer(path: Path, answer: StatedPoses) -> None:
    """Write an answer as TUM lines, each followed by a status and a probability."""
    write_tum(path, answer.poses.stamps_ns, answer.poses.xy, answer.poses.yaw)
    said = [Status.LOCALIZED if each else Status.AMBIGUOUS for each in answer.is_claimed]
    lines = [
        f'{line} {status.value} {probability:.6f}\n'
        for line, status, probability in zip(
            path.read_text(encoding='utf-8').splitlines(), said, answer.probability, strict=True
        )
    ]
    path.write_text(''.join(lines) or 'cannot say\n', encoding='utf-8')


def read_answer(path: Path, odometry: PlanarTrajectory) -> StatedPoses:
    """
    Read the answer of a program.

    A line is ``t x y z qx qy qz qw status probability``; without the last two, the pose is claimed
    with probability 1. Only the status ``localized`` claims. An empty file and ``cannot say``
    state no pose.

    Raises
    ------
    FpnetError
        If a line is malformed, two have the same time, or one is not at the time of a scan.
    """
    rows = [row for row in read_rows(path) if row[:2] != _CANNOT_SAY]
    if not rows:
        return StatedPoses.nothing()
    for number, row in enumerate(rows, start=1):
        if len(row) not in (_PLAIN, _FULL):
            raise FpnetError(
                f'{path}: pose line {number} has {len(row)} values; expected '
                '"t x y z qx qy qz qw", alone or with "status probability"'
            )
    poses = parse_poses([row[:_PLAIN] for row in rows], path)
    probability = np.array([_probability(row, path) for row in rows])
    is_claimed = np.array([row[_PLAIN:][:1] in ([], [Status.LOCALIZED.value]) for row in rows])
    order = np.argsort(poses.stamps_ns, kind='stable')
    stated = PlanarTrajectory(poses.stamps_ns, poses.xy, poses.yaw).take(order)
    if (np.diff(stated.stamps_ns) == 0).any():
        raise FpnetError(f'{path} has two poses of the same time; expected one for each scan')
    near = np.abs(stated.stamps_ns[:, None] - odometry.stamps_ns[None]).min(axis=1)
    if (near > _SAME_STAMP_NS).any():
        raise FpnetError(
            f'{path}: pose line {int(order[near.argmax()]) + 1} is not at the time of a scan; '
            f'copy the times of {ODOMETRY_NAME}'
        )
    return StatedPoses(stated, is_claimed[order], probability[order])


_SAME_STAMP_NS = 1_000_000  # numerical: a program may round times to milliseconds


def _probability(row: list[str], path: Path) -> float:
    word = row[-1] if len(row) == _FULL else '1'
    try:
        value = float(word)
    except ValueError:
        value = -1.0  # out of range as well
    if not 0.0 <= value <= 1.0:
        raise FpnetError(f'{path}: probability {word!r}; expected a number from 0 to 1')
    return value
