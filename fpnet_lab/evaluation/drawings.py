# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How well drawings of unknown scale are read: generated sheets of five kinds.

A sheet is read from a file as a user would read it. It is *right* where the rooms agree with the
truth (F1 of rooms with intersection over union above one half of at least :data:`GOOD_F1`) and
the scale is within :data:`SCALE_TOLERANCE` or not called sure. It is *marked* where the reader
refuses it or doubts its own reading. All shares are in [0, 1].
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet.accuracy import quantile
from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.types import Reading
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.raster.pixels import growth_at, map_points
from fpnet_core.raster.rays import values_at
from fpnet_core.segmentation import segment_floorplan, segment_unknown_scale
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import UNKNOWN, GridMap, Segmentation
from fpnet_lab.metrics import mean, share
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.population.floors import room_labels
from fpnet_lab.sim.sheets import Sheet, SheetKind, draw_sheet
from fpnet_lab.sim.sheets.files import write_picture, write_vector

Reader = Callable[[Path], Reading]

GOOD_F1 = 0.85
SCALE_TOLERANCE = 0.1
"""What counts as read right; both are the aims' own. Chosen."""

FIRST_SEEDS = {'tune': 0, 'report': 1_000_000}
"""Numerical: of each half: readers are tuned on the one and reported on the other."""

PICTURE = 'picture'
"""A picture is a PNG, of scans and phone pictures a JPEG."""

_CELL_M = 0.05
_MOST_CELLS = 2500
"""
Numerical: rooms are compared on cells of so many metres, on larger sheets on so many cells a side.
"""


@dataclass(frozen=True)
class SheetResult:
    """
    How one drawing was read.

    Parameters
    ----------
    kind, name : which
    f1 : of rooms, 0 where it was refused
    clean_f1 : of rooms on the storey's clean floorplan of true scale: what no reader can mend
    refusal : the reader's error, empty where it read something
    doubts : the reader's own
    ratio : of the read scale over the true one; None where it was refused
    low, high : what the stated interval allows ``ratio`` to be off, both 1 for the read scale
    is_known : the scale was not estimated
    seconds : of processor time for reading, without cutting into rooms
    """

    kind: str
    name: str
    f1: float = 0.0
    clean_f1: float | None = None
    refusal: str = ''
    doubts: tuple[str, ...] = ()
    ratio: float | None = None
    low: float = 1.0
    high: float = 1.0
    is_known: bool = False
    seconds: float = 0.0

    @classmethod
    def of(cls, kind: str, name: str, reading: Reading, ratio: float) -> SheetResult:
        """Return what a reading says of itself; rooms and seconds are for the caller to add."""
        scale = reading.scale
        return cls(
            kind,
            name,
            doubts=reading.doubts,
            ratio=ratio,
            low=scale.low_m / scale.resolution_m,
            high=scale.high_m / scale.resolution_m,
            is_known=scale.is_known,
        )

    @property
    def caption(self) -> str:
        """What happened in two lines."""
        ratio = '-' if self.ratio is None else f'{self.ratio:.2f}'
        said = self.refusal or '; '.join(self.doubts) or 'no doubts'
        return f'{self.name}: F1 {self.f1:.2f}, scale times {ratio}\n{said}'

    @property
    def is_marked(self) -> bool:
        """Tell whether a user was warned."""
        return bool(self.refusal or self.doubts)

    @property
    def is_sure(self) -> bool:
        """Tell whether the scale is called sure: known, or an interval within the tolerance."""
        is_narrow = self.low >= 1.0 - SCALE_TOLERANCE and self.high <= 1.0 + SCALE_TOLERANCE
        return self.ratio is not None and (self.is_known or is_narrow)

    @property
    def is_close(self) -> bool:
        """Tell whether the scale is within the tolerance."""
        return self.ratio is not None and abs(self.ratio - 1.0) <= SCALE_TOLERANCE

    @property
    def is_held(self) -> bool:
        """Tell whether the truth lies in the scale's interval."""
        return self.ratio is not None and self.low <= 1.0 / self.ratio <= self.high

    @property
    def is_right(self) -> bool:
        """Tell whether rooms and scale are right."""
        return self.f1 >= GOOD_F1 and (self.is_close or not self.is_sure)


@dataclass(frozen=True, eq=False)
class RoomComparison:
    """
    Rooms read and true rooms on one raster.

    ``grid`` says where its cells lie on the page [m]; ``found (H, W)`` and ``true (H, W)`` hold
    labels, 0 where there is no room.
    """

    grid: GridMap
    found: NDArray[np.int32]
    true: NDArray[np.int32]
    f1: float


