# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Training data of the door model: maps with known rooms, split at all possible room boundaries.

Drawings are those of real buildings of the development split, bare and furnished, unchanged and
rotated, mirrored and rescaled, and generated ones in many styles. Finished robot maps are labelled
ones of the development split and drawings converted to robot maps. Submaps come from ray-cast
tours of generated buildings, and from lidar recordings with true poses plus a small drift.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.outside import outside_as_unknown
from fpnet_core.segmentation.assemble import upsample_labels
from fpnet_core.segmentation.door_figures import LINE_FIGURES
from fpnet_core.segmentation.door_model import MAP_FIGURES
from fpnet_core.segmentation.floorplan import drawn_scene
from fpnet_core.segmentation.joining import DividingLines, Pieces
from fpnet_core.segmentation.rooms import cut_parts
from fpnet_core.segmentation.scene import Scene
from fpnet_core.segmentation.submap import is_from_scans, part_scene
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, GridMap, Submap
from fpnet_lab.evaluation.localization.drives import submap_of
from fpnet_lab.evaluation.segmentation import ROBOT_MAPS, read_robot_map, read_storey_image
from fpnet_lab.evaluation.submap_recordings import SENSOR_NAMES, drifting_drive
from fpnet_lab.kept import make_once
from fpnet_lab.sim.config import BuildingConfig, SimConfig
from fpnet_lab.sim.drawn.render import paint_rings
from fpnet_lab.sim.drawn.rough import robot_map_of
from fpnet_lab.sim.drawn.styled import draw_styled
from fpnet_lab.sim.pairs.explore import draw_scanner, scan_walk
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes
from fpnet_lab.sim.pairs.walks import plan_walk
from fpnet_lab.sim.plans.sources import GeneratedPlans
from fpnet_lab.sim.population.floors import TUNE_FLOORS, room_rings
from fpnet_lab.sim.types import BuildingPlan, PlanDoor
from fpnet_lab.training.gathering import Counts, MapTask

Labels = NDArray[np.int32]
Array = NDArray[np.float64]

FIRST_DRIVE = 5000
"""Given: seed of the first recording, larger than those of the benchmark."""

_COLUMNS = (*LINE_FIGURES, *MAP_FIGURES)  # of the dividing lines

# Chosen, not measured:
_OFF = 0.1, 0.06  # standard deviations of log scales, of real and of generated buildings
_ROOMS = (8, 48)
_MIRRORED = 0.5  # share of variants of drawings
_WIDENED = 0.5, 0.3  # share of generated storeys with wide openings, and of doors on them
_WIDE_M, _JAMB_M = (1.4, 3.8), 0.1  # width of these openings, and of wall kept at their ends
_SIM = SimConfig(
    building=BuildingConfig(moved_doors=0.0, moved_walls=0.0, removed_walls=0.0, added_walls=0.0)
)


@dataclass(frozen=True)
class DoorAmounts(Counts):
    """Variants of every real drawing and map, and numbers of generated maps of each kind."""

    drawings: int = 5
    drawn_maps: int = 4
    robot_maps: int = 5
    generated: int = 350
    tours: int = 500
    drives: int = 70


@dataclass(frozen=True, eq=False)
class DoorSample:
    """
    Map split into pieces.

    ``overlap (P, T + 1)`` is the area of each piece in each true room [m2]; the first column is
    the area outside of all rooms. ``kind`` is the source of the map.
    """

    building: str
    kind: str
    is_real: bool
    pieces: Pieces
    lines: DividingLines
    overlap: Array


DoorTask = MapTask[tuple[Scene, Labels] | None]


def gather_samples(
    folder: Path,
    tasks: Sequence[DoorTask],
    workers: int = 1,
    on_map: Callable[[float], None] = lambda _: None,
) -> list[DoorSample]:
    """
    Split maps with known rooms; results in ``folder`` are reused.

    Raises
    ------
    FpnetError
        If the shared data is missing or incomplete, or a cached sample is unusable.
    """
    named = {task.name: task for task in tasks}
    kind = tuple[DoorSample, ...]
    made = make_once(folder, kind, named, _samples, workers, on_map, _COLUMNS)
    return [sample for samples in made for sample in samples]


