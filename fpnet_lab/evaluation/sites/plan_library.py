# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plan library benchmark: rank of the correct floorplan and query time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import takewhile
from pathlib import Path
import time
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet.library import LibraryPlan, PlanLibrary, Proposal
from fpnet.library.files import proposed_site, read_library_plan
from fpnet.library.keypoints import Keypoints
from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.localizer import create_global_localizer
from fpnet_core.localizer.maps import SegmentedMap, match_storeys, segment_plan, segment_robot_map
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.submaps import submap_from_grid
from fpnet_core.trajectory import lengths_along
from fpnet_core.types import GridMap
from fpnet_lab.evaluation.first_claims import true_scans
from fpnet_lab.evaluation.localization.cases import PLAIN_FAMILIES, SENSOR_CYCLE, Distortion
from fpnet_lab.evaluation.localization.drives import submap_of
from fpnet_lab.evaluation.localization.inputs import ROOMS, drive_through
from fpnet_lab.evaluation.localization.plans import draw_plan
from fpnet_lab.evaluation.robots.robot_pairs import BANDS, RobotPair, read_robot_pairs, varied
from fpnet_lab.kept import make_once
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.plans import generate_plan

FIRST = 10
"""Number of proposed plans. Given, by the aim: the correct one is among them."""

_TOUR = TourLimits(rooms=4, shortest_s=40.0, longest_s=60.0)  # chosen
_DRIVEN_M = 20.0  # given, by the aim: path length
_VARIANTS = 3  # chosen: cropped and rotated variants of every real map
_BAND = '50-100'  # given, by the aim
_RIGHT_M = 1.0  # chosen: as in the localization benchmark
_GROWTH = (100, 1_000, 10_000, 100_000)  # given, by the aim: numbers of plans
_STRETCHED = (0.8, 1.25)  # chosen: scales of plan copies that fill larger libraries
_CLAIMS = ('right', 'wrong')
_STREAM = 41  # given: second element of the seed


@dataclass(frozen=True, eq=False)
class LibraryCase:
    """Observed map, file of its building's plan, and the true placement if known."""

    group: str
    path: str
    seen: SegmentedMap
    A_plan_sub: Affine2D | None = None
    path_xy: NDArray[np.float64] | None = None


def generated_plan(number: int, seed: int, folder: Path, config: FpnetConfig) -> LibraryPlan:
    """Generate plan ``number`` of a library, write it with its scale, and load it."""
    rng = np.random.default_rng((seed, _STREAM, number))
    family = PLAIN_FAMILIES[number % len(PLAIN_FAMILIES)]
    plan = generate_plan(rng, family, *ROOMS)
    kinds = [kind for kind in Distortion if kind is not Distortion.UNKNOWN_SCALE]
    path = folder / f'generated-{number}.yaml'
    write_map(draw_plan(plan, kinds[number % len(kinds)], seed + number).grid, path)
    return read_library_plan(path, config)


def generated_plans(
    count: int, seed: int, folder: Path, config: FpnetConfig, workers: int,
    on_plan: Callable[[float], None],
) -> list[LibraryPlan]:  # fmt: skip
    """Return the plans of a generated library in order; ``folder`` gets the drawings."""
    make = partial(generated_plan, seed=seed, folder=folder, config=config)
    numbers = {str(number): number for number in range(count)}
    return make_once(None, LibraryPlan, numbers, make, workers, on_plan)


def drive_case(number: int, seed: int, folder: Path, config: FpnetConfig) -> LibraryCase:
    """Simulate a 20 m recording with true odometry, and write its plan into ``folder``."""
    family = PLAIN_FAMILIES[number % len(PLAIN_FAMILIES)]
    sensor = SENSOR_CYCLE[number % len(SENSOR_CYCLE)]
    recording = drive_through(family, sensor, seed + number, limits=_TOUR)
    kinds = [kind for kind in Distortion if kind is not Distortion.UNKNOWN_SCALE]
    drawn = draw_plan(recording.building.plan, kinds[number % len(kinds)], seed + number)
    path = folder / f'drive-{number}.yaml'
    write_map(drawn.grid, path)
    poses = recording.truth()
    path_m = lengths_along(poses[:, :2, 3])
    driven = takewhile(lambda each: path_m[each[0]] <= _DRIVEN_M, true_scans(recording))
    submap = submap_of((scan for _, scan in driven), config.submap)
    A_plan_sub = drawn.A_plan_building @ SE2.from_matrix4(poses[0])
    seen = segment_robot_map(submap, config, True)
    return LibraryCase('drives', str(path), seen, A_plan_sub, submap.path_xy)


def real_cases(data: Path, split: str, folder: Path, config: FpnetConfig) -> Iterator[LibraryCase]:
    """Yield real robot maps of undistorted plans, unchanged and cropped."""
    for number, pair in enumerate(read_robot_pairs(data, split)):
        if pair.is_distorted:
            continue
        yield _real_case(f'robot maps, {split}', pair, folder, config)
        for variant in range(_VARIANTS):
            rng = np.random.default_rng((number, variant, _STREAM))
            cut = varied(pair, rng, BANDS[_BAND])
            yield _real_case(f'robot maps, {split}', cut, folder, config)


def _real_case(group: str, pair: RobotPair, folder: Path, config: FpnetConfig) -> LibraryCase:
    seen = segment_robot_map(submap_from_grid(pair.robot), config, pair.is_metric)
    return LibraryCase(group, str(_real_path(pair, folder)), seen)


def _real_path(pair: RobotPair, folder: Path) -> Path:
    """Return the path of a pair's plan: an image without YAML if its scale is unknown."""
    return folder / f'{pair.building}{".yaml" if pair.is_metric else ".png"}'


