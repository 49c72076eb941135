# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Training data of the scale model: maps of known scale, segmented at other assumed scales.

Drawings are those of real buildings of the development split, redrawn with other cells, walls and
rotations, generated ones in many styles (homes, small offices and houses of large rooms among
them), and sheets parsed from files as users' are, including parser errors. Robot maps are real
ones, drawings converted to robot maps, and parts of both. Storeys of simulated worlds that were
made from drawings (``priormaps``) are left out: nobody has measured them. Each map is segmented at
the first guess of its scale, and at scales far from and near to the true one, as in the rounds of
the estimate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import read_map
from fpnet_core.raster.windows import window_of
from fpnet_core.segmentation.scale import first_guess, segment_at
from fpnet_core.segmentation.scale_figures import FIGURES, scale_figures
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import UNKNOWN, GridMap, Submap
from fpnet_lab.evaluation.drawings import compared
from fpnet_lab.evaluation.robots.robot_pairs import RobotPair, varied
from fpnet_lab.kept import make_once
from fpnet_lab.sim.drawn.distort import littered, redrawn, rewalled, warp_map
from fpnet_lab.sim.drawn.rough import robot_map_of
from fpnet_lab.sim.drawn.styled import (
    HOMES,
    HOUSES,
    PRACTICES,
    STOREYS,
    draw_cell_m,
    styled_drawing,
)
from fpnet_lab.sim.plans.sources import GeneratedPlans
from fpnet_lab.sim.population.floors import TUNE_FLOORS
from fpnet_lab.sim.sheets import STANDARD_KINDS, draw_sheet
from fpnet_lab.training.gathering import Columns, Counts, MapTask
from fpnet_lab.training.sheets_read import COMPARED_CELLS, read_from_file

Array = NDArray[np.float64]

# Chosen to cover the variety of drawings and robot maps:
_FINER = 0.6  # smallest cell size of a redrawn raster, as a share of its own
_TURNED = 0.3  # share of real drawings with a random rotation
_LITTERED = 0.5  # share of drawings of homes, small offices and houses
_SHARES = ((1.0, 1.0), (0.5, 1.0), (0.35, 0.5), (0.2, 0.35), (0.1, 0.2))  # of robot maps
_OFF = (0.25, 0.1)  # standard deviations of the further log scales for segmentation
_MOST_OFF = 1.0  # larger log scales do not occur in the rounds of the estimate

FIRST_SHEET = 5000
"""Given: seed of the first sheet, in the development split, not used elsewhere."""

SHEET, HOME, PRACTICE, HOUSE = 'sheet', 'home', 'practice', 'house'
"""Given: prefixes of the names of sheets, and of generated homes, small offices and houses with
large rooms."""

_LEAST_F1 = 0.5  # chosen: users discard parses with fewer right rooms

_DECLUTTER = {
    'g4s': ('g4s_y2', 'g4s_sim_cropped'),
    'aaf': ('aaf_deployment16-cropped', 'y4_aaf-cropped', 'aaf-15'),
    'tsc': ('tsc', 'tsc_1701', 'tsc20160523', 'tsc_2'),
    'uma': ('UMA_236', 'UMA_236_237'),
    'movecare': (
        'movecare_map',
        'movecare_map1',
        'movecare_map_integrationmeeting1903',
        'movecare_map_PREPILOT',
    ),
} | {
    name: (name,)
    for name in (
        'Sarmis2_map_adj', 'map_05_03_2019_4', 'UMIC_first_floor', 'Benedetti', 'Bertolani',
        'CASA_MATTEO', 'DelCegno', 'EX1', 'EX2', 'EX3', 'EX4', 'Vottero',
    )
}  # fmt: skip
"""Robot maps by building, versions of one building together; if no file states 0.05 m, it is the
resolution of all maps of their project."""

_CELLS_M = {'UMIC_first_floor': 0.02}  # given: all others have 0.05


@dataclass(frozen=True)
class ScaleAmounts(Counts):
    """Variants of every real building, and numbers of generated buildings."""

    drawings: int = 14
    robot_maps: int = 8
    drawn_maps: int = 5
    generated: int = 300
    generated_maps: int = 150
    sheets: int = 150
    homes: int = 100
    practices: int = 75
    houses: int = 75
    home_maps: int = 100


