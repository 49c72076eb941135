# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Cases of ``vary_constants.py``: at least one for each independent part of the product.

They are the first cases of ``fpnet bench regression``, segmentation of submaps, parsing of drawing
files, a library query, an outdated drawing, and checks of a floorplan and a bag.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
import importlib
from itertools import chain
from pathlib import Path
from typing import NoReturn

import numpy as np
from scipy.spatial.transform import Rotation

from fpnet.doctor.bag import observe_bag
from fpnet.doctor.examine import examine
from fpnet.library import PlanLibrary, plan_of
from fpnet.plan_check.check import check_plan
from fpnet_core.config import FpnetConfig
from fpnet_core.differences import find_differences
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import ConfigError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.localizer.prepared_maps import StageTimer, prepare_plan, prepare_submap
from fpnet_core.segmentation import STATED_SCALE, SubmapSegmenter, segment_floorplan
from fpnet_core.stamps import NS_PER_S
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import GridMap, Segmentation
from fpnet_lab.evaluation.drawings import segmented, written
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.regression import Answer, RegressionCase, differences, make_cases
from fpnet_lab.evaluation.submap_recordings import RegisteredDrive, registered_drive
from fpnet_lab.evaluation.submap_segmentation import segment_drive
from fpnet_lab.sim.drawn.rough import robot_map_of
from fpnet_lab.sim.drawn.styled import styled_drawing
from fpnet_lab.sim.drives.recording import write_recording
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.sheets import SheetKind, draw_sheet

CASES = {'plans': 6, 'pairs': 4, 'drives': 1}
"""Number of first cases of each kind of the benchmark. Chosen: some seconds per trial."""

SENSORS = ('planar', 'beams32')
SHEETS = (('office', 'dxf'), ('scan', 'picture'), ('brochure', 'pdf'), ('phone', 'picture'))
"""Sensors of submaps; kinds of drawings and file formats. Chosen: ten seconds for all."""

_SEED = 77  # numerical: of the first submap and the first drawing, both in development splits
_KNOWN_PLANS = 4  # chosen: number of plans in the library
_MOVED_M = (0.9, 0.5)  # chosen: offset of the outdated drawing
_TOUR = TourLimits(rooms=2, shortest_s=15.0, longest_s=30.0)
_LISTENED_S = 60.0  # chosen: longer than the bag
_LATE_NS = NS_PER_S // 5  # chosen: delay of stamps
_R_TILTED = Rotation.from_euler('y', 8.0, degrees=True).as_matrix().astype(np.float32)
_ALIKE = 'similar_alone', 'similar_with_neighbours'


def all_cases(config: FpnetConfig, folder: Path) -> Iterator[RegressionCase]:
    """Yield all cases, with drawing files in ``folder``."""
    yield from chain(
        map_cases(),
        make_cases(CASES),
        sheet_cases(folder),
        submap_cases(config),
        checked_cases(folder),
    )


def first_difference(case: RegressionCase, found: Answer, before: Answer) -> str:
    """Return the first difference of a case's answer from before, or an empty string."""
    if case.kind not in CASES:
        return '' if found == before else f'{case.name}: {found}, was {before}'
    lines = differences({case.kind: {case.name: found}}, {case.kind: {case.name: before}})
    return lines[0] if lines else ''


def submap_cases(config: FpnetConfig) -> Iterator[RegressionCase]:
    """Yield one recording per sensor whose submap is segmented into rooms."""
    for number, sensor in enumerate(SENSORS):
        drive = registered_drive(_SEED + number, sensor, config)
        yield RegressionCase('plans', f'submap-{sensor}', partial(_segmented_submap, drive))


def _segmented_submap(drive: RegisteredDrive, config: FpnetConfig) -> Answer:
    """Return the rooms and doors of a recording's submap."""
    return _rooms_of(segment_drive(drive, config), [len(drive.sweeps)])


def sheet_cases(folder: Path) -> Iterator[RegressionCase]:
    """Yield drawings parsed like a user's, with vector files parsed in this process."""
    worker = importlib.import_module('fpnet_core.drawings.formats.worker')
    worker.read_apart = worker.read_here  # type: ignore[attr-defined]
    for number, (kind, file_format) in enumerate(SHEETS):
        sheet = draw_sheet(_SEED + number, SheetKind(kind))
        path, _ = written(sheet, folder / f'{number}-{kind}', file_format)
        name = f'{file_format}-{kind}'
        yield RegressionCase('plans', name, partial(_segmented_sheet, path))