def real_plans(data: Path, split: str, folder: Path, config: FpnetConfig) -> list[LibraryPlan]:
    """Write and load the real floorplans of one split, of known and of unknown scale."""
    plans = {}
    for pair in read_robot_pairs(data, split):
        if pair.is_distorted or pair.building in plans:
            continue
        path = _real_path(pair, folder)
        write_map(pair.plan, path.with_suffix('.yaml'))
        if not pair.is_metric:
            path.with_suffix('.yaml').unlink()
        plans[pair.building] = read_library_plan(path, config)
    return list(plans.values())


@dataclass(frozen=True)
class LibraryAnswer:
    """Group of a case, rank of the correct plan (None: not proposed), and query time."""

    group: str
    rank: int | None
    milliseconds: float


def ask(library: PlanLibrary, case: LibraryCase) -> tuple[LibraryAnswer, tuple[Proposal, ...]]:
    """Query a library with the observed map of a case."""
    begin = time.perf_counter()
    found = library.find(case.seen.segmentation, case.seen.scale, FIRST)
    milliseconds = 1e3 * (time.perf_counter() - begin)
    rank = next((each.rank for each in found if each.path == case.path), None)
    return LibraryAnswer(case.group, rank, milliseconds), found


def claim(case: LibraryCase, proposals: Sequence[Proposal], config: FpnetConfig) -> str:
    """Return the result of a search over the proposals: ``right``, ``wrong`` or ``none``."""
    if not proposals:
        return 'none'
    cuts = {
        storey.name: segment_plan(storey.plan.grid, config, storey.plan.scale.is_known)
        for storey in proposed_site(proposals, config).storeys
    }
    found = match_storeys(cuts, case.seen, create_global_localizer(config), StageTimer())
    name, best = next(iter(found.items()))
    if best.A_plan_sub is None:
        return 'none'
    if name != case.path or case.A_plan_sub is None or case.path_xy is None:
        return 'wrong'
    off = best.A_plan_sub.apply(case.path_xy) - case.A_plan_sub.apply(case.path_xy)
    return 'right' if float(np.hypot(off[:, 0], off[:, 1]).max()) <= _RIGHT_M else 'wrong'


def figures_by_group(asked: Sequence[LibraryAnswer]) -> dict[str, dict[str, Any]]:
    """Return recall of the correct plan and query time, by group."""
    groups = {}
    for group in dict.fromkeys(each.group for each in asked):
        own = [each for each in asked if each.group == group]
        groups[group] = {
            'cases': len(own),
            'first': float(np.mean([each.rank == 1 for each in own])),
            'in_first_10': float(np.mean([each.rank is not None for each in own])),
            'query_ms_median': float(np.median([each.milliseconds for each in own])),
        }
    return groups


def figures(
    asked: Sequence[LibraryAnswer], claims: Sequence[str], library: PlanLibrary
) -> dict[str, Any]:
    """Return the figures of each group, the acceptance shares, and the size of the index."""
    shares = {what: float(np.mean([each == what for each in claims])) for what in _CLAIMS}
    return {
        'plans': len(library),
        'kilobytes_a_plan': library.size_bytes / len(library) / 1e3,
        'groups': figures_by_group(asked),
        'claims': shares,
    }


def growth(
    plans: Sequence[LibraryPlan], cases: Sequence[LibraryCase], most: int, seed: int
) -> list[dict[str, float]]:
    """Return size, query time and recall of larger libraries, filled with stretched copies."""
    rng = np.random.default_rng((seed, _STREAM))
    own = {case.path for case in cases}
    rows = []
    for count in (count for count in _GROWTH if count <= most):
        others = [plan for plan in plans if plan.path not in own]
        filled = [_stretched(others[k % len(others)], k, rng) for k in range(count - len(own))]
        kept = [plan for plan in plans if plan.path in own]
        library = PlanLibrary.of([*kept, *filled])
        ask(library, cases[0])  # compiles the kernels and loads memory pages
        asked = [ask(library, case)[0] for case in cases]
        rows.append(
            {
                'plans': len(library),
                'megabytes': library.size_bytes / 1e6,
                'query_ms_median': float(np.median([each.milliseconds for each in asked])),
                'in_first_10': float(np.mean([each.rank is not None for each in asked])),
            }
        )
    return rows


def _stretched(plan: LibraryPlan, number: int, rng: np.random.Generator) -> LibraryPlan:
    """Return a copy of a plan as another building, stretched along its axes."""
    points = plan.keypoints
    scales = rng.uniform(*_STRETCHED, size=2).astype(np.float32)
    along = np.stack([np.cos(points.angle), np.sin(points.angle)], axis=1) * scales
    angle = np.arctan2(along[:, 1], along[:, 0]).astype(np.float32)
    moved = Keypoints(points.xy * scales, angle, points.kind)
    return LibraryPlan(
        f'{plan.path}-{number}', moved, _stretched_walls(plan.walls, scales), plan.low, plan.high
    )


def _stretched_walls(walls: GridMap, scales: NDArray[np.float32]) -> GridMap:
    """Stretch an axis-aligned raster, as generated plans have."""
    pose = walls.T_frame_grid
    size = np.rint(scales * walls.shape[::-1]).astype(int).tolist()
    cells = cv2.resize(walls.cells, size, interpolation=cv2.INTER_NEAREST)
    moved = SE2(pose.linear, pose.translation * scales)
    return replace(walls, cells=np.asarray(cells, np.int8), T_frame_grid=moved)
