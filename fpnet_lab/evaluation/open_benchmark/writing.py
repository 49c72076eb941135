# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Writer of cases: inputs on their own plan and on plans of which none is right.

Plans and scans get numbers in random order, and the order of the cases is random.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from fpnet.recordings.trajectories import write_tum
from fpnet_core.config import SubmapConfig
from fpnet_core.errors import ConfigError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.arrays import write_arrays
from fpnet_core.io.maps import write_map
from fpnet_core.io.scans import Scan
from fpnet_core.trajectory import PlanarTrajectory, lengths_along
from fpnet_core.types import GridMap
from fpnet_lab.evaluation.localization.drives import submap_of
from fpnet_lab.evaluation.open_benchmark.protocol import (
    CASES_NAME,
    MAP_NAME,
    ODOMETRY_NAME,
    SCANS_NAME,
    CaseSet,
    CaseTruth,
    InputIs,
    OpenCase,
    PlanIs,
)

_NUMBERS = 1_000_000  # numerical: range of the random names

PATHS_M = {InputIs.PATH_30: 30.0, InputIs.PATH_15: 15.0, InputIs.SCAN: 0.0}
"""Given: paths of the submaps of LiDAR2BIM, and of a single scan."""


@dataclass(frozen=True, eq=False)
class DrawnSheet:
    """A plan to write: a raster, and a drawing's picture in the raster's place if there is one."""

    grid: GridMap
    drawing: Image.Image | None = None


@dataclass(frozen=True, eq=False)
class CaseInput:
    """Scans with odometry, or a finished map with the robot's poses in its frame."""

    input_is: InputIs
    poses: PlanarTrajectory
    scans: tuple[Scan, ...] = ()
    robot_map: GridMap | None = None


@dataclass(frozen=True, eq=False)
class BenchmarkBuilding:
    """
    A building of a track: its inputs and plans.

    ``truth`` holds true sensor poses in true metres, ``A_plan_truth`` maps them to ``plan``.
    ``elsewhere`` are the plans without a right answer.
    """

    inputs: tuple[CaseInput, ...]
    truth: PlanarTrajectory
    plan: DrawnSheet
    A_plan_truth: Affine2D
    elsewhere: Mapping[PlanIs, DrawnSheet] = field(default_factory=dict)


def drive_inputs(scans: Sequence[Scan], with_map: bool = True) -> tuple[CaseInput, ...]:
    """Return a drive, its map, and the middle of its path of each length in :data:`PATHS_M`."""
    inputs = [_of_scans(InputIs.DRIVE, scans)]
    if with_map:
        inputs.append(_mapped(scans))
    along = lengths_along(inputs[0].poses.xy)
    for input_is, path_m in PATHS_M.items():
        if path_m <= along[-1]:
            start_m = 0.5 * (along[-1] - path_m)
            first = int(np.searchsorted(along, start_m))
            last = max(first, int(np.searchsorted(along, start_m + path_m, side='right')) - 1)
            inputs.append(_of_scans(input_is, scans[first : last + 1]))
    return tuple(inputs)


def _of_scans(input_is: InputIs, scans: Sequence[Scan]) -> CaseInput:
    return CaseInput(input_is, _path(scans), tuple(scans))


def _path(scans: Sequence[Scan]) -> PlanarTrajectory:
    poses = np.array([scan.T_odom_sensor for scan in scans])
    return PlanarTrajectory.from_transforms([scan.stamp_ns for scan in scans], poses)


def _mapped(scans: Sequence[Scan]) -> CaseInput:
    """Return the map of all scans, with the pose of the last one in its frame."""
    submap = submap_of(scans, SubmapConfig())
    last = _path(scans[-1:]).mapped(submap.T_odom_submap.inv())
    return CaseInput(InputIs.MAP, last, robot_map=submap.grid)


def write_cases(
    folder: Path, buildings: Iterator[BenchmarkBuilding], made: Mapping[str, Any], seed: int
) -> CaseSet:
    """
    Write the cases of all buildings: all inputs on the own plan, drives and maps also elsewhere.

    Maps of a building that has a drive are written on the own plan only.

    Raises
    ------
    ConfigError
        If the folder holds cases.
    """
    if (folder / CASES_NAME).exists():
        raise ConfigError(f'{folder} holds cases; choose another folder, or remove it')
    rng = np.random.default_rng(seed)
    writer = _Writer(folder, rng)
    drafts = [draft for building in buildings for draft in writer.drafts(building)]
    cases, truths = [], {}
    for number, index in enumerate(rng.permutation(len(drafts))):
        plan, scans, truth = drafts[index]
        name = f'{number:04d}'
        cases.append(OpenCase(name, plan, scans))
        truths[name] = truth
    made_set = CaseSet(folder, made, tuple(cases), truths)
    made_set.write()
    return made_set


class _Writer:
    """Writes plans, scans and true poses under random numbers that are used once."""

    def __init__(self, folder: Path, rng: np.random.Generator) -> None:
        self._folder, self._rng = folder, rng
        self._used: set[int] = set()

    def drafts(self, building: BenchmarkBuilding) -> Iterator[tuple[str, str, CaseTruth]]:
        """Write a building; yield plan, scans and truth of each case."""
        poses = f'truth/{self._name()}.tum'
        truth = building.truth
        write_tum(self._folder / poses, truth.stamps_ns, truth.xy, truth.yaw)
        plans = {PlanIs.OWN: building.plan, **building.elsewhere}
        paths = {plan_is: self._plan(sheet) for plan_is, sheet in plans.items()}
        whole = building.inputs[0].input_is
        matrix = building.A_plan_truth.matrix[:2].tolist()
        for each in building.inputs:
            scans = self._scans(each)
            for plan_is, plan in paths.items():
                if plan_is is PlanIs.OWN or each.input_is is whole:
                    A = matrix if plan_is is PlanIs.OWN else None
                    yield plan, scans, CaseTruth(plan_is, each.input_is, poses, A)

    def _name(self) -> str:
        """Return an unused random number."""
        while (number := int(self._rng.integers(_NUMBERS))) in self._used:
            pass
        self._used.add(number)
        return f'{number:06d}'

    def _plan(self, sheet: DrawnSheet) -> str:
        path = f'plans/{self._name()}.yaml'
        write_map(sheet.grid, self._folder / path)
        if sheet.drawing is None:
            return path
        drawing = Path(path).with_suffix('.png').as_posix()
        sheet.drawing.save(self._folder / drawing)
        return drawing

    def _scans(self, each: CaseInput) -> str:
        path = f'scans/{self._name()}'
        folder = self._folder / path
        write_tum(folder / ODOMETRY_NAME, each.poses.stamps_ns, each.poses.xy, each.poses.yaw)
        if each.robot_map is not None:
            write_map(each.robot_map, folder / MAP_NAME)
        else:
            clouds = {f'{k:06d}': scan.points for k, scan in enumerate(each.scans)}
            write_arrays(folder / SCANS_NAME, clouds)
        return path
