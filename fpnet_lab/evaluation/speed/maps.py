# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cost of single maps: segmentation, matching and scoring, in-process and from the shell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
import tempfile
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig, MatcherConfig, SegmentationConfig
from fpnet_core.geometry import rotation
from fpnet_core.graphs import build_region_graph, edge_features, node_features
from fpnet_core.io.maps import read_map, write_map
from fpnet_core.localizer import GlobalLocalizer, match_maps
from fpnet_core.localizer.global_localizer import MatchQuery
from fpnet_core.localizer.prepared_maps import StageTimer, prepared_plan
from fpnet_core.localizer.scale import tolerant_search
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.pose import PreparedMap, map_evidence
from fpnet_core.scoring import PlacementScorer, configured_model, gather_evidence
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, UNKNOWN, GridMap, Region, RegionGraph, RegionLabel
from fpnet_lab.evaluation.robots.robot_pairs import RobotPair, read_robot_pairs
from fpnet_lab.evaluation.speed.timing import REPEATS, Figure, median_of, shell_figure
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import STYLES
from fpnet_lab.sim.pairs.pair import MappedPair, generate_mapped_pair
from fpnet_lab.sim.plans import generate_plan

LARGE_PX = (2700, 3400)  # given: size for which the aim is stated
# Chosen, not measured:
_LARGE_FAMILY, _LARGE_ROOMS, _LARGE_SEED = 'racetrack', (40, 60), 11
_TRIAL_CELL_M = 0.1  # numerical: resolution at which a drawing's size is computed
_BORMANN_CELL_M = 0.05  # given: of all drawings of that collection
_GRID_SPACING_M = 4.0  # chosen: spacing of rooms on a grid
_PAIR_SEED, _PAIR = 900, 0  # chosen: a submap of a generated tour, and its plan


def bormann_figure(data: Path) -> Figure:
    """Return the segmentation time of Bormann's drawings, median over all that exist."""
    config = SegmentationConfig()
    paths = sorted((data / 'bormann' / 'floorplan').glob('*.png'))
    grids = [read_map(path, _BORMANN_CELL_M) for path in paths]
    calls = [partial(segment_floorplan, grid, config) for grid in grids]
    return median_of(f'cut a Bormann plan, of {len(calls)}', 0.06, calls)


def large_figure(style: str = 'sketch') -> Figure:
    """Return the segmentation time of a large generated drawing with door symbols."""
    grid = large_drawing(style)
    rows, cols = grid.shape
    call = partial(segment_floorplan, grid, SegmentationConfig())
    return median_of(f'cut a plan of {rows} x {cols} pixels ({style})', 0.4, [call])


def large_drawing(style: str) -> GridMap:
    """Return a drawing of a storey, as large as fits on paper of ``LARGE_PX``."""
    rng = np.random.default_rng(_LARGE_SEED)
    plan = generate_plan(rng, _LARGE_FAMILY, min_rooms=_LARGE_ROOMS[0], max_rooms=_LARGE_ROOMS[1])
    small = render_plan(plan, _TRIAL_CELL_M, style=STYLES[style]).shape
    cell_m = _TRIAL_CELL_M * max(np.sort(small) / (np.array(LARGE_PX) - 2))
    cells = render_plan(plan, float(cell_m), style=STYLES[style]).cells
    cells = cells if cells.shape[0] <= cells.shape[1] else np.ascontiguousarray(cells.T)
    paper = np.full(LARGE_PX, FREE if STYLES[style].white_paper else UNKNOWN, dtype=np.int8)
    paper[: cells.shape[0], : cells.shape[1]] = cells
    return GridMap(paper, float(cell_m))


def pairs_figure(data: Path) -> Figure:
    """Return the match time of a robot map and its floorplan, pairs of the development split."""
    config = FpnetConfig()
    matcher = LearnedMatcher(config.matcher)

    def match(pair: RobotPair) -> object:
        sub = submap_from_grid(pair.robot)
        return match_maps(pair.plan, sub, matcher, config, pair.is_metric, pair.is_metric)

    calls = [partial(match, pair) for pair in read_robot_pairs(data, 'tune')]
    return median_of(f'match a robot map with its plan, of {len(calls)}', 0.3, calls)


def match_figures() -> list[Figure]:
    """Return the time of the matcher, network and consensus, for graphs of two sizes."""
    matcher = LearnedMatcher(MatcherConfig())

    def figure(plan_nodes: int, sub_nodes: int, aim_s: float) -> Figure:
        plan = _grid_graph(plan_nodes, 'plan', 0.0)
        sub = _grid_graph(sub_nodes, 'submap', 0.7)

        def match() -> object:
            return matcher.match(plan, replace(sub), 300.0)  # each update has a new submap

        name = f'match call, {plan_nodes} x {sub_nodes} nodes'
        return median_of(name, aim_s, [match], 4 * REPEATS)

    return [figure(100, 30, 0.005), figure(300, 60, 0.025)]


