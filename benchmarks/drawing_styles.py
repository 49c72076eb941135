#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Draw generated storeys in every style and score how well they are cut into rooms again.

Usage: python benchmarks/drawing_styles.py [--count 12] [--seed 0] [--resolution 0.08]

Precision, recall and F1 of rooms are those of benchmarks/segmentation.py, in percent; doors are
the openings found for each hundred true ones. Milliseconds are CPU time per storey.
"""

import argparse
import time

import numpy as np
from rich.console import Console
from rich.table import Table

from fpnet_core.config import SegmentationConfig
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.sim.floors import room_labels
from fpnet_core.sim.plans import generate_plan
from fpnet_core.sim.render import render_plan
from fpnet_core.sim.styles import STYLES, DrawingStyle
from fpnet_core.sim.types import BuildingPlan

MAX_ROOMS = 50


def score(plan: BuildingPlan, style: DrawingStyle, resolution_m: float) -> list[float]:
    """Return precision, recall, F1, doors per true door [%], and both times [ms]."""
    start = time.process_time()
    grid = render_plan(plan, resolution_m, style=style)
    drawn = time.process_time()
    found = segment_floorplan(grid, SegmentationConfig())
    segmented = time.process_time()
    rooms = room_agreement(found.labels.astype(np.int32), room_labels(plan, grid))
    doors = len(found.portals) / sum(not door.is_open for door in plan.doors)
    shares = [100.0 * share for share in (rooms.precision, rooms.recall, rooms.f1, doors)]
    return [*shares, 1e3 * (drawn - start), 1e3 * (segmented - drawn)]


def main() -> None:
    """Print one row for each style."""
    parser = argparse.ArgumentParser(description='Score segmentation of drawing styles.')
    parser.add_argument('--count', type=int, default=12)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--resolution', type=float, default=0.08)
    arguments = parser.parse_args()
    plans = [
        generate_plan(np.random.default_rng([arguments.seed, i]), max_rooms=MAX_ROOMS)
        for i in range(arguments.count)
    ]
    score(plans[0], STYLES['architect'], arguments.resolution)
    table = Table('style', 'P', 'R', 'F1', 'doors', 'drawing ms', 'segmentation ms')
    for name, style in STYLES.items():
        mean = np.mean([score(plan, style, arguments.resolution) for plan in plans], axis=0)
        table.add_row(name, *(f'{value:.0f}' for value in mean))
    Console().print(table)


if __name__ == '__main__':
    main()
