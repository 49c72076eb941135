# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tracks of generated buildings: exact, sketched and roughly drawn plans, and realistic sheets."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
import tempfile

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from fpnet_core.config import OdometryConfig
from fpnet_core.geometry import Affine2D
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import UNKNOWN, GridMap
from fpnet_lab.evaluation.drawings import PICTURE, written
from fpnet_lab.evaluation.localization.cases import PLAIN_FAMILIES, Distortion
from fpnet_lab.evaluation.localization.drives import kept_scans
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.localization.plans import draw_plan, draw_roughly
from fpnet_lab.evaluation.open_benchmark.protocol import PlanIs
from fpnet_lab.evaluation.open_benchmark.writing import BenchmarkBuilding, DrawnSheet, drive_inputs
from fpnet_lab.sim.drawn.storeys import Likeness, draw_storeys
from fpnet_lab.sim.drives.recording import Recording
from fpnet_lab.sim.sheets import SheetKind, draw_sheet

_SEED_STEP = 1000  # numerical: apart from each other for up to so many buildings
_FLOOR_STREAM = 41  # given: second element of the seed of another floor

SHEET_KINDS = (SheetKind.OFFICE, SheetKind.BROCHURE, SheetKind.SCAN)
"""Kinds of sheets without perspective, in turn."""


class GeneratedTrack(StrEnum):
    """How the plans of generated buildings are drawn."""

    EXACT = 'exact'
    SKETCH = 'sketch'
    ROUGH = 'rough'
    SHEETS = 'sheets'


@dataclass(frozen=True, eq=False)
class _Plan:
    """A plan, its mirror image, and the map from true metres to it."""

    own: DrawnSheet
    mirrored: DrawnSheet
    A_plan_building: Affine2D


def generated_buildings(
    track: GeneratedTrack,
    count: int,
    seed: int,
    sensor: str,
    on_building: Callable[[], None] = lambda: None,
) -> Iterator[BenchmarkBuilding]:
    """
    Generate the buildings of a track with their drives, plans and wrong plans.

    Odometry is that of KISS-ICP. The foreign plan is the next building's. ``on_building`` is
    called after each one.
    """
    first = _drive(seed, 0, sensor)
    recording, plan = first, _plan(track, first)
    for number in range(count):
        following = _drive(seed, number + 1, sensor)
        next_plan = _plan(track, following)
        elsewhere = {PlanIs.FOREIGN: next_plan.own, PlanIs.MIRRORED: plan.mirrored}
        if track is not GeneratedTrack.SHEETS:
            elsewhere[PlanIs.OTHER_FLOOR] = DrawnSheet(_other_floor(recording))
        scans = kept_scans(recording, OdometryConfig())
        truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
        yield BenchmarkBuilding(
            drive_inputs(scans), truth, plan.own, plan.A_plan_building, elsewhere
        )
        on_building()
        recording, plan = following, next_plan


def _drive(seed: int, number: int, sensor: str) -> Recording:
    family = PLAIN_FAMILIES[number % len(PLAIN_FAMILIES)]
    return drive_through(family, sensor, _SEED_STEP * (seed + 1) + number)


def _plan(track: GeneratedTrack, recording: Recording) -> _Plan:
    plan, seed = recording.building.plan, recording.seed
    if track is GeneratedTrack.SHEETS:
        return _sheet(recording)
    if track is GeneratedTrack.ROUGH:
        drawn = draw_roughly(plan, Distortion.EXACT, seed)
    else:
        drawn = draw_plan(plan, Distortion(track.value), seed)
    own, mirrored = DrawnSheet(drawn.grid), DrawnSheet(drawn.grid.mirrored())
    return _Plan(own, mirrored, drawn.A_plan_building)


def _other_floor(recording: Recording) -> GridMap:
    """Return another floor of the building: the same outline with other inner walls."""
    rng = np.random.default_rng((recording.seed, _FLOOR_STREAM))
    (storey,) = draw_storeys(recording.building.plan, (Likeness.ALIKE,), rng)
    return storey.drawn.grid


def _sheet(recording: Recording) -> _Plan:
    """Draw a realistic sheet and state its metres per pixel."""
    kind = SHEET_KINDS[recording.seed % len(SHEET_KINDS)]
    sheet = draw_sheet(recording.seed, kind, recording.building.plan)
    with tempfile.TemporaryDirectory() as folder:
        path, H_pixel_page = written(sheet, Path(folder) / 'sheet', PICTURE)
        with Image.open(path) as file:
            picture = _on_white(file)
    H_pixel_building = H_pixel_page @ sheet.storeys[0].T_page_building.matrix
    A_pixel_building = _as_affine(H_pixel_building)
    resolution_m = float(1.0 / np.sqrt(abs(np.linalg.det(A_pixel_building.linear))))
    frame = picture_frame(picture, resolution_m)
    A_plan_building = pixel_to_xy(frame) @ A_pixel_building
    own, mirrored = DrawnSheet(frame, picture), DrawnSheet(frame, ImageOps.mirror(picture))
    return _Plan(own, mirrored, A_plan_building)


def _on_white(picture: Image.Image) -> Image.Image:
    """Return a picture in colour, with white where it is transparent."""
    shown = picture.convert('RGBA')
    return Image.alpha_composite(Image.new('RGBA', shown.size, 'white'), shown).convert('RGB')


def picture_frame(picture: Image.Image, resolution_m: float) -> GridMap:
    """Return an unknown raster with the frame of a picture: origin at its lower left corner."""
    cells = np.full((picture.height, picture.width), UNKNOWN, dtype=np.int8)
    return GridMap(cells, resolution_m)


def _as_affine(H: NDArray[np.float64]) -> Affine2D:
    return Affine2D.from_matrix(H[:2] / H[2, 2])