@dataclass(frozen=True, eq=False)
class ScaleSamples(Columns):
    """
    ``N`` segmented maps.

    ``values (N, D)`` as in :class:`ScaleFigures`, ``reference (N,)``, ``truth (N,)`` logarithms of
    true over assumed metres, ``side``, ``building (N,)`` str, ``real (N,)`` bool; ``final (N,)``
    marks maps segmented near their true scale, as in the last round of an estimate.
    """

    values: Array
    reference: Array
    truth: Array
    side: NDArray[np.str_]
    building: NDArray[np.str_]
    real: NDArray[np.bool_]
    final: NDArray[np.bool_]


@dataclass(frozen=True)
class _File:
    path: Path
    cell_m: float | None = None

    def read(self) -> GridMap:
        return read_map(self.path, self.cell_m)


_OfFiles = Callable[[Sequence[_File], int, np.random.Generator], GridMap | Submap]
ScaleTask = MapTask[GridMap | Submap | None]
"""A map to segment in true metres, or None; its kind is ``plan`` or ``map``."""


def gather_samples(
    folder: Path,
    tasks: Sequence[ScaleTask],
    config: SegmentationConfig,
    workers: int = 1,
    on_map: Callable[[float], None] = lambda _: None,
) -> ScaleSamples:
    """
    Segment maps of known scale; results in ``folder`` are reused.

    Raises
    ------
    FpnetError
        If the shared data is missing or incomplete, or cached samples are unusable.
    """
    named = {task.name: task for task in tasks}
    make = partial(_samples, config=config)
    return ScaleSamples.joined(
        make_once(folder, ScaleSamples, named, make, workers, on_map, FIGURES)
    )


def scale_tasks(
    data: Path, seed: int, amounts: ScaleAmounts, config: SegmentationConfig
) -> Iterator[ScaleTask]:
    """Yield the tasks of all maps; deterministic."""
    drawings, maps = _drawings(data), _robot_maps(data)
    counted: tuple[tuple[_OfFiles, dict[str, list[_File]], int], ...] = (
        (_drawing, drawings, amounts.drawings),
        (_robot_map, maps, amounts.robot_maps),
        (_drawn_map, drawings, amounts.drawn_maps),
    )
    for kind, (make, files, count) in enumerate(counted):
        for number, (building, found) in enumerate(files.items()):
            for variant in range(count):
                side = 'map' if kind else 'plan'
                key = seed, kind, 1000 * number + variant
                yield MapTask(partial(make, found, variant), building, side, True, key)
    for number in range(amounts.generated):
        key = seed, 3, number
        yield MapTask(styled_drawing, f'generated {number}', 'plan', False, key)
    for number in range(amounts.generated_maps):
        key = seed, 4, number
        yield MapTask(_generated_map, f'generated map {number}', 'map', False, key)
    for number in range(amounts.sheets):
        key = seed, 5, number
        yield MapTask(
            partial(_read_sheet, number, config), f'{SHEET} {number}', 'plan', False, key
        )
    of_families = (
        (HOME, HOMES, amounts.homes),
        (PRACTICE, PRACTICES, amounts.practices),
        (HOUSE, HOUSES, amounts.houses),
    )
    for kind, (name, source, count) in enumerate(of_families, 6):
        drawing = partial(_family_drawing, source)
        for number in range(count):
            yield MapTask(drawing, f'{name} {number}', 'plan', False, (seed, kind, number))
    home_map = partial(_generated_map, source=HOMES)
    for number in range(amounts.home_maps):
        yield MapTask(home_map, f'{HOME} map {number}', 'map', False, (seed, 9, number))


def _samples(task: ScaleTask, config: SegmentationConfig) -> ScaleSamples:
    """Return a map segmented at several scales."""
    source, rng = task.begun()
    states = [] if source is None else list(_states(source, config, rng))
    count = len(states)
    return ScaleSamples(
        np.array([values for values, *_ in states]).reshape(count, len(FIGURES)),
        np.array([reference for _, reference, *_ in states], dtype=np.float64),
        np.array([truth for *_, truth, _ in states], dtype=np.float64),
        np.full(count, task.kind),
        np.full(count, task.building),
        np.full(count, task.is_real),
        np.array([is_final for *_, is_final in states], dtype=np.bool_),
    )


def _drawings(data: Path) -> dict[str, list[_File]]:
    """Return the files of each building, the bare drawing first."""
    bormann = data / 'bormann'
    found = {
        name: [
            _File(path, 0.05)
            for path in (
                bormann / 'floorplan' / f'{name}.png',
                *sorted((bormann / 'furnished').glob(f'{name}_*.png')),
            )
        ]
        for name in TUNE_FLOORS
    }
    found |= {name: [_File(data / f'gdc/floorplan/{name}.yaml')] for name in ('gdc1', 'gdc2')}
    found['g4s'] = [_File(data / 'g4s/floorplan/g4s.yaml')]
    for name in ('mesh_aws_small_house', 'mesh_cpr_office'):
        found[name] = [_File(data / name / 'floorplan_from_mesh.yaml')]
    return _checked(found)


