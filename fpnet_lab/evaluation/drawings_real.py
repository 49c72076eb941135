# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parsing of hand-labelled real plans with walls redrawn in grey, and as white on black."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.errors import FpnetError
from fpnet_core.raster.pixels import growth_at
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.evaluation.drawings import (
    Reader,
    SheetResult,
    labels_at,
    plan_from_file,
    processor_s,
    scale_figures,
    segmented,
)
from fpnet_lab.metrics import share
from fpnet_lab.sim.pairs.presets import SPLITS
from fpnet_lab.sim.population.floors import CELL_M, read_image, read_labels

TONES: dict[str, int | None] = {
    '0': 0,
    '30': 30,
    '60': 60,
    '100': 100,
    '140': 140,
    'inverted': None,
}
"""Grey levels of walls; None is white on black. Chosen."""

SAME_F1 = 0.95
"""Smallest agreement at which rooms count as those parsed from black walls. Chosen."""


@dataclass(frozen=True, eq=False)
class _Found:
    """Labels ``rooms (H, W)`` and mask ``walls (H, W)``."""

    rooms: NDArray[np.int32]
    walls: NDArray[np.bool_]


def plan_names(half: str) -> tuple[str, ...]:
    """Return the plans of a split: ``report`` includes the plans of ``tune``."""
    return SPLITS['tune'] if half == 'tune' else (*SPLITS['tune'], *SPLITS['report'])


def redrawn(image: NDArray[np.uint8], tone: int | None) -> NDArray[np.uint8]:
    """Return a plan (H, W), black walls on light paper, with walls in another grey level."""
    if tone is None:
        return np.asarray(255 - image, np.uint8)
    return np.maximum(image, np.uint8(tone))


def bench_plans(
    read: Reader,
    data: Path,
    folder: Path,
    half: str,
    config: SegmentationConfig,
    on_done: Callable[[float], None] = lambda _: None,
) -> dict[str, Any]:
    """
    Parse real plans in every grey level without scale; compare with labels and black walls.

    Parameters
    ----------
    read : parses a file
    data : folder that holds ``bormann``
    folder : for the parsed files
    half : ``tune`` or ``report``
    config : of the segmentation
    on_done : called with 1.0 after every plan and grey level

    Returns
    -------
    dict for JSON: ``tones`` by name with ``as_black`` (share of plans with the rooms of black
    walls), ``walls_as_black`` (share of the cells of black walls that are walls), ``f1_mean``
    against hand-drawn labels and ``marked``, and ``scale``
    """
    names = plan_names(half)
    results: dict[str, list[SheetResult]] = {tone: [] for tone in TONES}
    same: dict[str, list[tuple[bool, float]]] = {tone: [] for tone in TONES}
    for name in names:
        image = read_image(data / 'bormann' / 'floorplan' / f'{name}.png')
        truth = read_labels(data / 'bormann' / 'room_labels' / f'{name}.png')
        black: _Found | None = None
        for label, tone in TONES.items():
            path = folder / f'{name}-{label}.png'
            cv2.imwrite(str(path), redrawn(image, tone))
            result, found = _read(read, path, truth, config, f'{name}-{label}')
            path.unlink()
            results[label].append(result)
            black = found if tone == 0 else black
            same[label].append(_compare(found, black))
            on_done(1.0)
    return {
        'plans': len(names),
        'tones': {tone: _figures(results[tone], same[tone]) for tone in TONES},
        'scale': scale_figures(results['0']),
    }


def _read(
    read: Reader,
    path: Path,
    truth: NDArray[np.int32],
    config: SegmentationConfig,
    name: str,
) -> tuple[SheetResult, _Found | None]:
    """Return the result and the rooms and walls on the plan's pixels, row 0 at the bottom."""
    started = processor_s()
    try:
        reading = read(path)
    except FpnetError as error:
        return SheetResult('real', name, refusal=str(error)), None
    seconds = processor_s() - started
    rows, cols = truth.shape
    # From metres of the labelled map, row 0 at the bottom, to pixels of its image, row 0 at the
    # top.
    per_m = 1.0 / CELL_M
    H_image_map = np.array([[per_m, 0.0, -0.5], [0.0, -per_m, rows - 0.5], [0.0, 0.0, 1.0]])
    H_plan_map = plan_from_file(reading) @ H_image_map
    grid = GridMap(np.full(truth.shape, UNKNOWN, np.int8), CELL_M)
    segmentation = segmented(reading, config)
    rooms = labels_at(segmentation.grid, segmentation.labels, H_plan_map, grid)
    is_wall = (reading.grid.cells == OCCUPIED).astype(np.int32)
    walls = labels_at(reading.grid, is_wall, H_plan_map, grid)
    middle = np.array([cols, rows]) * CELL_M / 2.0
    result = SheetResult.of('real', name, reading, growth_at(H_plan_map, middle))
    f1 = room_agreement(rooms, truth).f1
    return replace(result, f1=f1, seconds=seconds), _Found(rooms, walls > 0)


def _compare(found: _Found | None, black: _Found | None) -> tuple[bool, float]:
    """Return whether the rooms equal those of black walls, and the share of these walls found."""
    if found is None or black is None:
        return False, 0.0
    is_same = room_agreement(found.rooms, black.rooms).f1 >= SAME_F1
    walls = found.walls[black.walls]
    return is_same, float(walls.mean()) if walls.size else 0.0


def _figures(results: Sequence[SheetResult], same: Sequence[tuple[bool, float]]) -> dict[str, Any]:
    return {
        'as_black': share(rooms for rooms, _ in same),
        'walls_as_black': float(np.mean([walls for _, walls in same])),
        'f1_mean': float(np.mean([result.f1 for result in results])),
        'marked': share(result.is_marked for result in results),
    }
