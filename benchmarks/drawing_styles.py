#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Segmentation quality on generated storeys, drawn in every style.

Usage: python benchmarks/drawing_styles.py [--count 12] [--seed 0] [--resolution 0.08]

Precision, recall and F1 of rooms are Bormann's, in percent. A door is found if the middle of an
opening is within 0.6 m of the middle of a true one; openings without a leaf are ignored.
Milliseconds are CPU time per storey.
"""

import argparse
import time

import numpy as np

from fpnet_core.config import SegmentationConfig
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import Segmentation
from fpnet_lab.cli.reports import print_scores
from fpnet_lab.evaluation.submap_segmentation import DOOR_TOLERANCE_M
from fpnet_lab.metrics.openings import place_agreement
from fpnet_lab.scores import Score, Units
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import STYLES, DrawingStyle
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.population.floors import room_labels
from fpnet_lab.sim.types import BuildingPlan

MAX_ROOMS = 50
UNITS = dict.fromkeys(('P', 'R', 'F1', 'door P', 'door R'), Units.SHARE)
UNITS |= dict.fromkeys(('drawing', 'segmentation'), Units.MS)


def score(plan: BuildingPlan, style: DrawingStyle, resolution_m: float) -> list[float]:
    """Return precision, recall and F1 of rooms, precision and recall of doors, and times [ms]."""
    start = time.process_time()
    grid = render_plan(plan, resolution_m, style=style)
    drawn = time.process_time()
    found = segment_floorplan(grid, SegmentationConfig())
    segmented = time.process_time()
    rooms = room_agreement(found.labels.astype(np.int32), room_labels(plan, grid))
    precision, recall = door_agreement(plan, found)
    shares = [rooms.precision, rooms.recall, rooms.f1, precision, recall]
    return [*shares, 1e3 * (drawn - start), 1e3 * (segmented - drawn)]


def door_agreement(plan: BuildingPlan, found: Segmentation) -> tuple[float, float]:
    """Return precision and recall of doors; passages without a leaf are ignored."""
    passages = [door.ends.mean(axis=0) for door in plan.doors if door.is_open]
    doors = np.array([door.ends.mean(axis=0) for door in plan.doors if not door.is_open])
    centres = [portal.ends.mean(axis=0) for portal in found.portals]
    kept = [
        at
        for at in centres
        if not any(np.hypot(*(at - other)) <= DOOR_TOLERANCE_M for other in passages)
    ]
    agreement = place_agreement(np.array(kept).reshape(-1, 2), doors, DOOR_TOLERANCE_M)
    return agreement.precision, agreement.recall


def scores(name: str, plans: list[BuildingPlan], resolution_m: float) -> list[Score]:
    """Return the mean scores of a style."""
    means = np.mean([score(plan, STYLES[name], resolution_m) for plan in plans], axis=0)
    return [Score('style', name), *map(Score, UNITS, means.tolist(), UNITS.values())]


def main() -> None:
    """Print one row per style."""
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
    print_scores(STYLES, lambda name: scores(name, plans, arguments.resolution))


if __name__ == '__main__':
    main()