def _robot_maps(data: Path) -> dict[str, list[_File]]:
    """Return the files of each building with metric maps."""
    found = {
        building: [
            _File(data / f'declutter/maps/{name}.png', _CELLS_M.get(name, 0.05)) for name in names
        ]
        for building, names in _DECLUTTER.items()
    }
    found['lab_ipa'] = [_File(data / 'bormann/robot_maps/ipa_map_pgm.png', 0.05)]
    found |= {name: [_File(data / f'gdc/robot_maps/{name}.yaml')] for name in ('gdc1', 'gdc2')}
    found['g4s'].append(_File(data / 'g4s/robot_maps/g4s.yaml'))
    house = 'mesh_aws_small_house'
    found[house] = [_File(data / house / 'map_turtlebot.yaml')]
    return _checked(found)


def _checked(found: dict[str, list[_File]]) -> dict[str, list[_File]]:
    for files in found.values():
        for file in files:
            if not file.path.is_file():
                raise FpnetError(f'{file.path} is missing; give the folder of the shared data')
    return found


def _drawing(files: Sequence[_File], variant: int, rng: np.random.Generator) -> GridMap:
    """Return a variant: the unchanged files first, then redrawn ones."""
    if variant < len(files):
        return files[variant].read()
    grid = rewalled(files[int(rng.integers(len(files)))].read(), rng)
    grid = redrawn(grid, max(draw_cell_m(rng), _FINER * grid.resolution))
    if rng.random() < _TURNED:
        turn = SE2.from_xy_yaw(0.0, 0.0, float(rng.uniform(-np.pi, np.pi)))
        grid = warp_map(grid, Affine2D(turn.linear, turn.translation))
    return grid


def _robot_map(files: Sequence[_File], variant: int, rng: np.random.Generator) -> Submap:
    return _part(files[variant % len(files)].read(), rng)


def _drawn_map(files: Sequence[_File], variant: int, rng: np.random.Generator) -> Submap:
    """Return a part of a drawing converted to a robot map."""
    return _part(robot_map_of(files[variant % len(files)].read(), rng), rng)


def _read_sheet(number: int, config: SegmentationConfig, _: np.random.Generator) -> GridMap | None:
    """Return the parse of a generated sheet; None if it is rejected or mostly wrong."""
    kinds = list(STANDARD_KINDS)
    sheet = draw_sheet(FIRST_SHEET + number, kinds[number % len(kinds)])
    read = read_from_file(sheet, config)
    if read is None:
        return None
    H_plan_page = read.found.H_plan_pixel @ read.H_pixel_page
    rooms = compared(sheet, read.found.segmentation, H_plan_page, COMPARED_CELLS)
    return read.in_true_metres if rooms.f1 >= _LEAST_F1 else None


def _family_drawing(source: GeneratedPlans, rng: np.random.Generator) -> GridMap:
    """Return a drawing of a family's storey, many with clutter, which must not affect scale."""
    grid = styled_drawing(rng, source)
    return littered(grid, rng) if rng.random() < _LITTERED else grid


def _generated_map(rng: np.random.Generator, source: GeneratedPlans = STOREYS) -> Submap:
    return _part(robot_map_of(styled_drawing(rng, source), rng), rng)


def _part(grid: GridMap, rng: np.random.Generator) -> Submap:
    """Return a rotated connected part of a robot map."""
    share = _SHARES[int(rng.integers(len(_SHARES)))]
    whole = RobotPair('', grid, grid, Affine2D.identity(), is_metric=True)
    cut = varied(whole, rng, share).robot
    window = window_of(cut.cells != UNKNOWN)
    assert window is not None, 'a part of a map shows something'
    return submap_from_grid(cut.cropped(*window))


def _states(
    source: GridMap | Submap, config: SegmentationConfig, rng: np.random.Generator
) -> Iterator[tuple[Array, float, float, bool]]:
    """Yield values, reference, truth and whether this is the last round, at several scales."""
    factors = [first_guess(source), *np.exp(rng.normal(0.0, _OFF)).tolist()]
    for number, factor in enumerate(factors):
        if abs(np.log(factor)) > _MOST_OFF:
            continue
        figures = scale_figures(segment_at(source, config, factor), factor)
        if figures.reference is not None:
            is_final = number == len(factors) - 1
            truth = -float(np.log(factor))
            yield figures.values, figures.reference, truth, is_final
