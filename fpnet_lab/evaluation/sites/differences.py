# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Change detection in generated buildings with outdated drawings, against the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.config import FpnetConfig
from fpnet_core.differences import Difference, DifferenceKind, Differences, find_differences
from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.localizer.prepared_maps import StageTimer, prepare_plan, prepare_submap
from fpnet_core.localizer.scale import tolerant_search
from fpnet_core.pose import PreparedMap, aligned_placements
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.types import OCCUPIED, GridMap
from fpnet_lab.evaluation.localization.drives import kept_scans, submap_of
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.sim.buildings.building import Building
from fpnet_lab.sim.drawn.distort import renovated
from fpnet_lab.sim.drawn.render import paint_rings, render_plan
from fpnet_lab.sim.drawn.storeys import CELL_M

Mask = NDArray[np.bool_]

FAMILIES = ('double_corridor', 'racetrack', 'branched', 'central_hall', 'bays', 'suites')
SENSORS = ('beams16', 'planar')

_RENOVATIONS = 3  # chosen: renovations that an outdated drawing lacks
_NEAR_M = 0.25  # physical: largest distance of a detected wall from the true one
_CHANGED_STREAM = 21  # given: second element of the seed
_MOST = 0.5  # numerical: smallest share that counts as most of a piece


@dataclass(frozen=True, eq=False)
class DifferenceCase:
    """
    A recording, both maps, their aligned true placement, and the truth on the raster.

    ``true`` has the walls; ``furniture (H, W)`` is the mask of furniture.
    """

    name: str
    plan: PreparedMap
    sub: PreparedMap
    A_plan_sub: Affine2D
    true: GridMap
    furniture: Mask
    is_changed: bool

    def found(self) -> Differences:
        """Return the detected differences."""
        return find_differences(self.plan, self.sub, self.A_plan_sub)


