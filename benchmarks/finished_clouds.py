# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Segmentation of finished point clouds into rooms, and matching of the clouds with their plans.

Run: python benchmarks/finished_clouds.py [--storeys 8] [--seed 1000] [--json OUT] [--work DIR]
     [--pictures DIR]; then fpnet bench figures finished_clouds=OUT, once more for another seed's

Generated, furnished storeys are surveyed by a tripod scanner and as a mobile robot's map with
2 cm of noise; no viewpoints are stored. The score of a true room is its intersection over union
with the best matching segmented room; it is found at 0.5 or more. The drawing is rotated,
stretched by 2 % and states its scale. Two neighbours in the list are also stacked, with outliers
around them, and segmented storey by storey. ``--work`` stores the results of storeys, so that an
interrupted run can resume.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
import time

import cv2
import numpy as np

from fpnet.cli.progress import progress
from fpnet.viz.pictures import DPI, saved_figure
from fpnet.viz.segmentation import draw_grid, draw_segmentation
from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import Affine2D, rotation
from fpnet_core.localizer import match_maps
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.segmentation import segment_submap
from fpnet_core.submaps import submap_from_cloud
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.kept import digest, make_once
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.lidars.clouds import SURVEYS, surveyed_cloud
from fpnet_lab.sim.plans import generate_plan

ROOMS = (10, 20)
STOREY_M = 2.95
STRAYS, STRAY_M = 3000, 20.0
STRETCH, TURN_RAD, CELL_M = (1.02, 0.98), 0.5, 0.04
SAME_IOU = 0.5
SIZE_INCHES = (12.0, 8.0)


def true_labels(plan, grid):
    """Return true room labels on a grid (H, W); all pieces of a corridor are one room."""
    labels = np.zeros(grid.shape, np.int32)
    for number, pieces in enumerate(plan.joined_rooms(), start=1):
        for piece in pieces:
            corners = grid.xy_to_rc(plan.rooms[piece].polygon)[:, ::-1]
            cv2.fillPoly(labels, [np.rint(16.0 * corners).astype(np.int32)], number, shift=4)
    return labels


def room_ious(plan, found):
    """Return the IoU (R,) of each true room with its best segmented room."""
    true = true_labels(plan, found.grid)
    size = int(true.max()) + 1, int(found.labels.max()) + 1
    both = np.zeros(size, np.int64)
    np.add.at(both, (true.ravel(), found.labels.ravel()), 1)
    union = both.sum(axis=1)[:, None] + both.sum(axis=0)[None] - both
    return (both / union)[1:, 1:].max(axis=1, initial=0.0)


def storey(seed):
    """Return a plan and its furnished building."""
    rng = np.random.default_rng(seed)
    plan = generate_plan(rng, min_rooms=ROOMS[0], max_rooms=ROOMS[1])
    return plan, extrude(plan, rng)


def drawn(plan):
    """Return a rotated and stretched drawing of a plan."""
    A = Affine2D(np.diag(STRETCH) @ rotation(TURN_RAD), np.zeros(2))
    return render_plan(plan, CELL_M, T_plan_building=A)


@dataclass(frozen=True)
class CloudCase:
    """A storey's seed and survey, and whether the previous seed's storey is stacked below it."""

    how: str
    seed: int
    has_below: bool
    pictures: Path | None = None

    @property
    def name(self):
        """Name of the result's file."""
        return f'{self.how}_{self.seed}_{digest([self.has_below])}'


@dataclass(frozen=True)
class CloudResult:
    """Results of one cloud, and the mean scores of both storeys if stacked."""

    how: str
    seed: int
    points: int
    cpu_s: float
    rooms: int
    found: float
    iou: float
    doors: int
    true_doors: int
    status: str
    probability: float
    of_two: tuple[float, ...]


def run_case(case):
    """Return the results of a case."""
    config = FpnetConfig()
    plan, points = surveyed(case.how, case.seed)
    start = time.process_time()
    sub = submap_from_cloud(points, config.submap)
    seconds = time.process_time() - start
    cut = segment_submap(sub)
    ious = room_ious(plan, cut)
    found = match_maps(drawn(plan), sub, LearnedMatcher(config.matcher), config, True, True)
    below = surveyed(case.how, case.seed - 1) if case.has_below else None
    rng = np.random.default_rng(case.seed)
    if case.pictures is not None:
        draw(cut, sub, case.pictures / f'{case.how}_{case.seed}.png')
    return CloudResult(
        how=case.how,
        seed=case.seed,
        points=len(points),
        cpu_s=seconds,
        rooms=len(ious),
        found=float(np.mean(ious > SAME_IOU)),
        iou=float(np.mean(ious)),
        doors=len(cut.doors),
        true_doors=sum(not door.is_open for door in plan.doors),
        status=found.status.value,
        probability=found.probability,
        of_two=of_two(below, (plan, points), config, rng) if below else (),
    )


def surveyed(how, seed):
    """Return a storey's plan and its surveyed points (P, 3)."""
    plan, building = storey(seed)
    points = surveyed_cloud(building, SURVEYS[how], np.random.default_rng(seed), threads=1)
    return plan, points.astype(np.float64)


def main() -> None:
    """Run all cases and print the report."""
    parser = script_parser(__doc__)
    parser.add_argument('--storeys', type=int, default=8)
    parser.add_argument('--seed', type=int, default=1000)
    parser.add_argument('--work', type=Path, metavar='DIR', help='store results here')
    parser.add_argument('--pictures', type=Path, metavar='DIR', help='write pictures here')
    arguments = parser.parse_args()
    seeds = range(arguments.seed, arguments.seed + arguments.storeys)
    cases = [
        CloudCase(how, seed, seed > arguments.seed, arguments.pictures)
        for how in SURVEYS
        for seed in seeds
    ]
    with progress('clouds', len(cases)) as advance:
        named = {case.name: case for case in cases}
        results = make_once(arguments.work, CloudResult, named, run_case, on_done=advance)
    report = {'seed': arguments.seed, 'clouds': [asdict(result) for result in results]}
    finish('finished_clouds', arguments.json, report)


def of_two(below, above, config, rng):
    """Return the mean scores of both storeys in one stacked cloud with outliers."""
    low, high = (part[1].min(axis=0) - STRAY_M for part in (below, above))
    top = above[1].max(axis=0) + STRAY_M
    strays = rng.uniform(np.minimum(low, high), top, (STRAYS, 3))
    cloud = np.concatenate([below[1], above[1] + (0.0, 0.0, STOREY_M), strays])
    scores = []
    for number, (plan, _) in enumerate((below, above), start=1):
        cut = segment_submap(submap_from_cloud(cloud, config.submap, number))
        scores.append(float(room_ious(plan, cut).mean()))
    return tuple(scores)


def draw(cut, sub, path):
    """Write a picture of coloured rooms and doors, with lintels as blue dots."""
    with saved_figure(path, SIZE_INCHES, DPI) as figure:
        ax = figure.subplots()
        draw_grid(ax, sub.grid)
        ax.plot(*sub.grid.rc_to_xy(np.argwhere(sub.lintel)).T, '.', color='blue', markersize=2.0)
        draw_segmentation(ax, cut)


if __name__ == '__main__':
    main()