def scorer_figures() -> list[Figure]:
    """Return the times of gathering an update's evidence and of the scorer's network."""
    config, mapped = FpnetConfig(), _mapped()
    model = configured_model(config.localizer)
    scorer = PlacementScorer(model, config.localizer.plan_prior)
    global_localizer = GlobalLocalizer(LearnedMatcher(config.matcher), scorer, config)
    search = tolerant_search(config.pose.scale_tolerance, config.pose)
    plan = prepared_plan(mapped.plan_segmentation)
    cut = mapped.sub_segmentation
    sub = PreparedMap(cut, build_region_graph(cut, 'submap'), map_evidence(mapped.submap.grid))
    query = MatchQuery(plan, sub, mapped.submap.free_area_m2, search)
    found = global_localizer.find(query, StageTimer())

    def evidence() -> object:
        # Each update has a new submap, from which nothing is cached yet.
        fresh = PreparedMap(cut, sub.graph, map_evidence(cut.grid))
        return gather_evidence(plan, fresh, found.estimates, found.match, search.log_range)

    def network() -> object:
        return model.log_probability(found.posterior.evidence)

    return [
        median_of(f'evidence of {len(found.estimates)} placements', 0.015, [evidence], 20),
        median_of('network of the placement scorer', None, [network], 20),
    ]


def shell_figures() -> list[Figure]:
    """Return the times of ``fpnet match``, ``fpnet localize`` and the help from the shell."""
    mapped = _mapped()
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        write_map(mapped.plan_segmentation.grid, folder / 'plan.yaml')
        write_map(mapped.submap.grid, folder / 'robot.yaml')
        _write_scans(folder / 'scans')
        match = [
            'match',
            '--floorplan',
            'plan.yaml',
            '--submap',
            'robot.yaml',
            '--json',
            'match.json',
        ]
        localize = ['localize', 'scans', '--floorplan', 'plan.yaml', '--json', 'run.json']
        return [
            shell_figure('fpnet --help', 0.5, ['--help'], folder),
            shell_figure('fpnet match', 2.5, match, folder),
            shell_figure('fpnet localize, two scans', 3.0, localize, folder),
        ]


def _mapped() -> MappedPair:
    return generate_mapped_pair(_PAIR_SEED, _PAIR, SimConfig())


def _write_scans(folder: Path) -> None:
    """Write two scans of a small room with their poses: the shortest possible recording."""
    folder.mkdir()
    angle = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    reach = 2.0 / np.maximum(np.abs(np.cos(angle)), np.abs(np.sin(angle)))
    heights = np.linspace(-0.8, 1.4, 12)
    circle = np.column_stack([reach * np.cos(angle), reach * np.sin(angle)])
    points = np.concatenate([np.column_stack([circle, np.full(360, z)]) for z in heights])
    lines = []
    for number in range(2):
        np.save(folder / f'{number}.npy', points.astype(np.float32))
        lines.append(f'{number + 1}.0 {0.1 * number} 0.0 0.8 0.0 0.0 0.0 1.0\n')
    (folder / 'poses.tum').write_text(''.join(lines), encoding='utf-8')


def _grid_graph(nodes: int, frame: Literal['plan', 'submap'], turn_rad: float) -> RegionGraph:
    """Return a graph of rooms on a grid, each with a door to the next: half rooms, half doors."""
    rng, R = np.random.default_rng(0), rotation(turn_rad)
    side = int(np.ceil(np.sqrt(nodes / 2)))
    regions, edges = [], []
    for index in range(nodes):
        number, is_door = divmod(index, 2)
        size = np.array([0.9, 0.2]) if is_door else rng.uniform(2.0, 3.8, 2)
        corner = _GRID_SPACING_M * np.array(divmod(number, side)) + is_door * np.array([1.0, 3.9])
        outline = (corner + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])) @ R.T
        label = RegionLabel.DOOR if is_door else RegionLabel.ROOM
        regions.append(Region(index, label, outline, outline.mean(axis=0), float(size.prod())))
        if is_door:
            edges += [pair for pair in ((index - 1, index), (index, index + 1)) if pair[1] < nodes]
    pairs: NDArray[np.int64] = np.array(edges, dtype=np.int64)
    rows, links = node_features(regions), edge_features(regions, pairs, [0.9] * len(pairs))
    return RegionGraph(tuple(regions), pairs, rows, links, frame)


PARTS: dict[str, Callable[[], list[Figure]]] = {
    'plans': lambda: [large_figure('sketch'), large_figure('clean')],
    'matcher': match_figures,
    'scorer': scorer_figures,
    'shell': shell_figures,
}
"""Parts that need neither data nor a recording."""