OnRead = Callable[[Sheet, SheetResult, RoomComparison | None], None]


def _ignore(_sheet: Sheet, _result: SheetResult, _rooms: RoomComparison | None) -> None:
    """Do nothing with what was read."""


def seeds_of(half: str, count: int) -> range:
    """Return the seeds of the first ``count`` sheets of a kind in a half."""
    first = FIRST_SEEDS[half]
    return range(first, first + count)


def bench_sheets(
    read: Reader,
    folder: Path,
    kinds: Sequence[SheetKind],
    seeds: Iterable[int],
    config: SegmentationConfig,
    file_format: str = PICTURE,
    on_read: OnRead = _ignore,
) -> list[SheetResult]:
    """
    Draw sheets, read each from a file and compare the rooms with the truth.

    Parameters
    ----------
    read : from a file to a reading; raises FpnetError where it refuses
    folder : where the files are written; each is deleted again
    kinds, seeds : of the sheets, every combination
    config : of the segmentation
    file_format : :data:`PICTURE`, ``pdf``, ``svg`` or ``dxf``
    on_read : is told of each sheet as it is read
    """
    results = []
    for seed in seeds:
        for kind in kinds:
            sheet = draw_sheet(seed, kind)
            result, rooms = read_sheet(read, sheet, folder, config, file_format)
            results.append(result)
            on_read(sheet, result, rooms)
    return results


def read_sheet(
    read: Reader,
    sheet: Sheet,
    folder: Path,
    config: SegmentationConfig,
    file_format: str = PICTURE,
) -> tuple[SheetResult, RoomComparison | None]:
    """Read one sheet from a file in ``folder``; the comparison is None where it was refused."""
    name = f'{sheet.kind.value}-{sheet.seed}'
    clean_f1 = _clean_f1(sheet, config)
    path, H_file_page = written(sheet, folder / name, file_format)
    started = processor_s()
    try:
        reading = read(path)
    except FpnetError as error:
        seconds = processor_s() - started
        refused = SheetResult(sheet.kind.value, name, clean_f1=clean_f1, refusal=str(error))
        return replace(refused, seconds=seconds), None
    finally:
        path.unlink()
    seconds = processor_s() - started
    H_plan_page = plan_from_file(reading) @ H_file_page
    rooms = compared(sheet, segmented(reading, config), H_plan_page)
    middle = np.mean([storey.on_page.extent.mean(axis=0) for storey in sheet.storeys], axis=0)
    ratio = growth_at(H_plan_page, middle)
    result = SheetResult.of(sheet.kind.value, name, reading, ratio)
    return replace(result, f1=rooms.f1, clean_f1=clean_f1, seconds=seconds), rooms


def processor_s() -> float:
    """Return the processor time of this process and its finished children [s]."""
    return sum(os.times()[:4])


def _clean_f1(sheet: Sheet, config: SegmentationConfig) -> float:
    """Return the best F1 of a storey's rooms on its clean floorplan."""
    scores = []
    for storey in sheet.storeys:
        grid = render_plan(storey.plan, _CELL_M)
        found = segment_floorplan(grid, config)
        scores.append(room_agreement(found.labels, room_labels(storey.plan, grid)).f1)
    return max(scores)


def written(sheet: Sheet, stem: Path, file_format: str) -> tuple[Path, NDArray[np.float64]]:
    """Write a sheet and return its file and the map (3, 3) from page metres to its units."""
    if file_format == PICTURE:
        path = stem.with_suffix('.jpg' if sheet.is_photo else '.png')
        return path, write_picture(sheet, path) @ sheet.H_image_page
    path = stem.with_suffix(f'.{file_format}')
    return path, np.array(write_vector(sheet, path)['A_file_page'])


def plan_from_file(reading: Reading) -> NDArray[np.float64]:
    """Return the homography (3, 3) from a file's own pixels or units to metres of the reading."""
    A_pixel_file = np.vstack([reading.drawing.A_pixel_image, [0.0, 0.0, 1.0]])
    return np.asarray(reading.H_plan_image @ A_pixel_file)


def segmented(reading: Reading, config: SegmentationConfig) -> Segmentation:
    """Cut a reading into rooms as the localizer does, by its scale or by its doors."""
    if reading.scale.is_known:
        return reading.segmented(config)
    return segment_unknown_scale(reading.grid, config)[0]


