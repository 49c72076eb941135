#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Score floorplan segmentation against the human labels of the Bormann floorplans.

Usage: python benchmarks/segmentation.py {tune,report} [--data ../shared/data]

Columns are percent: room precision and recall by Bormann's definition, F1 of rooms with
intersection over union above one half, and doors within 0.75 m of a true opening.
"""

import argparse
from pathlib import Path
import time

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

from fpnet_core.config import SegmentationConfig
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.agreement import place_agreement, room_agreement, true_openings
from fpnet_core.types import FREE, OCCUPIED, GridMap

RESOLUTION_M = 0.05
FREE_GREY = 250
DOOR_TOLERANCE_M = 0.75
PLANS = {
    'tune': [
        'lab_a_scan',
        'lab_c_scan',
        'lab_ipa',
        'NLB',
        'office_a',
        'office_b',
        'office_c',
        'office_d',
        'office_e',
        'Freiburg52_scan',
    ],
    'report': [
        'lab_b_scan',
        'lab_d_scan',
        'lab_f_scan',
        'lab_intel',
        'Freiburg79_scan',
        'Freiburg101_scan',
        'office_f',
        'office_g',
        'office_h',
        'office_i',
    ],
}


def read_plan(path: Path) -> GridMap:
    """Return the plan with row 0 lowest; everything darker than white is a wall."""
    grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)[::-1]
    return GridMap(np.where(grey >= FREE_GREY, FREE, OCCUPIED), RESOLUTION_M)


def score_plan(bormann: Path, name: str, image: Path) -> list[float]:
    """Return precision, recall, F1 of rooms and doors [%] and the seconds it took."""
    grid = read_plan(image)
    labels = cv2.imread(str(bormann / 'room_labels' / f'{name}.png'), cv2.IMREAD_UNCHANGED)
    truth = labels[::-1].astype(np.int32)
    start = time.perf_counter()
    segmentation = segment_floorplan(grid, SegmentationConfig())
    seconds = time.perf_counter() - start
    rooms = room_agreement(segmentation.labels, truth)
    clean = read_plan(bormann / 'floorplan' / f'{name}.png')
    middles = np.array([portal.ends.mean(axis=0) for portal in segmentation.portals])
    doors = place_agreement(
        grid.xy_to_rc(middles.reshape(-1, 2)),
        true_openings(truth, clean.cells == FREE),
        DOOR_TOLERANCE_M / RESOLUTION_M,
    )
    shares = [rooms.precision, rooms.recall, rooms.f1, doors.precision, doors.recall]
    return [100.0 * share for share in shares] + [seconds]


def main() -> None:
    """Print one table for clean and one for furnished plans."""
    parser = argparse.ArgumentParser(description='Score floorplan segmentation.')
    parser.add_argument('split', choices=sorted(PLANS))
    parser.add_argument('--data', type=Path, default=Path('../shared/data'))
    arguments = parser.parse_args()
    bormann = arguments.data / 'bormann'
    names = PLANS[arguments.split]
    segment_floorplan(GridMap(np.eye(50) * OCCUPIED, RESOLUTION_M), SegmentationConfig())
    kinds = {'clean': 'floorplan/{}.png', 'furnished': 'furnished/{}_furnitures.png'}
    for kind, pattern in kinds.items():
        table = Table('plan', 'P', 'R', 'F1', 'door P', 'door R', 's', title=kind)
        scores = [score_plan(bormann, name, bormann / pattern.format(name)) for name in names]
        for name, row in zip(names, scores, strict=True):
            table.add_row(name, *(f'{value:.1f}' for value in row[:-1]), f'{row[-1]:.2f}')
        mean, median_s = np.mean(scores, axis=0), np.median([row[-1] for row in scores])
        table.add_section()
        table.add_row('mean', *(f'{value:.1f}' for value in mean[:-1]), f'{median_s:.2f} median')
        Console().print(table)


if __name__ == '__main__':
    main()
