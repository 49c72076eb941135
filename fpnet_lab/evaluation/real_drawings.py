# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Parsing of real drawings, against hand-labelled rooms, doors and scale.

The truth of a drawing is a JSON file (:func:`read_truth`); the drawing itself may be elsewhere, or
missing. Do not develop on the split ``held``: it is for figures only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet.exports.segmented_model import complete_model
from fpnet.plan_check.verdict import Fitness, verdict_of
from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.raster.pixels import growth_at, map_points
from fpnet_core.segmentation import told_scale
from fpnet_core.segmentation.agreement import Agreement, room_agreement
from fpnet_core.types import UNKNOWN, GridMap, Segmentation
from fpnet_lab.evaluation.drawings import (
    RoomComparison,
    SheetResult,
    labels_at,
    plan_from_file,
    processor_s,
    segmented,
)
from fpnet_lab.metrics import mean, share
from fpnet_lab.metrics.openings import place_agreement
from fpnet_lab.scores import Row
from fpnet_lab.sim.drawn.render import fill_polygons

Array = NDArray[np.float64]
OptionsReader = Callable[[Path, ReadOptions], Reading]

SPLITS = ('tune', 'held')
"""Given: development split, and test split that is not used during development."""

SILENT_F1 = 0.5
"""Chosen: a parse with a smaller room F1 and verdict "fit" is a silent failure."""

_CELLS = 1600  # numerical: cells along the longer side of the raster on which rooms are compared
_SPECK_CELLS = 100  # given: smaller rooms on that raster are specks, as in room_agreement
_DOOR_M = 0.9  # physical: a median door width, for drawings of unknown scale
_NEAR_M = 0.5  # chosen: largest distance between a true door and its match
_SOURCE = ('repository', 'commit', 'path', 'licence')


@dataclass(frozen=True, eq=False)
class TrueDrawing:
    """
    Truth of a drawing, in the units of its file as the parsers return them.

    Parameters
    ----------
    name : of the truth file, without its suffix
    file, sha256 : of the drawing
    split : one of :data:`SPLITS`
    kind : drawing style in one or two words
    source : repository, commit, path and licence
    rooms : rings (V, 2) on one storey; later rings replace earlier ones where they overlap
    doors : (D, 2, 2) ends of the openings; None if there are none or they are not labelled
    unclear : rings of ambiguous areas, for example balconies; rooms found there do not count
    metres_per_unit : the true scale; None if unknown
    scale_within : relative uncertainty of the true scale
    options : page or storey of the truth
    """

    name: str
    file: str
    sha256: str
    split: str
    kind: str
    source: dict[str, str]
    rooms: tuple[Array, ...]
    doors: Array | None
    unclear: tuple[Array, ...]
    metres_per_unit: float | None
    scale_within: float
    options: ReadOptions

    @property
    def door_reach(self) -> float:
        """Largest distance between a true door and its match, in the file's units."""
        if self.metres_per_unit is not None or self.doors is None:
            return _NEAR_M / (self.metres_per_unit or math.inf)
        widths = np.linalg.norm(self.doors[:, 1] - self.doors[:, 0], axis=1)
        return _NEAR_M / _DOOR_M * float(np.median(widths))


def read_truth(path: Path) -> TrueDrawing:
    """Read the truth of a drawing; raise FpnetError with the reason if the file is invalid."""
    try:
        return _truth(path.stem, json.loads(path.read_text()))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        what = f'there is no {error}' if isinstance(error, KeyError) else str(error)
        raise FpnetError(f'{path} is no truth of a drawing: {what}') from error


def _truth(name: str, values: dict[str, Any]) -> TrueDrawing:
    if values['split'] not in SPLITS:
        raise ValueError(f'split {values["split"]!r}; expected {" or ".join(SPLITS)}')
    rooms, doors, scale = _rings(values['rooms']), values['doors'], values['metres_per_unit']
    if not rooms:
        raise ValueError('rooms: expected at least one')
    if scale is not None and not 0.0 < scale < math.inf:
        raise ValueError(f'metres_per_unit: expected a positive number or null, got {scale}')
    return TrueDrawing(
        name=name,
        file=values['file'],
        sha256=values['sha256'],
        split=values['split'],
        kind=values['kind'],
        source={key: values['source'][key] for key in _SOURCE},
        rooms=rooms,
        doors=np.array(doors, np.float64).reshape(-1, 2, 2) if doors else None,
        unclear=_rings(values.get('unclear', [])),
        metres_per_unit=scale,
        scale_within=float(values.get('scale_within', 0.0)),
        options=ReadOptions(**values.get('options', {})),
    )


def _rings(values: Any) -> tuple[Array, ...]:
    rings = tuple(np.array(ring, np.float64) for ring in values)
    if any(ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3 for ring in rings):
        raise ValueError('expected rings of at least three corners [x, y]')
    return rings


def find_drawing(truth: TrueDrawing, folders: Iterable[Path]) -> Path | None:
    """Return a drawing's file in the folders or their ``drawings``; FpnetError for a bad hash."""
    for path in (each / part / truth.file for each in folders for part in ('', 'drawings')):
        if path.is_file():
            found = hashlib.sha256(path.read_bytes()).hexdigest()
            if found != truth.sha256:
                raise FpnetError(
                    f'{path} is not the drawing that {truth.name}.json describes: its SHA-256 '
                    f'is {found}, expected {truth.sha256}'
                )
            return path
    return None


