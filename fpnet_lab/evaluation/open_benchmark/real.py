# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Track of public recordings and maps of real buildings, named by a manifest.

The manifest has the address, SHA-256 and licence of each file, and the fit of scans to plan. This
module only reads a local folder; ``benchmarks/fetch_open_data.py`` downloads into it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import hashlib
from importlib import resources
from pathlib import Path
from typing import Any, Self

import numpy as np

from fpnet.recordings.opening import open_scans
from fpnet.recordings.truth import read_json
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import DEFAULT_RESOLUTION_M, read_map
from fpnet_core.io.scans import Scan
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory, lengths_along
from fpnet_core.types import FREE, GridMap
from fpnet_lab.evaluation.open_benchmark.protocol import InputIs, PlanIs
from fpnet_lab.evaluation.open_benchmark.writing import (
    BenchmarkBuilding,
    CaseInput,
    DrawnSheet,
    drive_inputs,
)

FORMAT = 'fpnet_open_real_1'
LOG_PATH_M = 60.0
"""Length of a log's first part that is used, as long as generated drives. Chosen."""

STEP_M = 0.2  # chosen: path between scans, as in generated drives
_REMEDY = 'give a manifest as fpnet_lab/evaluation/open_benchmark/real.json'


@dataclass(frozen=True)
class PublicFile:
    """A file of the manifest: where it is from, what it must contain, and its licence."""

    name: str
    url: str
    sha256: str
    licence: str

    def fault(self, folder: Path) -> str:
        """Return what is wrong with the file in a folder; empty for nothing."""
        path = folder / self.name
        if not path.is_file():
            return f'{path} is missing: {self.url} ({self.licence})'
        found = hashlib.sha256(path.read_bytes()).hexdigest()
        if found != self.sha256:
            return f'{path} is another file than {self.url}: its SHA-256 is {found}'
        return ''


@dataclass(frozen=True)
class RealEntry:
    """
    A real building: a laser log or a robot map, its plan, and the fit between them.

    ``A_pixel_scans`` (2 x 3) maps metres of the log or map to pixels of the plan.
    """

    name: str
    input: str
    scans: str
    plan: str
    A_pixel_scans: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Manifest:
    """Files by name, and the buildings that they make."""

    files: dict[str, PublicFile]
    entries: tuple[RealEntry, ...]

    @classmethod
    def read(cls, path: Path | None = None) -> Self:
        """Read a manifest, the packaged one if None; raise FpnetError if it is not one."""
        packaged = resources.files('fpnet_lab.evaluation.open_benchmark') / 'real.json'
        path = path or Path(str(packaged))
        values: dict[str, Any] = read_json(path, _REMEDY)
        if values.get('format') != FORMAT:
            raise FpnetError(f'{path} is not of format {FORMAT}; {_REMEDY}')
        try:
            files = {name: PublicFile(name, **said) for name, said in values['files'].items()}
            entries = tuple(RealEntry(**entry) for entry in values['entries'])
        except (KeyError, TypeError, AttributeError) as error:
            raise FpnetError(f'{path}: {error}; {_REMEDY}') from None
        unknown = {name for each in entries for name in (each.scans, each.plan)} - set(files)
        if unknown:
            raise FpnetError(f'{path} uses {min(unknown)}, which is not among its files')
        return cls(files, entries)

    def usable(self, folder: Path) -> tuple[tuple[RealEntry, ...], list[str]]:
        """Return the entries whose files are intact, and what is wrong with the others'."""
        faults = {name: file.fault(folder) for name, file in self.files.items()}
        kept = [each for each in self.entries if not (faults[each.scans] or faults[each.plan])]
        return tuple(kept), [fault for fault in faults.values() if fault]


@dataclass(frozen=True, eq=False)
class _OnPlan:
    """A plan at the scale of the fit, flipped if it is a mirror image, and the fit."""

    plan: GridMap
    A_plan_scans: Affine2D


def real_buildings(
    entries: tuple[RealEntry, ...], folder: Path, on_building: Callable[[], None] = lambda: None
) -> Iterator[BenchmarkBuilding]:
    """Read the buildings of intact entries; the foreign plan is the next entry's."""
    placed = [_on_plan(entry, folder) for entry in entries]
    for number, (entry, own) in enumerate(zip(entries, placed, strict=True)):
        elsewhere = {PlanIs.MIRRORED: DrawnSheet(own.plan.mirrored())}
        following = placed[(number + 1) % len(placed)]
        if following is not own:
            elsewhere[PlanIs.FOREIGN] = DrawnSheet(following.plan)
        read = {'log': _log, 'map': _robot_map}
        if entry.input not in read:
            raise FpnetError(f'{entry.name}: unknown input {entry.input!r}; expected log or map')
        inputs, truth = read[entry.input](folder / entry.scans)
        yield BenchmarkBuilding(inputs, truth, DrawnSheet(own.plan), own.A_plan_scans, elsewhere)
        on_building()


def _on_plan(entry: RealEntry, folder: Path) -> _OnPlan:
    A_pixel_scans = Affine2D.from_matrix(entry.A_pixel_scans)
    resolution_m = float(1.0 / np.sqrt(abs(np.linalg.det(A_pixel_scans.linear))))
    plan = read_map(folder / entry.plan, resolution_m)
    A_plan_scans = pixel_to_xy(plan) @ A_pixel_scans
    if not A_plan_scans.is_mirrored:
        return _OnPlan(plan, A_plan_scans)
    width_m = plan.shape[1] * plan.resolution
    flip = Affine2D(np.diag([-1.0, 1.0]), np.array([width_m, 0.0]))
    return _OnPlan(plan.mirrored(), flip @ A_plan_scans)


def _log(path: Path) -> tuple[tuple[CaseInput, ...], PlanarTrajectory]:
    """Return the scans of a log's first part, and their poses as truth."""
    scans = list(open_scans(path))
    along = lengths_along(_poses(scans).xy)
    steps = np.floor(along[along <= LOG_PATH_M] / STEP_M)
    kept = [scans[index] for index in np.unique(steps, return_index=True)[1]]
    return drive_inputs(kept), _poses(kept)


def _poses(scans: list[Scan]) -> PlanarTrajectory:
    poses = np.array([scan.T_odom_sensor for scan in scans])
    return PlanarTrajectory.from_transforms([scan.stamp_ns for scan in scans], poses)


def _robot_map(path: Path) -> tuple[tuple[CaseInput, ...], PlanarTrajectory]:
    """Return a robot's map with a pose in its middle, and that pose as truth."""
    grid = read_map(path, DEFAULT_RESOLUTION_M)
    free = grid.rc_to_xy(np.argwhere(grid.cells == FREE))
    middle = free[np.linalg.norm(free - free.mean(axis=0), axis=1).argmin()]
    stamps_ns = np.array([0, NS_PER_S], dtype=np.int64)  # a truth has at least two poses
    truth = PlanarTrajectory(stamps_ns, np.stack([middle, middle]), np.zeros(2))
    first = truth.take(np.array([0]))
    return (CaseInput(InputIs.MAP, first, robot_map=grid),), truth
