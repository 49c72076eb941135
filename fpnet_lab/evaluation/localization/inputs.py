# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans, plan and truth of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fpnet.recordings.opening import open_scans
from fpnet_core.errors import ConfigError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import read_map
from fpnet_core.io.scans import Scan
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import GridMap
from fpnet_lab.evaluation.fitted_truth import read_fitted_truth
from fpnet_lab.evaluation.localization.cases import Case, CaseKind, Distortion
from fpnet_lab.evaluation.localization.plans import draw_plan, draw_roughly
from fpnet_lab.sim.drawn.distort import DrawnPlan
from fpnet_lab.sim.drives.mesh_worlds import read_mesh
from fpnet_lab.sim.drives.recording import Recording, RecordingOptions, make_recording
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.lidars.sensors import SENSORS

LIMITS = TourLimits(rooms=4, shortest_s=60.0, longest_s=95.0)
"""Tours of 40 to 60 m. Chosen."""

ROOMS = (8, 60)
"""Fewest and most rooms of a building. Chosen."""

MESH_LIMITS = TourLimits(rooms=4, shortest_s=40.0, longest_s=95.0)
"""Tours in the small house are shorter. Chosen."""

_MESH_FILES = {
    'aws_small_house': 'small_house_all.ply',
    'cpr_office': 'office_mesh.ply',
    'willowgarage': 'willow_mesh.ply',
    'aws_hospital': 'hospital_all.ply',
}
_MESH_PLAN = 'floorplan_from_mesh.yaml'
_SEEDS_TRIED = 8  # numerical
_SEED_STEP = 100_000  # numerical: to the next seed if a building has no such tour


@dataclass(frozen=True, eq=False)
class CaseInputs:
    """
    Inputs of a run and the truth to score it.

    ``truth`` holds true sensor poses in a truly metric frame, ``A_plan_truth`` maps that frame to
    the plan's nominal metres.
    """

    scans: Iterable[Scan]
    plan: GridMap
    A_plan_truth: Affine2D
    truth: PlanarTrajectory


class MissingDataError(Exception):
    """The case needs real data that this machine lacks; it is skipped."""


def make_inputs(case: Case, data: Path) -> CaseInputs:
    """
    Build the inputs of a case.

    Parameters
    ----------
    case : Case
    data : folder with the real data sets ``radish`` and ``mesh_*``

    Raises
    ------
    MissingDataError
        If the case needs a data set that ``data`` does not hold.
    """
    makers: dict[CaseKind, Callable[[Case, Path], CaseInputs]] = {
        CaseKind.GENERATED: _generated,
        CaseKind.MESH: _mesh,
        CaseKind.LOG: _log,
    }
    return makers[case.kind](case, data)


def make_plan(case: Case) -> GridMap:
    """Return only the plan of a generated case."""
    return draw_plan(_recording(case).building.plan, case.distortion, case.seed).grid


def make_rough_plan(case: Case, distortion: Distortion = Distortion.EXACT) -> DrawnPlan:
    """Return a rough drawing of a generated case's building, with a distortion in addition."""
    return draw_roughly(_recording(case).building.plan, distortion, case.seed)


def _generated(case: Case, data: Path) -> CaseInputs:
    del data  # everything is generated
    recording = _recording(case)
    drawing = draw_plan(recording.building.plan, case.distortion, case.seed)
    truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    return CaseInputs(recording, drawing.grid, drawing.A_plan_building, truth)


def _recording(case: Case) -> Recording:
    return drive_through(case.building, case.sensor, case.seed)


def drive_through(
    family: str | None,
    sensor: str,
    seed: int,
    *,
    rooms: tuple[int, int] = ROOMS,
    limits: TourLimits = LIMITS,
) -> Recording:
    """
    Return a recording of a generated building of a family; None: any family.

    If the seed's building has no such tour, one of the next seeds is used.

    Raises
    ------
    ConfigError
        If none of several seeds has such a tour.
    """
    options = RecordingOptions(family=family, rooms=rooms, limits=limits, lidar=SENSORS[sensor])
    reason = ''
    for attempt in range(_SEEDS_TRIED):
        try:
            return make_recording(seed + attempt * _SEED_STEP, options, threads=1)
        except ConfigError as error:
            reason = str(error)
    raise ConfigError(f'{family or "any family"}: no building in {_SEEDS_TRIED} seeds: {reason}')


def _mesh(case: Case, data: Path) -> CaseInputs:
    """Simulate a recording in a real building's mesh, which shares the frame of its plan."""
    folder = data / f'mesh_{case.building}'
    if not folder.is_dir():
        raise MissingDataError(f'{folder} is missing')
    recording = make_recording(
        case.seed,
        RecordingOptions(limits=MESH_LIMITS, lidar=SENSORS[case.sensor]),
        threads=1,
        floorplan=read_map(folder / _MESH_PLAN),
        mesh=read_mesh(folder / _MESH_FILES[case.building]),
    )
    truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    return CaseInputs(recording, recording.floorplan, recording.A_plan_building, truth)


def _log(case: Case, data: Path) -> CaseInputs:
    folder = data / 'radish'
    if not folder.is_dir():
        raise MissingDataError(f'{folder} is missing')
    fitted = read_fitted_truth(folder, case.building)
    scans = list(open_scans(fitted.log))
    poses = np.array([scan.T_odom_sensor for scan in scans])
    truth = PlanarTrajectory.from_transforms([scan.stamp_ns for scan in scans], poses)
    return CaseInputs(scans, fitted.plan, fitted.A_plan_log, truth)