def difference_cases(seed: int, config: FpnetConfig) -> tuple[DifferenceCase, DifferenceCase]:
    """
    Simulate a recording; return its cases with an outdated and with an exact drawing.

    Sweeps are registered by KISS-ICP; the true placement is aligned to the walls like an estimate.
    """
    family, sensor = FAMILIES[seed % len(FAMILIES)], SENSORS[seed // len(FAMILIES) % len(SENSORS)]
    recording = drive_through(family, sensor, seed)
    true = render_plan(recording.building.plan, CELL_M)
    sheet, rng = true, np.random.default_rng((seed, _CHANGED_STREAM))
    for _ in range(_RENOVATIONS):
        sheet = renovated(sheet, recording.building.plan, Affine2D.identity(), rng)
    submap = submap_of(kept_scans(recording, config.odometry), config.submap)
    sub = prepare_submap(submap, SubmapSegmenter(), StageTimer())[0]
    T_plan_odom = SE2.from_matrix4(recording.truth()[0])
    search = tolerant_search(config.pose.scale_tolerance, config.pose)
    cases = []
    for drawn, is_changed in ((sheet, True), (true, False)):
        plan = prepare_plan(drawn, config)
        placed = aligned_placements(
            plan.evidence, sub.evidence, Placements.of([T_plan_odom]), search.alignment_prior
        )
        A = placed[0].A_plan_submap
        name = f'{family}_{sensor}_{seed}'
        furniture = _furniture(recording.building, true)
        cases.append(DifferenceCase(name, plan, sub, A, true, furniture, is_changed))
    return cases[0], cases[1]


def _furniture(building: Building, true: GridMap) -> Mask:
    """Return the furniture mask (H, W)."""
    cells = np.zeros(true.shape, np.uint8)
    for piece in building.furniture:
        outline = shapely.get_coordinates(piece.footprint.exterior)
        paint_rings(cells, [true.xy_to_rc(outline)[:, ::-1]], 1)
    return cells > 0


def near_share(cells: Mask, walls: Mask, cell_m: float) -> float:
    """Return the share of cells near a wall; 0 without walls."""
    if not walls.any():
        return 0.0
    return float((cells_to_nearest(walls)[cells] * cell_m <= _NEAR_M).mean())


@dataclass(frozen=True, eq=False)
class Labelled:
    """
    A detected piece with its truth.

    ``is_wall``: whether its kind is correct: a wall, or a missing wall. Otherwise ``is_furniture``
    separates furniture from walls displaced by drift and from open doors.
    """

    piece: Difference
    is_wall: bool
    is_furniture: bool


def labelled(case: DifferenceCase, found: Differences) -> list[Labelled]:
    """Return all pieces except doors with their truth."""
    true = case.true.cells == OCCUPIED
    made = []
    for number, piece in enumerate(found.pieces, start=1):
        if piece.kind is DifferenceKind.SHUT:
            continue
        cells, cell_m = found.piece_of == number, case.true.resolution
        is_missing = piece.kind is DifferenceKind.MISSING
        is_wall = (near_share(cells, true, cell_m) >= _MOST) is not is_missing
        stands = not is_missing and near_share(cells, case.furniture, cell_m) >= _MOST
        made.append(Labelled(piece, is_wall, stands and not is_wall))
    return made


@dataclass(frozen=True)
class DifferenceFigures:
    """
    Detection figures over pieces of a metre and more.

    ``false_per_100_m`` counts false differences on exact drawings per 100 m of observed wall;
    ``furniture_as_wall`` is the share of furniture classified as wall.
    """

    precision: float
    recall: float
    furniture_as_wall: float
    false_per_100_m: float
    pieces: int
    true_pieces: int


LEAST_M = 1.0
"""Given: smallest length of a counted piece."""


def figures_of(cases: Sequence[DifferenceCase]) -> DifferenceFigures:
    """Return the figures of several cases."""
    right = wrong = met = there = furniture = as_wall = 0
    false, walls_m = 0, 0.0
    for case in cases:
        found = case.found()
        for each in labelled(case, found):
            piece = each.piece
            if piece.length_m < LEAST_M:
                continue
            furniture += each.is_furniture
            claimed = piece.is_likely and piece.is_of_drawing
            as_wall += each.is_furniture and claimed
            if case.is_changed:
                right += claimed and each.is_wall
                wrong += claimed and not each.is_wall
            else:
                false += claimed
        if case.is_changed:
            one, all_ = _recalled(case, found)
            met, there = met + one, there + all_
        else:
            walls_m += case.sub.evidence.wall_length_m
    return DifferenceFigures(
        right / max(right + wrong, 1),
        met / max(there, 1),
        as_wall / max(furniture, 1),
        100.0 * false / max(walls_m, 1.0),
        right + wrong,
        there,
    )


def _recalled(case: DifferenceCase, found: Differences) -> tuple[int, int]:
    """Return the number of observed true differences that were detected, and of all observed."""
    from fpnet_core.differences.finding import APART_M
    from fpnet_core.differences.overlay import overlay
    from fpnet_core.raster.pieces import pieces_of

    laid = overlay(case.plan, case.sub, case.A_plan_sub)
    true = case.true.cells == OCCUPIED
    cell_m = case.true.resolution
    true_m = cells_to_nearest(true) * cell_m
    new = true & (laid.drawn_m > APART_M) & (laid.seen_m <= _NEAR_M)
    gone = laid.is_drawn & (true_m > APART_M) & laid.is_free & (laid.seen_m > _NEAR_M)
    claimed = [k for k, p in enumerate(found.pieces, 1) if p.is_likely and p.is_of_drawing]
    marked = np.isin(found.piece_of, claimed)
    marked_m = cells_to_nearest(marked) * cell_m if marked.any() else np.full(true.shape, np.inf)
    met = there = 0
    for mask in (new, gone):
        labels, stats = pieces_of(mask)
        for label in range(1, len(stats)):
            if max(stats[label, 2:4]) * cell_m < LEAST_M:
                continue
            there += 1
            met += bool((marked_m[labels == label] <= _NEAR_M).mean() >= _MOST)
    return met, there