def door_tasks(data: Path, seed: int, amounts: DoorAmounts) -> Iterator[DoorTask]:
    """Yield the tasks of all maps; deterministic."""
    drawings = [(name, kind) for name in TUNE_FLOORS for kind in ('clean', 'furnished')]
    for number, (name, kind) in enumerate(drawings):
        for variant in range(amounts.drawings):
            key = seed, 0, 100 * number + variant
            yield MapTask(partial(_drawing, data, name, kind, variant), name, 'drawing', True, key)
        for variant in range(amounts.drawn_maps):
            key = seed, 1, 100 * number + variant
            yield MapTask(partial(_drawn_map, data, name, kind), name, 'drawn map', True, key)
    for number, (stem, name) in enumerate(ROBOT_MAPS['tune'].items()):
        for variant in range(amounts.robot_maps):
            key = seed, 2, 100 * number + variant
            yield MapTask(partial(_robot_map, data, stem, variant), name, 'robot map', True, key)
    kinds = (_generated, 'generated', amounts.generated), (_tour, 'tour', amounts.tours)
    for kind_number, (make, kind, count) in enumerate(kinds, start=3):
        for number in range(count):
            yield MapTask(make, f'{kind} {number}', kind, False, (seed, kind_number, number))
    for number in range(amounts.drives):
        make_drive = partial(_drive, FIRST_DRIVE + number)
        yield MapTask(make_drive, f'drive {number}', 'drive', False, (seed, 5, number))


def _samples(task: DoorTask) -> tuple[DoorSample, ...]:
    """Return a map's sample; none if the map cannot be split."""
    made, _ = task.begun()
    if made is None:
        return ()
    scene, truth = made
    parts = cut_parts(scene)
    passable = parts.scene.free & ~parts.scene.lintel
    labels = upsample_labels(parts.labels, parts.work.stride, passable)
    count, rooms = len(parts.pieces.peak), int(truth.max(initial=0)) + 1
    flat = labels.astype(np.int64) * rooms + truth
    cells = np.bincount(flat.ravel(), minlength=count * rooms).reshape(count, rooms)
    cells[0] = 0  # ignore cells of true rooms outside of all pieces
    overlap = np.asarray(cells * scene.cell_m**2, np.float64)
    sample = DoorSample(task.building, task.kind, task.is_real, parts.pieces, parts.lines, overlap)
    return (sample,)


def _off(rng: np.random.Generator, variant: int, spread: float) -> float:
    """Return true metres per nominal one; 1 for the first variant."""
    return 1.0 if variant == 0 else float(np.exp(rng.normal(0.0, spread)))


def _drawing(
    data: Path, name: str, kind: str, variant: int, rng: np.random.Generator
) -> tuple[Scene, Labels]:
    grid, truth = read_storey_image(data, name, kind)
    cells = grid.cells
    if variant:
        turns, is_mirrored = int(rng.integers(4)), rng.random() < _MIRRORED
        cells, truth = (_turned(values, turns, is_mirrored) for values in (cells, truth))
    return _plan_scene(cells, grid.resolution * _off(rng, variant, _OFF[0])), truth


def _turned(values: NDArray[Any], turns: int, is_mirrored: bool) -> NDArray[Any]:
    return np.ascontiguousarray(np.rot90(values[:, ::-1] if is_mirrored else values, turns))


def _plan_scene(cells: NDArray[np.int8], cell_m: float) -> Scene:
    """Return the scene of a drawing, prepared as at run time."""
    return drawn_scene(outside_as_unknown(cells, cell_m) == FREE, cell_m)


def _drawn_map(
    data: Path, name: str, kind: str, rng: np.random.Generator
) -> tuple[Scene, Labels] | None:
    grid, truth = read_storey_image(data, name, kind)
    return _map_scene(submap_from_grid(robot_map_of(grid, rng)), truth, _off(rng, 1, _OFF[0]))


def _robot_map(
    data: Path, stem: str, variant: int, rng: np.random.Generator
) -> tuple[Scene, Labels] | None:
    grid, truth = read_robot_map(data, stem)
    return _map_scene(submap_from_grid(grid), truth, _off(rng, variant, _OFF[0]))


