# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Readings of generated sheets whose truth is known: what there was to see, and what was wrong.

Of each sheet the reading that was chosen is a trial, and so are others that nearly were: they go
wrong in the same ways, and more often.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.found import Found
from fpnet_core.drawings.pictures.looking import Rival, view_reading
from fpnet_core.drawings.pictures.room_figures import ROOM_FIGURES, best_overlap, room_figures
from fpnet_core.drawings.pictures.sheet_figures import WHOLE_FIGURES, whole_figures
from fpnet_core.segmentation.agreement import SAME_ROOM_IOU
from fpnet_lab.evaluation.drawings import compared
from fpnet_lab.kept import make_once
from fpnet_lab.sim.sheets import STANDARD_KINDS, Sheet, SheetKind, draw_sheet
from fpnet_lab.training.sheets_read import COMPARED_CELLS, read_from_file

Array = NDArray[np.float64]

FIRST_SEED = 4000
"""
Numerical: of the sheets to learn from: seeds of the tune half that the benchmark does not reach.
"""

# Chosen, not measured:
_MOST_OTHERS, _LEAST_PLAUSIBLE = 2, 0.1  # readings of a sheet beside the chosen one


@dataclass(frozen=True, eq=False)
class ReadingTrial:
    """
    One reading of a sheet.

    ``rooms (R, D)`` are the figures of its rooms, which are ``right (R,)``, ``whole (F,)`` its
    own; ``f1`` is that of its rooms against the truth. Sheets of one ``seed`` share a building.
    """

    kind: str
    seed: int
    is_chosen: bool
    f1: float
    rooms: Array
    right: NDArray[np.bool_]
    whole: Array


def gather_trials(
    folder: Path,
    seeds: Sequence[int],
    config: SegmentationConfig,
    workers: int = 1,
    on_sheet: Callable[[float], None] = lambda _: None,
) -> list[ReadingTrial]:
    """Return the trials of all kinds of sheets; what ``folder`` holds is taken over."""
    tasks = {f'{kind.value}-{seed}': (seed, kind) for seed, kind in product(seeds, STANDARD_KINDS)}
    made = make_once(
        folder,
        tuple[ReadingTrial, ...],
        tasks,
        partial(_trials, config),
        workers,
        on_sheet,
        (*ROOM_FIGURES, *WHOLE_FIGURES),
    )
    return [trial for trials in made for trial in trials]


def _trials(config: SegmentationConfig, drawn: tuple[int, SheetKind]) -> tuple[ReadingTrial, ...]:
    return tuple(sheet_trials(draw_sheet(*drawn), config))


def sheet_trials(sheet: Sheet, config: SegmentationConfig) -> Iterator[ReadingTrial]:
    """Read a sheet from a file as a user's and yield its readings; none where it is refused."""
    read = read_from_file(sheet, config)
    if read is not None:
        yield from trials_of(sheet, read.pixels, read.H_pixel_page, read.found, config)


def trials_of(
    sheet: Sheet,
    pixels: NDArray[np.uint8],
    H_pixel_page: Array,
    found: Found,
    config: SegmentationConfig,
) -> Iterator[ReadingTrial]:
    """Yield the chosen reading ``found`` of a sheet, and others that nearly were chosen."""
    chosen = Rival(found.segmentation, found.H_plan_pixel, found.probability)
    others = sorted(found.rivals, key=lambda rival: -rival.plausible)[:_MOST_OTHERS]
    for reading in (chosen, *others):
        is_chosen = reading is chosen
        if not is_chosen and reading.plausible < _LEAST_PLAUSIBLE:
            continue
        rivals = [each for each in (chosen, *found.rivals) if each is not reading]
        look = view_reading(
            pixels,
            reading.segmentation,
            reading.H_plan_pixel,
            reading.plausible,
            rivals,
            config,
            found.trust if is_chosen else None,
        )
        rooms = room_figures(look)
        H = reading.H_plan_pixel @ H_pixel_page
        truth = compared(sheet, reading.segmentation, H, COMPARED_CELLS)
        right = best_overlap(truth.found, truth.true, len(rooms)) > SAME_ROOM_IOU
        yield ReadingTrial(
            sheet.kind.value, sheet.seed, is_chosen, truth.f1, rooms, right, whole_figures(look)
        )