def compared(
    sheet: Sheet,
    found: Segmentation,
    H_plan_page: NDArray[np.float64],
    most_cells: int = _MOST_CELLS,
) -> RoomComparison:
    """
    Compare rooms on the whole page with the truth, or with that of the storey that fits best.

    Of two storeys on a sheet a reader may read one or both. ``most_cells`` are compared a side.
    """
    width, height = sheet.artwork.size_m
    cell_m = max(_CELL_M, max(width, height) / most_cells)
    shape = (int(np.ceil(height / cell_m)), int(np.ceil(width / cell_m)))
    grid = GridMap(np.full(shape, UNKNOWN, np.int8), cell_m, SE2.identity(), 'page')
    labels = labels_at(found.grid, found.labels, H_plan_page, grid)
    each = [room_labels(storey.on_page, grid) for storey in sheet.storeys]
    candidates = [*each]
    if len(each) > 1:
        candidates.append(np.where(each[0] > 0, each[0], _shifted(each[1], int(each[0].max()))))
    scores = [room_agreement(labels, true).f1 for true in candidates]
    best = int(np.argmax(scores))
    return RoomComparison(grid, labels, candidates[best], scores[best])


def _shifted(labels: NDArray[np.int32], by: int) -> NDArray[np.int32]:
    return np.asarray(np.where(labels > 0, labels + by, 0), np.int32)


def labels_at(
    source: GridMap,
    values: NDArray[np.int32],
    H_source_grid: NDArray[np.float64],
    grid: GridMap,
) -> NDArray[np.int32]:
    """Return labels ``values (H', W')`` of a raster at the cells (H, W) of another, else 0."""
    rows, cols = grid.shape
    xy = grid.rc_to_xy(np.moveaxis(np.indices((rows, cols)), 0, 2))
    return values_at(values, source.xy_to_rc(map_points(H_source_grid, xy)), 0)


def kind_figures(results: Sequence[SheetResult]) -> dict[str, Any]:
    """
    Return how many of the sheets are right, and how marks and mistakes go together.

    ``wrong_marked`` is the share of wrong ones that are marked, ``good_marked`` that of right
    ones; both are None where there are none. ``clean_right`` is the share of storeys whose rooms
    are found on a clean floorplan: a reader that reads everything has as many.
    """
    right = [result for result in results if result.is_right]
    wrong = [result for result in results if not result.is_right]
    seconds = [result.seconds for result in results]
    return {
        'sheets': len(results),
        'right': share(result.is_right for result in results),
        'wrong_marked': share(result.is_marked for result in wrong),
        'good_marked': share(result.is_marked for result in right),
        'clean_right': share((result.clean_f1 or 0.0) >= GOOD_F1 for result in results),
        'rooms_right': share(result.f1 >= GOOD_F1 for result in results),
        'f1_mean': mean(result.f1 for result in results),
        'refused': sum(bool(result.refusal) for result in results),
        'seconds_p50': quantile(seconds, 0.5),
        'seconds_p95': quantile(seconds, 0.95),
        'wrong': [_as_json(result) for result in wrong],
    }


def scale_figures(results: Sequence[SheetResult]) -> dict[str, Any]:
    """
    Return how good the scales are of readings that nobody doubts.

    ``sure_and_wrong`` is the share of scales called sure that are off by more than the
    tolerance, None where none is called sure; ``interval_holds`` is of estimated ones.
    """
    read = [result for result in results if result.ratio is not None and not result.is_marked]
    sure = [result for result in read if result.is_sure]
    return {
        'sheets': len(read),
        'within_10': share(result.is_close for result in read),
        'interval_holds': share(result.is_held for result in read if not result.is_known),
        'sure': len(sure),
        'sure_and_wrong': share(not result.is_close for result in sure),
        'median_width': float(np.median([r.high / r.low for r in read])) if read else None,
    }


def _as_json(result: SheetResult) -> dict[str, Any]:
    """Return what is to be known of a sheet that was read wrongly."""
    return {
        'name': result.name,
        'f1': round(result.f1, 3),
        'clean_f1': None if result.clean_f1 is None else round(result.clean_f1, 3),
        'scale_ratio': None if result.ratio is None else round(result.ratio, 3),
        'interval': [round(result.low, 3), round(result.high, 3)],
        'refusal': result.refusal,
        'doubts': list(result.doubts),
    }
