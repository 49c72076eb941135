# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cost of larger storeys: floorplan, searching update and memory."""

from __future__ import annotations

from dataclasses import dataclass, replace
import multiprocessing
import resource

import cv2
import numpy as np

from fpnet_core.config import load_config
from fpnet_core.errors import FpnetError
from fpnet_core.freed_memory import keep_freed_memory
from fpnet_core.localizer import GlobalLocalizer
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.localizer.update import update
from fpnet_core.localizer.update_state import Observation, UpdateState
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.scoring import PlacementScorer
from fpnet_core.types import UNKNOWN, GridMap, LocalizerOutput, Submap
from fpnet_lab.evaluation.speed.aims import AIM_M2, AIM_TICK_S
from fpnet_lab.evaluation.speed.timing import REPEATS, Clocked, Figure, clocked
from fpnet_lab.sim.config import ScanConfig, SimConfig
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.pairs.explore import draw_scanner, scan_walk
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes
from fpnet_lab.sim.pairs.walks import plan_walk
from fpnet_lab.sim.plans.wards import wards
from fpnet_lab.sim.types import BuildingPlan

AREAS_M2 = (300, 1_000, 3_000, 10_000, 20_000, 50_000)
"""Given: areas of the curve."""

EXPLORED_M2 = 3_000.0
"""Given: largest explored area; on small storeys it is a share of their area."""

# Chosen, not measured:
_SEEN_SHARE = 0.6
_CELL_M = 0.05
_WALKED_SHARE = 1.3  # area of the robot's window over the explored area
_CORNER_M = 25.0
_NEWS_M = 10.0  # distance to the robot up to which cells are new since the last update
_SEED = 3
_WALKS, _ENOUGH = 12, 0.2  # walks to try until the area is right, as a log ratio
_SCAN = ScanConfig(planar=0.0, large_tours=1.0, tiny_tours=0.0, resolution_m=(_CELL_M,))


@dataclass(frozen=True)
class Grown:
    """
    One storey: areas [m2], rooms drawn, wall and processor seconds, and peak memory [bytes].

    ``plan`` is the one-time cost of the floorplan and its mirror image, ``update`` that of an
    update with a full search; ``stages_s`` are the wall times of the update's stages.
    """

    area_m2: float
    rooms: int
    explored_m2: float
    plan: Clocked
    update: Clocked
    stages_s: dict[str, float]
    peak_bytes: int
    status: str

    def figures(self) -> list[Figure]:
        """Return the durations; the storey of the aim has its aim."""
        aim_s = AIM_TICK_S if self.area_m2 == AIM_M2 else None
        name = f'{self.area_m2:,.0f} m², {self.rooms} rooms'
        return [
            Figure(f'prepare a plan of {name}', self.plan[0], cpu_s=self.plan[1], of=1),
            Figure(f'searching tick on {name}', self.update[0], aim_s, cpu_s=self.update[1]),
        ]


def growth(area_m2: float) -> Grown:
    """
    Return the cost of a storey of ``area_m2``, measured in a separate process.

    Raises
    ------
    FpnetError
        If there is no walk on the storey, or the process dies.
    """
    plan = wards(np.random.default_rng(_SEED), area_m2)
    grid = render_plan(plan, _CELL_M)
    submap = _explored(plan, min(EXPLORED_M2, _SEEN_SHARE * area_m2))
    with multiprocessing.get_context('spawn').Pool(1) as pool:
        return pool.apply(_measured, (area_m2, grid, submap))


def _explored(plan: BuildingPlan, area_m2: float) -> Submap:
    """Return the submap of a robot that explores about ``area_m2`` around the centre."""
    submaps: list[Submap] = []
    for attempt in range(_WALKS):
        submaps += _walked(plan, area_m2, np.random.default_rng([_SEED, attempt]))
        if submaps and abs(_log_excess(submaps[-1], area_m2)) < _ENOUGH:
            break
    if not submaps:
        raise FpnetError(f'no walk explores a storey of {area_m2:g} m²; take another seed')
    return min(submaps, key=lambda submap: abs(_log_excess(submap, area_m2)))


def _log_excess(submap: Submap, area_m2: float) -> float:
    return float(np.log(submap.free_area_m2 / area_m2))


def _walked(plan: BuildingPlan, area_m2: float, rng: np.random.Generator) -> list[Submap]:
    """Return the map of one walk; an empty list if the robot observed nothing."""
    scanner = draw_scanner(rng, _SCAN)
    world = build_world(plan, draw_changes(plan, rng, SimConfig().building), scanner.height_m)
    half = 0.5 * np.sqrt(_WALKED_SHARE * area_m2)
    window = np.mean(plan.extent, axis=0) + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    walk = plan_walk(world, rng, _SCAN, window)
    made = scan_walk(world, walk, scanner, rng, _SCAN) if len(walk) else None
    return [] if made is None else [made[0]]


def _measured(area_m2: float, grid: GridMap, submap: Submap) -> Grown:
    """Run once to compile, then measure; the process has loaded only the product."""
    cv2.setNumThreads(1)
    keep_freed_memory()  # as nodes and commands do
    config = load_config(None, {'localizer.search_every_updates': 1})
    global_localizer = GlobalLocalizer(
        LearnedMatcher(config.matcher), PlacementScorer.configured(config.localizer), config
    )
    _timed_tick(global_localizer, Floorplan.prepared(_corner(grid), config).with_mirror(), submap)
    plan, took = clocked(lambda: Floorplan.prepared(grid, config).with_mirror())
    output, middle = _timed_tick(global_localizer, plan, submap)
    return Grown(
        area_m2,
        len(plan.working.segmentation.rooms),
        submap.free_area_m2,
        took,
        middle,
        {name: round(1e-3 * ms, 4) for name, ms in output.timings_ms.items()},
        1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
        output.status.value,
    )


def _corner(grid: GridMap) -> GridMap:
    """Return a part of a floorplan, large enough to compile all code for the whole."""
    side = int(_CORNER_M / grid.resolution)
    return grid.cropped(slice(side), slice(side))


def _timed_tick(
    global_localizer: GlobalLocalizer, plan: Floorplan, submap: Submap
) -> tuple[LocalizerOutput, Clocked]:
    """Return an update's output and median time; the area near the robot is new to it."""
    state, _ = update(
        UpdateState(plan), _observation(_before(submap)), global_localizer, StageTimer()
    )
    state, seen = replace(state, searched=None), _observation(submap)
    runs = [
        clocked(lambda: update(state, seen, global_localizer, StageTimer())[1])
        for _ in range(1 + REPEATS)
    ][1:]
    return sorted(runs, key=lambda run: run[1])[len(runs) // 2]


def _observation(submap: Submap) -> Observation:
    pose = np.eye(4)
    pose[:2, 3] = submap.path_xy[-1]
    return Observation(submap.stamp_ns, submap, pose)


def _before(submap: Submap) -> Submap:
    """Return the submap without the area near the robot."""
    grid = submap.grid
    rows, cols = np.indices(grid.shape)
    row, col = grid.xy_to_rc(submap.path_xy[-1:])[0]
    is_new = np.hypot(rows - row, cols - col) * grid.resolution < _NEWS_M
    cells = np.where(is_new, UNKNOWN, grid.cells).astype(np.int8)
    lintel = submap.lintel & ~is_new
    return replace(submap, grid=replace(grid, cells=cells), lintel=lintel)
