# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Parsing of drawings of unknown scale: generated sheets of five kinds.

Sheets are parsed from files, as users' are. A sheet is *right* if the rooms agree with the truth
(F1 of rooms with intersection over union above one half of at least :data:`GOOD_F1`) and the scale
is within :data:`SCALE_TOLERANCE` or not called sure. It is *marked* if the parser rejects it or
returns warnings. All shares are in [0, 1].
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
"""Limits of a right sheet, equal to those of the aims. Chosen."""

FIRST_SEEDS = {'tune': 0, 'report': 1_000_000}
"""Numerical: first seeds of the development split and of the test split."""

PICTURE = 'picture'
"""File format of a picture: JPEG for scans and phone pictures, otherwise PNG."""

_CELL_M = 0.05
_MOST_CELLS = 2500
"""
Numerical: cell size [m] and most cells per side of the raster on which rooms are compared.
"""


@dataclass(frozen=True)
class SheetResult:
    """
    Parser result of one drawing.

    Parameters
    ----------
    kind, name : of the drawing
    f1 : room F1, 0 if the drawing was rejected
    clean_f1 : room F1 on the storey's clean floorplan of true scale, an upper limit for parsers
    refusal : the parser's error, empty without one
    doubts : the parser's warnings
    ratio : parsed over true scale; None if the drawing was rejected
    low, high : limits of the stated scale interval over the parsed scale
    is_known : whether the scale was stated, not estimated
    seconds : processor time for parsing, without segmentation into rooms
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
        """Return the result of a parse; the caller adds the rooms' F1 and the seconds."""
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
        """Result in two lines."""
        ratio = '-' if self.ratio is None else f'{self.ratio:.2f}'
        said = self.refusal or '; '.join(self.doubts) or 'no warnings'
        return f'{self.name}: F1 {self.f1:.2f}, scale times {ratio}\n{said}'

    @property
    def is_marked(self) -> bool:
        """Return whether the parser warned the user."""
        return bool(self.refusal or self.doubts)

    @property
    def is_sure(self) -> bool:
        """Return whether the scale is called sure: known, or an interval within the tolerance."""
        is_narrow = self.low >= 1.0 - SCALE_TOLERANCE and self.high <= 1.0 + SCALE_TOLERANCE
        return self.ratio is not None and (self.is_known or is_narrow)

    @property
    def is_close(self) -> bool:
        """Return whether the scale is within the tolerance."""
        return self.ratio is not None and abs(self.ratio - 1.0) <= SCALE_TOLERANCE

    @property
    def is_held(self) -> bool:
        """Return whether the stated interval contains the true scale."""
        return self.ratio is not None and self.low <= 1.0 / self.ratio <= self.high

    @property
    def is_right(self) -> bool:
        """Return whether rooms and scale are right."""
        return self.f1 >= GOOD_F1 and (self.is_close or not self.is_sure)


@dataclass(frozen=True, eq=False)
class RoomComparison:
    """
    Parsed and true rooms on one raster.

    ``grid`` gives the position of its cells on the page [m]; ``found (H, W)`` and ``true (H, W)``
    hold labels, 0 outside of rooms.
    """

    grid: GridMap
    found: NDArray[np.int32]
    true: NDArray[np.int32]
    f1: float


OnRead = Callable[[Sheet, SheetResult, RoomComparison | None], None]


def _ignore(_sheet: Sheet, _result: SheetResult, _rooms: RoomComparison | None) -> None:
    """Ignore the result of a sheet."""


def seeds_of(half: str, count: int) -> range:
    """Return the seeds of the first ``count`` sheets of a split."""
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
    Generate sheets, parse each from a file and compare the rooms with the truth.

    Parameters
    ----------
    read : parses a file; raises FpnetError if it rejects it
    folder : for the files; each is deleted after parsing
    kinds, seeds : of the sheets, in every combination
    config : of the segmentation
    file_format : :data:`PICTURE`, ``pdf``, ``svg`` or ``dxf``
    on_read : called with each sheet and its result
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
    """Parse one sheet from a file in ``folder``; the comparison is None if it was rejected."""
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
    """Return the best F1 of the storeys' rooms on their clean floorplans."""
    scores = []
    for storey in sheet.storeys:
        grid = render_plan(storey.plan, _CELL_M)
        found = segment_floorplan(grid, config)
        scores.append(room_agreement(found.labels, room_labels(storey.plan, grid)).f1)
    return max(scores)


def written(sheet: Sheet, stem: Path, file_format: str) -> tuple[Path, NDArray[np.float64]]:
    """Write a sheet; return its file and the map (3, 3) from page metres to its units."""
    if file_format == PICTURE:
        path = stem.with_suffix('.jpg' if sheet.is_photo else '.png')
        return path, write_picture(sheet, path) @ sheet.H_image_page
    path = stem.with_suffix(f'.{file_format}')
    return path, np.array(write_vector(sheet, path)['A_file_page'])


def plan_from_file(reading: Reading) -> NDArray[np.float64]:
    """Return the homography (3, 3) from a file's pixels or units to metres of its parse."""
    A_pixel_file = np.vstack([reading.drawing.A_pixel_image, [0.0, 0.0, 1.0]])
    return np.asarray(reading.H_plan_image @ A_pixel_file)


def segmented(reading: Reading, config: SegmentationConfig) -> Segmentation:
    """Segment a parse into rooms as the localizer does, by its known or estimated scale."""
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
    Compare rooms on the whole page with the truth of the storeys that fit best.

    With two storeys, a parser may parse one or both. The raster has up to ``most_cells`` per side.
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
    """Return labels ``values (H', W')`` of one raster at the cells (H, W) of another, else 0."""
    rows, cols = grid.shape
    xy = grid.rc_to_xy(np.moveaxis(np.indices((rows, cols)), 0, 2))
    return values_at(values, source.xy_to_rc(map_points(H_source_grid, xy)), 0)


def kind_figures(results: Sequence[SheetResult]) -> dict[str, Any]:
    """
    Return the share of right sheets, and how warnings and mistakes coincide.

    ``wrong_marked`` is the share of wrong sheets with warnings, ``good_marked`` that of right
    ones; each is None without such sheets. ``clean_right`` is the share of storeys with right
    rooms on the clean floorplan: the upper limit for a perfect parser.
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
    Return the accuracy of the scales of parses without warnings.

    ``sure_and_wrong`` is the share of sure scales that are off by more than the tolerance, None
    without sure scales; ``interval_holds`` covers estimated scales only.
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
    """Return the report's entry for a wrong sheet."""
    return {
        'name': result.name,
        'f1': round(result.f1, 3),
        'clean_f1': None if result.clean_f1 is None else round(result.clean_f1, 3),
        'scale_ratio': None if result.ratio is None else round(result.ratio, 3),
        'interval': [round(result.low, 3), round(result.high, 3)],
        'refusal': result.refusal,
        'doubts': list(result.doubts),
    }
