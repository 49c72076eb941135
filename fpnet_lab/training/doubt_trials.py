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
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.choosing import Found
from fpnet_core.drawings.looking import Rival, look_at
from fpnet_core.drawings.room_figures import ROOM_FIGURES, best_overlap, room_figures
from fpnet_core.drawings.sheet_figures import WHOLE_FIGURES, whole_figures
from fpnet_core.errors import FpnetError
from fpnet_core.io.arrays import read_arrays, write_arrays
from fpnet_core.segmentation.agreement import SAME_ROOM_IOU
from fpnet_lab.evaluation.drawings import compared
from fpnet_lab.pool import each_done
from fpnet_lab.sim.sheets import Sheet, SheetKind, draw_sheet
from fpnet_lab.training.sheets_read import read_from_file

Array = NDArray[np.float64]

FIRST_SEED = 4000
"""
Numerical: of the sheets to learn from: seeds of the tune half that the benchmark does not reach.
"""

_COMPARED_CELLS = 1200  # numerical: a side of the page: a room has hundreds of them
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


@dataclass(frozen=True)
class _Task:
    path: Path
    kind: SheetKind
    seed: int
    config: SegmentationConfig


def gather_trials(
    folder: Path,
    seeds: Sequence[int],
    config: SegmentationConfig,
    workers: int = 1,
    on_sheet: Callable[[float], None] = lambda _: None,
) -> list[ReadingTrial]:
    """Return the trials of all kinds of sheets; those that ``folder`` has not are made first."""
    tasks = [
        _Task(folder / f'{kind.value}-{seed}.npz', kind, seed, config)
        for seed in seeds
        for kind in SheetKind
    ]
    missing = [task for task in tasks if not task.path.exists()]
    on_sheet(float(len(tasks) - len(missing)))
    for _ in each_done(_make, missing, workers):
        on_sheet(1.0)
    return [trial for task in tasks for trial in read_trials(task.path)]


def _make(task: _Task) -> None:
    sheet = draw_sheet(task.seed, task.kind)
    write_trials(task.path, list(sheet_trials(sheet, task.config)))


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
        look = look_at(
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
        truth = compared(sheet, reading.segmentation, H, _COMPARED_CELLS)
        right = best_overlap(truth.found, truth.true, len(rooms)) > SAME_ROOM_IOU
        yield ReadingTrial(
            sheet.kind.value, sheet.seed, is_chosen, truth.f1, rooms, right, whole_figures(look)
        )


def write_trials(path: Path, trials: Sequence[ReadingTrial]) -> None:
    """Write the trials of one sheet."""
    no_rooms, none = np.zeros((0, len(ROOM_FIGURES))), np.zeros((0, len(WHOLE_FIGURES)))
    arrays = {
        'names': np.array([f'{trial.kind}-{trial.seed}' for trial in trials], dtype=np.str_),
        'chosen': np.array([trial.is_chosen for trial in trials], dtype=np.bool_),
        'f1': np.array([trial.f1 for trial in trials], dtype=np.float64),
        'counts': np.array([len(trial.right) for trial in trials], dtype=np.int64),
        'rooms': np.concatenate([no_rooms, *(trial.rooms for trial in trials)]),
        'right': np.concatenate([np.zeros(0, np.bool_), *(trial.right for trial in trials)]),
        'whole': np.concatenate([none, *(trial.whole[None] for trial in trials)]),
    }
    write_arrays(path, arrays)


def read_trials(path: Path) -> list[ReadingTrial]:
    """
    Return the trials of one sheet.

    Raises
    ------
    FpnetError
        If the file is damaged or of other figures.
    """
    try:
        values = read_arrays(path)
    except (OSError, ValueError) as error:
        raise FpnetError(f'{path} is damaged ({error}); remove it, and run again') from None
    widths = values['rooms'].shape[1], values['whole'].shape[1]
    if widths != (len(ROOM_FIGURES), len(WHOLE_FIGURES)):
        raise FpnetError(f'{path} is of other figures; gather into another folder')
    ends = np.cumsum([0, *values['counts']])
    found = []
    for k, name in enumerate(values['names'].tolist()):
        kind, seed = name.split('-')
        rows = slice(ends[k], ends[k + 1])
        found.append(
            ReadingTrial(
                kind,
                int(seed),
                bool(values['chosen'][k]),
                float(values['f1'][k]),
                values['rooms'][rows],
                values['right'][rows],
                values['whole'][k],
            )
        )
    return found
