# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Floorplan segmentation against hand-labelled plans and robot maps.

All shares are fractions in [0, 1]. Rooms: precision and recall by Bormann's definition, F1 of
rooms with intersection over union above one half. Doors: within ``DOOR_TOLERANCE_M`` of an opening
between two hand-labelled rooms. Figures are means over maps.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import time
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.segmentation import segment_floorplan, segment_submap
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Segmentation
from fpnet_lab.metrics.openings import place_agreement, true_openings
from fpnet_lab.sim.pairs.presets import SPLITS, Split
from fpnet_lab.sim.population.floors import CELL_M, FREE_GREY, read_image, read_labels

DOOR_TOLERANCE_M = 0.75
"""Largest distance between a true door and its match. Chosen."""

METHODS: tuple[Literal['default', 'morphological', 'distance'], ...] = (
    'default',
    'morphological',
    'distance',
)

ROBOT_MAPS: dict[Split, dict[str, str]] = {
    'tune': {
        'lab_a': 'lab_a_scan',
        'lab_c': 'lab_c_scan',
        'lab_c_scan_furnitures_trashbins': 'lab_c_scan',
        'freiburg_building52': 'Freiburg52_scan',
        'lab_ipa_furnitures': 'lab_ipa',
    },
    'report': {
        'Freiburg101_scan': 'Freiburg101_scan',
        'Freiburg101_scan_furnitures_trashbins': 'Freiburg101_scan',
        'Freiburg79_scan_furnitures_trashbins': 'Freiburg79_scan',
        'freiburg_building101': 'Freiburg101_scan',
        'freiburg_building79': 'Freiburg79_scan',
        'intel_map': 'lab_intel',
        'lab_b': 'lab_b_scan',
        'lab_d': 'lab_d_scan',
        'lab_d_scan_furnitures': 'lab_d_scan',
        'lab_e': 'lab_f_scan',
        'sistD': 'sistD',
    },
}
"""
Given: labelled robot maps of each split, and their buildings. ``sistD`` is not in the list of
either split; nothing is chosen on it.
"""

_IMAGES = {'clean': 'floorplan/{}.png', 'furnished': 'furnished/{}_furnitures.png'}
# Given: grey levels below are certainly walls.
_OCCUPIED_GREY = 100
_MIN_LABEL_CELLS = 100  # colours with fewer cells are blends of two labels; chosen
_KEYS = ('precision', 'recall', 'f1', 'doors_precision', 'doors_recall')


def bench_plans(
    data: Path,
    split: Split,
    limit: int | None = None,
    on_done: Callable[[float], None] = lambda _: None,
) -> dict[str, Any]:
    """
    Score the default and both simple methods on clean and furnished plans of one split.

    Parameters
    ----------
    data : folder that holds ``bormann``
    split : a key of ``SPLITS``
    limit : use only the first plans
    on_done : called with 1.0 after every plan and method

    Returns
    -------
    dict for JSON: ``clean`` and ``furnished`` of the default method, and the same by method in
    ``baselines``
    """
    names = SPLITS[split][:limit]
    warm_up = np.where(np.eye(50, dtype=bool), OCCUPIED, FREE).astype(np.int8)
    segment_floorplan(GridMap(warm_up, CELL_M), SegmentationConfig())
    doors = {name: _true_doors(data / 'bormann', name) for name in names}
    figures: dict[str, dict[str, Any]] = {method: {} for method in METHODS}
    for method in METHODS:
        for kind in _IMAGES:
            rows = []
            for name in names:
                rows.append(_score_plan(data / 'bormann', name, kind, method, doors[name]))
                on_done(1.0)
            means = np.mean([row[:-1] for row in rows], axis=0)
            figures[method][kind] = dict(zip(_KEYS, means.tolist(), strict=True)) | {
                'seconds_per_map_median': float(np.median([row[-1] for row in rows]))
            }
    return figures['default'] | {
        'baselines': {method: figures[method] for method in METHODS if method != 'default'},
        'plans': len(names),
    }


def bench_robot_maps(
    data: Path, limit: int | None = None, on_done: Callable[[float], None] = lambda _: None
) -> dict[str, Any]:
    """
    Score all methods on robot maps with hand-labelled regions, in ``data / 'areagraph'``.

    The default method segments them as submaps: unknown space is no wall. Returns precision,
    recall and F1 by method over both splits, the default's on ``tune`` and ``report`` alone, and
    the number of maps; maps whose labels have another size are left out.
    """
    rows: dict[str, list[list[float]]] = {method: [] for method in METHODS}
    left_out, halves = [], []
    maps = {stem: half for half, stems in ROBOT_MAPS.items() for stem in stems}
    for stem in sorted(maps)[:limit]:
        grid, truth = read_robot_map(data, stem)
        if truth.shape != grid.shape:
            left_out.append(stem)
            continue
        halves.append(maps[stem])
        for method in METHODS:
            config = SegmentationConfig(method=method)
            found = (
                segment_submap(submap_from_grid(grid))
                if method == 'default'
                else segment_floorplan(grid, config)
            )
            rooms = room_agreement(found.labels, truth)
            rows[method].append([rooms.precision, rooms.recall, rooms.f1])
        on_done(1.0)
    means = {method: np.mean(rows[method], axis=0).tolist() for method in METHODS}
    report: dict[str, Any] = {
        method: dict(zip(_KEYS[:3], means[method], strict=True)) for method in METHODS
    }
    for half in SPLITS:
        own = [row for row, of in zip(rows['default'], halves, strict=True) if of == half]
        if own:
            report[half] = dict(zip(_KEYS[:3], np.mean(own, axis=0).tolist(), strict=True))
    return report | {'maps': len(rows['default']), 'left_out': left_out}


