# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Localization in a generated building on its own sheet, for each sheet kind and file format."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.scaling import with_scale_of
from fpnet_core.errors import MapFormatError
from fpnet_core.localizer import create_localizer
from fpnet_core.raster.pixels import map_points
from fpnet_lab.evaluation.drawings import PICTURE, plan_from_file, written
from fpnet_lab.evaluation.first_claims import FirstClaim, first_claim
from fpnet_lab.sim.drives.recording import Recording, RecordingOptions, make_recording
from fpnet_lab.sim.lidars.sensors import SENSORS
from fpnet_lab.sim.sheets import SheetKind, draw_sheet

SHEETS = (
    (SheetKind.CLEAN, PICTURE), (SheetKind.OFFICE, 'dxf'), (SheetKind.OFFICE, 'pdf'),
    (SheetKind.BROCHURE, PICTURE), (SheetKind.BROCHURE, 'svg'),
    (SheetKind.SCAN, PICTURE), (SheetKind.PHONE, PICTURE),
)  # fmt: skip
"""Kinds and file formats; pictures are PNG, or JPEG for scans and phone pictures."""

_SENSOR = 'planar'  # fastest sensor to ray-cast


@dataclass(frozen=True)
class SheetDrive:
    """
    Result of one recording on one sheet.

    ``found_after_m`` is the path length to the first accepted pose, None without one; ``error_m``
    is its error in true metres. ``doubts`` are the parser's warnings, or its error alone.
    """

    seed: int
    sheet: str
    found_after_m: float | None
    error_m: float | None
    doubts: tuple[str, ...] = ()


def drives_on_sheets(seed: int, folder: Path, config: FpnetConfig) -> list[SheetDrive]:
    """
    Localize one recording on its clean floorplan (``grid``) and on each of :data:`SHEETS`.

    The sheets are written to ``folder`` and parsed from there.
    """
    recording = make_recording(seed, RecordingOptions(lidar=SENSORS[_SENSOR]), threads=1)
    localizer = create_localizer(config)
    localizer.set_plan(recording.floorplan)
    claim = first_claim(recording, localizer)
    drives = [_drive(seed, 'grid', claim, recording.A_plan_building.matrix)]
    for kind, file_format in SHEETS:
        drives.append(_on_sheet(recording, kind, file_format, folder, config))
    return drives


def _on_sheet(
    recording: Recording, kind: SheetKind, file_format: str, folder: Path, config: FpnetConfig
) -> SheetDrive:
    sheet = draw_sheet(recording.seed, kind, recording.building.plan)
    name = f'{kind.value} {file_format}'
    path, H_file_page = written(sheet, folder / f'{kind.value}-{recording.seed}', file_format)
    try:
        reading = read_plan(path, config=config)
        localizer = create_localizer(with_scale_of(reading, config))
        localizer.set_plan(reading.grid, reading.estimate)
    except MapFormatError as error:
        return SheetDrive(recording.seed, name, None, None, (str(error),))
    H_page_building = sheet.storeys[0].T_page_building.matrix
    H_plan_building = plan_from_file(reading) @ H_file_page @ H_page_building
    claim = first_claim(recording, localizer)
    return _drive(recording.seed, name, claim, H_plan_building, reading.doubts)


def _drive(
    seed: int,
    sheet: str,
    claim: FirstClaim,
    H_plan_building: NDArray[np.float64],
    doubts: tuple[str, ...] = (),
) -> SheetDrive:
    error_m = None
    if claim.on_plan is not None and claim.in_building is not None:
        back = np.asarray(np.linalg.inv(H_plan_building), dtype=np.float64)
        found = map_points(back, claim.on_plan)
        error_m = float(np.linalg.norm(found - claim.in_building))
    return SheetDrive(seed, sheet, claim.found_after_m, error_m, doubts)