def bench_drawing(
    read: OptionsReader, truth: TrueDrawing, path: Path, config: SegmentationConfig
) -> tuple[Row, SheetResult, RoomComparison | None, NDArray[np.uint8] | None]:
    """
    Parse a drawing and compare it with its truth.

    Returns the row of the report, the result, the rooms and the parsed pixels (H, W, 3); the last
    two are None if the parser rejects the drawing.
    """
    started = processor_s()
    try:
        reading = read(path, truth.options)
    except FpnetError as error:
        refused = SheetResult(truth.kind, truth.name, refusal=str(error))
        nothing = None if truth.doors is None else Agreement(0.0, 0.0, 0.0)
        return _row(truth, refused, Fitness.NO_FLOORPLAN, doors=nothing), refused, None, None
    seconds = processor_s() - started
    H_plan_file = plan_from_file(reading)
    found = segmented(reading, config)
    rooms = _compared(truth, found, H_plan_file)
    middle = np.concatenate(truth.rooms).mean(axis=0)
    ratio = growth_at(H_plan_file, middle) / (truth.metres_per_unit or math.nan)
    sheet = SheetResult.of(truth.kind, truth.name, reading, ratio)
    sheet = replace(sheet, f1=rooms.f1, seconds=seconds)
    told = reading.segmentation  # as `fpnet plan` computes its verdict
    fitness = verdict_of(reading, told, told=told_scale(reading.grid, told, config)).fitness
    ends = np.array([door.ends for door in complete_model(reading).doors])
    middles = map_points(np.linalg.inv(H_plan_file), ends.reshape(-1, 2, 2).mean(axis=1))
    unclear = shapely.union_all([shapely.Polygon(ring) for ring in truth.unclear])
    middles = middles[~shapely.contains_xy(unclear, middles)]
    doors = None
    if truth.doors is not None:
        doors = place_agreement(middles, truth.doors.mean(axis=1), truth.door_reach)
    row = _row(truth, sheet, fitness, _counted(rooms.found), _counted(rooms.true), doors)
    return row, sheet, rooms, reading.drawing.pixels


def _row(
    truth: TrueDrawing,
    sheet: SheetResult,
    fitness: Fitness,
    rooms_found: int = 0,
    rooms: int = 0,
    doors: Agreement | None = None,
) -> Row:
    """Return a row of the report; unknown shares are None."""
    hits = sheet.f1 * (rooms + rooms_found) / 2.0
    is_held = None
    if truth.metres_per_unit is not None and sheet.ratio is not None:
        slack = 1.0 + truth.scale_within
        is_held = sheet.low / slack <= 1.0 / sheet.ratio <= sheet.high * slack
    is_wrong = sheet.f1 < SILENT_F1 or is_held is False
    return {
        'name': truth.name,
        'split': truth.split,
        'kind': truth.kind,
        'rooms': len(truth.rooms),
        'rooms_found': rooms_found,
        'precision': hits / max(rooms_found, 1),
        'recall': hits / max(rooms, 1),
        'f1': sheet.f1,
        'doors': None if truth.doors is None else len(truth.doors),
        'door_precision': doors and doors.precision,
        'door_recall': doors and doors.recall,
        'scale_ratio': None if is_held is None else sheet.ratio,
        'interval': [sheet.low, sheet.high],
        'interval_holds': is_held,
        'verdict': fitness.value,
        'silent': fitness is Fitness.FIT and is_wrong,
        'refusal': sheet.refusal,
        'doubts': list(sheet.doubts),
        'seconds': sheet.seconds,
    }


def _counted(labels: NDArray[np.int32]) -> int:
    """Return the number of rooms in a raster of labels."""
    return int(np.count_nonzero(np.bincount(labels.ravel())[1:] > _SPECK_CELLS))


def _compared(truth: TrueDrawing, found: Segmentation, H_plan_file: Array) -> RoomComparison:
    """Paint the true and the found rooms on one raster in the file's units."""
    H_file_plan = np.linalg.inv(H_plan_file)
    corners = [*truth.rooms, *(map_points(H_file_plan, room.polygon) for room in found.rooms)]
    places = np.concatenate(corners)
    low, high = places.min(axis=0), places.max(axis=0)
    cell = float((high - low).max()) / _CELLS
    columns, rows = np.ceil((high - low) / cell).astype(int) + 1
    corner = SE2.from_xy_yaw(float(low[0]), float(low[1]), 0.0)
    grid = GridMap(np.full((rows, columns), UNKNOWN, np.int8), cell, corner, 'file')
    true = np.zeros(grid.shape, np.int32)
    for number, ring in enumerate(truth.rooms, 1):
        fill_polygons(true, [(ring - low) / cell], number)
    labels = labels_at(found.grid, found.labels, H_plan_file, grid)
    for ring in truth.unclear:
        fill_polygons(labels, [(ring - low) / cell], 0)
    return RoomComparison(grid, labels, true, room_agreement(labels, true).f1)


def real_figures(rows: Sequence[Row]) -> dict[str, Any]:
    """
    Return the figures of a split: means with equal weight for each drawing.

    Door figures cover the drawings with labelled doors, scale figures those of known scale;
    ``interval_holds`` is the share of 90 % intervals that contain the true scale.
    """
    scaled = [row for row in rows if row['interval_holds'] is not None]
    doors = [row for row in rows if row['door_recall'] is not None]
    return {
        'drawings': len(rows),
        **{key: mean(row[key] for row in rows) for key in ('precision', 'recall', 'f1')},
        'f1_half': share(row['f1'] >= SILENT_F1 for row in rows),
        'with_doors': len(doors),
        **{key: mean(row[key] for row in doors) for key in ('door_precision', 'door_recall')},
        'with_scale': len(scaled),
        'scale_off': mean(abs(math.log(row['scale_ratio'])) for row in scaled),
        'interval_holds': share(row['interval_holds'] for row in scaled),
        **{each.name.lower(): sum(r['verdict'] == each.value for r in rows) for each in Fitness},
        'silent': sum(row['silent'] for row in rows),
    }