def _segmented_sheet(path: Path, config: FpnetConfig) -> Answer:
    """Return the rooms and doors of a drawing; the areas depend on its scale."""
    reading = read_plan(path, ReadOptions(), config)
    return _rooms_of(segmented(reading, config.segmentation), [len(reading.doubts) + 1])


def checked_cases(folder: Path) -> Iterator[RegressionCase]:
    """Yield a floorplan check without recordings, and a check of a bag with and without faults."""
    path = folder / 'checked.yaml'
    write_map(styled_drawing(np.random.default_rng((_SEED, 2))), path)
    yield RegressionCase('checked', 'plan-check', partial(_checked_plan, path))
    drive = drive_through(None, 'beams16', _SEED, limits=_TOUR)
    write_recording(drive, folder / 'drive', with_wheels=True)
    yield RegressionCase('checked', 'doctor', partial(_examined, folder / 'drive'))


def _checked_plan(path: Path, config: FpnetConfig) -> Answer:
    """Return a floorplan's check result, with numbers of similar rooms."""
    reading = read_plan(path, ReadOptions(), config)
    values = check_plan(reading, config, range(0), _no_drive).as_json()
    alike = {key: {room: len(values[key][room]) for room in values[key]} for key in _ALIKE}
    return {'advice': values['advice'], 'symmetries': len(values['symmetries']), **alike}


def _no_drive(*_: object) -> NoReturn:
    raise ConfigError('no recordings')


def _examined(folder: Path, config: FpnetConfig) -> Answer:
    """Return the findings for a bag, for the same with late scans, and with tilted scans."""
    del config
    seen = observe_bag(folder, _LISTENED_S)
    late = [replace(sweep, stamp_ns=sweep.stamp_ns + _LATE_NS) for sweep in seen.sweeps]
    tilted = [replace(sweep, points=sweep.points @ _R_TILTED) for sweep in seen.sweeps]
    each = [seen, *(replace(seen, sweeps=tuple(sweeps)) for sweeps in (late, tilted))]
    return {'found': [[finding.problem.value for finding in examine(one)] for one in each]}


def map_cases() -> Iterator[RegressionCase]:
    """Yield a library query with a robot's map, and differences from an outdated plan."""
    rng = np.random.default_rng((_SEED, 1))
    plans = [styled_drawing(rng) for _ in range(_KNOWN_PLANS)]
    robot = robot_map_of(plans[0], rng)
    yield RegressionCase('library', 'library', partial(_proposed, plans, robot))
    yield RegressionCase('differences', 'differences', partial(_differing, plans[0], robot))


def _proposed(plans: Sequence[GridMap], robot: GridMap, config: FpnetConfig) -> Answer:
    """Return the plans proposed by a library, in order."""
    cuts = [segment_floorplan(plan, config.segmentation) for plan in plans]
    library = PlanLibrary.of([plan_of(f'{i}', cut, STATED_SCALE) for i, cut in enumerate(cuts)])
    found = library.find(segment_floorplan(robot, config.segmentation), STATED_SCALE)
    return {'order': [proposal.path for proposal in found]}


def _differing(plan: GridMap, robot: GridMap, config: FpnetConfig) -> Answer:
    """Return the differences of a robot's map at an offset from its place on the drawing."""
    seen, _ = prepare_submap(submap_from_grid(robot), SubmapSegmenter(), StageTimer())
    A_plan_sub = Affine2D(np.eye(2), np.array(_MOVED_M))
    found = find_differences(prepare_plan(plan, config), seen, A_plan_sub)
    return {'pieces': [[piece.kind.value, round(piece.confidence, 1)] for piece in found.pieces]}


def _rooms_of(found: Segmentation, values: list[int]) -> Answer:
    """Return rooms and doors in the benchmark's format, and further values to compare."""
    areas = sorted((round(room.area_m2, 2) for room in found.rooms), reverse=True)
    return {
        'input': values, 'rooms': len(found.rooms), 'doors': len(found.doors), 'areas_m2': areas
    }  # fmt: skip