def read_grid(path: Path, has_unknown: bool = False) -> GridMap:
    """
    Return a labelled map's image as a grid, row 0 at the bottom.

    Pixels darker than white are walls; with ``has_unknown``, those above dark grey are unknown.
    """
    grey = read_image(path)[::-1]
    rest = np.where(grey < _OCCUPIED_GREY, OCCUPIED, UNKNOWN) if has_unknown else OCCUPIED
    return GridMap(np.where(grey >= FREE_GREY, FREE, rest), CELL_M)


def read_storey_image(data: Path, name: str, kind: str) -> tuple[GridMap, NDArray[np.int32]]:
    """Return a storey of ``data / 'bormann'``, ``clean`` or ``furnished``, and its labels."""
    grid = read_grid(data / 'bormann' / _IMAGES[kind].format(name))
    return grid, read_labels(data / 'bormann' / 'room_labels' / f'{name}.png')


def read_robot_map(data: Path, stem: str) -> tuple[GridMap, NDArray[np.int32]]:
    """Return a map of ``data / 'areagraph'`` and its labels."""
    folder = data / 'areagraph'
    grid = read_grid(folder / 'input' / f'{stem}.png', has_unknown=True)
    return grid, _region_labels(folder / 'GT' / f'{stem}.png')


def _region_labels(path: Path) -> NDArray[np.int32]:
    """Return the labels of an image of regions: by colours, or by outlines if it has none."""
    labels = _colour_labels(path)
    return labels if labels.any() else _outlined_labels(path)


def _outlined_labels(path: Path) -> NDArray[np.int32]:
    """Return labels of white regions separated by dark lines."""
    pieces, figures = pieces_of(read_image(path)[::-1] >= FREE_GREY, connectivity=4)
    kept = figures[:, cv2.CC_STAT_AREA] > _MIN_LABEL_CELLS
    kept[0] = False
    return np.where(kept, np.cumsum(kept), 0).astype(np.int32)[pieces]


def _colour_labels(path: Path) -> NDArray[np.int32]:
    """Return labels of an image with one saturated colour per region; grey is no region."""
    colours = read_image(path, cv2.IMREAD_COLOR)[::-1].astype(np.int32)
    code = (colours[..., 0] << 16) | (colours[..., 1] << 8) | colours[..., 2]
    code[colours.max(axis=2) == colours.min(axis=2)] = 0
    values, inverse, counts = np.unique(code, return_inverse=True, return_counts=True)
    kept = (counts > _MIN_LABEL_CELLS) & (values > 0)
    numbers = np.where(kept, np.cumsum(kept), 0).astype(np.int32)
    return np.asarray(numbers[inverse].reshape(code.shape), dtype=np.int32)


def _true_doors(bormann: Path, name: str) -> NDArray[np.float64]:
    """Return positions (D, 2) of the openings between hand-labelled rooms, clean drawing."""
    clean = read_grid(bormann / _IMAGES['clean'].format(name))
    truth = read_labels(bormann / 'room_labels' / f'{name}.png')
    return true_openings(truth, clean.cells == FREE)


def _score_plan(
    bormann: Path,
    name: str,
    kind: str,
    method: Literal['default', 'morphological', 'distance'],
    true_doors: NDArray[np.float64],
) -> list[float]:
    """Return the figures of ``_KEYS`` and the segmentation time in seconds."""
    grid = read_grid(bormann / _IMAGES[kind].format(name))
    truth = read_labels(bormann / 'room_labels' / f'{name}.png')
    started = time.perf_counter()
    found = segment_floorplan(grid, SegmentationConfig(method=method))
    seconds = time.perf_counter() - started
    rooms = room_agreement(found.labels, truth)
    tolerance = DOOR_TOLERANCE_M / CELL_M
    doors = place_agreement(_door_places(found), true_doors, tolerance)
    return [rooms.precision, rooms.recall, rooms.f1, doors.precision, doors.recall, seconds]


def _door_places(segmentation: Segmentation) -> NDArray[np.float64]:
    """Return the midpoints (D, 2) of all doors in rows and columns."""
    middles = np.array([portal.ends.mean(axis=0) for portal in segmentation.portals])
    return segmentation.grid.xy_to_rc(middles.reshape(-1, 2))