def _map_scene(submap: Submap, truth: Labels, metres: float = 1.0) -> tuple[Scene, Labels] | None:
    """Return the scene of a submap, prepared as at run time, ``metres`` per nominal one."""
    cell_m = submap.grid.resolution * metres
    made = part_scene(submap.grid, submap.lintel, cell_m, has_scans=is_from_scans(submap))
    return None if made is None else (made[0], truth)


def with_wide_openings(plan: BuildingPlan, rng: np.random.Generator) -> BuildingPlan:
    """Return a storey with some doors widened, up to the width of the wall between two rooms."""
    if rng.random() >= _WIDENED[0]:
        return plan
    doors = [
        _widened(plan, door, rng) if not door.is_open and rng.random() < _WIDENED[1] else door
        for door in plan.doors
    ]
    return replace(plan, doors=tuple(doors))


def _widened(plan: BuildingPlan, door: PlanDoor, rng: np.random.Generator) -> PlanDoor:
    """Return a door at a random position and width in the straight wall between its rooms."""
    middle = door.ends.mean(axis=0)
    line = shapely.LineString([middle - _WIDE_M[1] * door.along, middle + _WIDE_M[1] * door.along])
    for room in door.rooms:
        near = shapely.Polygon(plan.rooms[room].polygon).buffer(plan.wall_m, join_style='mitre')
        line = _piece_at(line.intersection(near), middle)
    along = (shapely.get_coordinates(line) - middle) @ door.along
    begin, end = float(along.min()), float(along.max())
    most = min(end - begin - 2.0 * (_JAMB_M + plan.wall_m), _WIDE_M[1])
    if most < _WIDE_M[0]:
        return door
    width = float(rng.uniform(_WIDE_M[0], most))
    margin = _JAMB_M + plan.wall_m + 0.5 * width
    at = float(rng.uniform(begin + margin, end - margin))
    offsets = np.array([[at - 0.5 * width], [at + 0.5 * width]])
    return replace(door, ends=middle + offsets * door.along)


def _piece_at(line: shapely.Geometry, place: Array) -> shapely.LineString:
    """Return the piece of a line nearest to a point (2,)."""
    point = shapely.Point(place)
    pieces = [piece for piece in shapely.get_parts(line) if isinstance(piece, shapely.LineString)]
    return min(pieces, key=point.distance, default=shapely.LineString([place, place]))


def _generated(rng: np.random.Generator) -> tuple[Scene, Labels]:
    plan, A_plan_building, grid = draw_styled(rng, with_wide_openings)
    metres = _off(rng, 1, _OFF[1])
    return _plan_scene(grid.cells, grid.resolution * metres), _painted(plan, A_plan_building, grid)


def _painted(plan: BuildingPlan, place: Affine2D | SE2, grid: GridMap) -> Labels:
    """Return labels (H, W) of the true rooms with the building at ``place``."""
    labels = np.zeros(grid.shape, np.int32)
    for label, rings in enumerate(room_rings(plan), start=1):
        for ring in rings:
            paint_rings(labels, [grid.xy_to_rc(place.apply(ring))[:, ::-1]], label)
    return labels


def _tour(rng: np.random.Generator) -> tuple[Scene, Labels] | None:
    plan = GeneratedPlans(*_ROOMS).storey(int(rng.integers(2**31)), 0, 0).plan
    plan = with_wide_openings(plan, rng)
    scanner = draw_scanner(rng, _SIM.scan)
    changes = draw_changes(plan, rng, _SIM.building)
    world = build_world(plan, changes, scanner.height_m)
    walk = plan_walk(world, rng, _SIM.scan, None)
    made = scan_walk(world, walk, scanner, rng, _SIM.scan) if len(walk) else None
    if made is None:
        return None
    submap, T_submap_building = made
    return _map_scene(submap, _painted(plan, T_submap_building, submap.grid))


def _drive(seed: int, rng: np.random.Generator) -> tuple[Scene, Labels] | None:
    drive = drifting_drive(seed, SENSOR_NAMES[seed % len(SENSOR_NAMES)], rng)
    submap = submap_of(drive.sweeps)
    return _map_scene(submap, _painted(drive.plan, drive.T_building_odom.inv(), submap.grid))
