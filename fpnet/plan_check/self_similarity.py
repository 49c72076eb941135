# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Rooms of a floorplan that look alike: the plan matched with itself, without the identity.

A room, alone or with its adjacent rooms, is cropped from the plan as a robot would have mapped
it, placed on every room of similar size in four orientations and aligned to the walls there. The
placement scorer rates these placements like a robot's. A placement is a twin if the scorer would
not accept the true place against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D, Placement, Placements, rotation
from fpnet_core.localizer.global_localizer import GlobalLocalizer
from fpnet_core.localizer.prepared_maps import StageTimer, prepare_submap
from fpnet_core.pose import PreparedMap
from fpnet_core.pose.estimate import DISTINCT_M
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose.refine import FINE, ROUGH, AlignmentPrior, refine
from fpnet_core.pose.verify import COARSE_SIGMA_M, coarse_support
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.windows import window_of
from fpnet_core.scoring import Posterior
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, UNKNOWN, GridMap, Segmentation

Array = NDArray[np.float64]

# Chosen, not measured:
_LIKE_SIZE = 1.35  # areas of twins differ by less than this factor
_WALL_REACH_M = 0.35  # margin that is cropped with a room: its walls
_PRIOR = AlignmentPrior(anisotropy_sigma=0.005)  # a drawing has one scale
_MAX_REFINED = 64  # numerical
_RANKED_BY = 250  # numerical: wall samples
_MAX_TWINS = 12  # numerical


@dataclass(frozen=True)
class Twin:
    """
    Another place that looks the same.

    ``room`` lies on ``other`` (the same room if it is only rotated) when the plan is rotated by
    ``turn_deg``. ``probability`` is that of this place against the true one: 0.5 if nothing
    distinguishes them.
    """

    room: int
    other: int
    turn_deg: float
    probability: float


@dataclass(frozen=True, eq=False)
class SelfSimilarity:
    """
    Twins by room id, for rooms that have any: of the room alone, and with its neighbours.

    ``whole`` are the placements of the whole plan on itself.
    """

    alone: dict[int, tuple[Twin, ...]]
    with_neighbours: dict[int, tuple[Twin, ...]]
    whole: tuple[Twin, ...]


def self_similarity(plan: PreparedMap, global_localizer: GlobalLocalizer) -> SelfSimilarity:
    """Return the twins of the rooms and of the whole plan; empty for one unique room."""
    segmentation = plan.segmentation
    search = _Search(plan, global_localizer)
    alone: dict[int, tuple[Twin, ...]] = {}
    together: dict[int, tuple[Twin, ...]] = {}
    for room in segmentation.rooms:
        if not (twins := search.twins([room.id], room.id)):
            continue
        alone[room.id] = twins
        seen = [room.id, *sorted(neighbours(segmentation, room.id))]
        if twins := search.twins(seen, room.id):
            together[room.id] = twins
    every = [room.id for room in segmentation.rooms]
    largest = max(segmentation.rooms, key=lambda room: room.area_m2, default=None)
    whole = () if largest is None or len(every) < 2 else search.twins(every, largest.id)
    return SelfSimilarity(alone, together, whole)


def neighbours(segmentation: Segmentation, room: int) -> set[int]:
    """Return the ids of the rooms behind the doors of a room."""
    pairs = [portal.rooms for portal in segmentation.portals if room in portal.rooms]
    return {side for pair in pairs for side in pair if side is not None and side != room}


class _Search:
    """Search for other placements of parts of a plan on the same plan."""

    def __init__(self, plan: PreparedMap, global_localizer: GlobalLocalizer) -> None:
        self._plan = plan
        self._global_localizer = global_localizer
        localizer = global_localizer.config.localizer
        self._least = 1.0 - localizer.accept_probability
        self._frames = _room_frames(plan.segmentation)

    def twins(self, rooms: Sequence[int], anchor: int) -> tuple[Twin, ...]:
        """Return the twins of ``rooms`` at which ``anchor`` lies on a room of similar size."""
        part = _mapped(_cut_out(self._plan.segmentation, rooms))
        candidates = self._candidates(anchor)
        if not len(candidates) or not len(part.evidence.walls):
            return ()
        found = _aligned(self._plan.evidence, part.evidence, candidates, COARSE_SIGMA_M)
        # The identity comes first, so that ``distinct`` drops placements near it.
        both = Placements.of([Affine2D.identity()]).joined(found)
        kept = both.distinct(part.evidence.corners, DISTINCT_M, _MAX_TWINS + 1)
        posterior = self._scored(part, both.take(kept))
        is_true = _is_identity(posterior.placements)
        probability = _against(posterior.weights, is_true)
        twins = np.flatnonzero((probability > self._least) & ~is_true)
        made = (self._twin(anchor, posterior.placements[i], probability[i]) for i in twins)
        return tuple(twin for twin in made if twin is not None)

    def _scored(self, part: PreparedMap, placements: Placements) -> Posterior:
        area_m2 = part.evidence.free_area_m2
        match = self._global_localizer.matcher.match(self._plan.graph, part.graph, area_m2)
        return self._global_localizer.scorer.posterior(self._plan, part, placements, match, 0.0)

    def _candidates(self, anchor: int) -> Placements:
        """Place the anchor's rectangle on every room of similar size, in four orientations."""
        areas = np.array([room.area_m2 for room in self._plan.segmentation.rooms])
        centres, yaws = self._frames
        ratio = areas / areas[anchor]
        like = np.flatnonzero((ratio < _LIKE_SIZE) & (ratio > 1.0 / _LIKE_SIZE))
        turns = np.arange(4) * np.pi / 2
        yaw = (yaws[like][:, None] - yaws[anchor] + turns).ravel()
        linear = rotation(yaw)
        target = np.repeat(centres[like], len(turns), axis=0)
        return Placements(linear, target - linear @ centres[anchor])

    def _twin(self, anchor: int, placed: Placement, probability: float) -> Twin | None:
        """Return the twin with the room below; None if the anchor lies outside all rooms."""
        A = placed.A_plan_submap
        below = _room_at(self._plan.segmentation, A.apply(self._frames[0][anchor]))
        if below is None:
            return None
        turn = float(np.rad2deg(A.apply_yaw(0.0)))
        return Twin(anchor, below, round(turn, 1), round(float(probability), 3))


def _room_frames(segmentation: Segmentation) -> tuple[Array, Array]:
    """Return centres ``(R, 2)`` and angles ``(R,)`` of the rooms' minimum-area rectangles."""
    rectangles = [cv2.minAreaRect(room.polygon.astype(np.float32)) for room in segmentation.rooms]
    centres = np.array([rectangle[0] for rectangle in rectangles], dtype=np.float64)
    angles = np.deg2rad([rectangle[2] for rectangle in rectangles])
    return centres.reshape(-1, 2), np.asarray(angles, dtype=np.float64)


def _is_identity(placements: Placements) -> NDArray[np.bool_]:
    """Return the mask ``(C,)`` of identity placements."""
    is_unturned = (placements.linear == np.eye(2)).all(axis=(1, 2))
    return np.asarray(is_unturned & (placements.translation == 0.0).all(axis=1))


def _against(weights: Array, is_true: NDArray[np.bool_]) -> Array:
    """Return each placement's probability ``(C,)`` against the true one alone."""
    return np.asarray(1.0 / (1.0 + np.exp(weights[is_true] - weights)))


def _mapped(grid: GridMap) -> PreparedMap:
    """Return a part of the plan, prepared as a robot map."""
    side, _ = prepare_submap(submap_from_grid(grid), SubmapSegmenter(), StageTimer())
    return side


def _cut_out(segmentation: Segmentation, rooms: Sequence[int]) -> GridMap:
    """Return a crop of some rooms with their walls; cells around them are unknown."""
    grid = segmentation.grid
    inside = np.isin(segmentation.labels, np.asarray(rooms) + 1)
    reach = max(1, round(_WALL_REACH_M / grid.resolution))
    near = grown(inside, reach)
    window = window_of(near)
    assert window is not None, 'rooms have cells'
    cells = np.where(near, grid.cells, UNKNOWN)
    # Free space beyond a wall belongs to the next room, which has not been seen.
    cells[near & ~inside & (grid.cells == FREE)] = UNKNOWN
    return replace(grid, cells=cells).cropped(*window)


def _aligned(
    plan: MapEvidence, part: MapEvidence, candidates: Placements, sigma_m: float
) -> Placements:
    """Return the best candidates, aligned to the walls below them, best first."""
    rough = _ranked(plan, part, refine(plan, part.walls, candidates, _PRIOR, ROUGH), sigma_m)
    fine = refine(plan, part.walls, rough.take(slice(_MAX_REFINED)), _PRIOR, FINE)
    return _ranked(plan, part, fine, sigma_m)


def _ranked(
    plan: MapEvidence, part: MapEvidence, placements: Placements, sigma_m: float
) -> Placements:
    support = coarse_support(plan, part, placements, sigma_m, _RANKED_BY)
    return placements.take(np.argsort(-support, kind='stable'))


def _room_at(segmentation: Segmentation, xy: Array) -> int | None:
    row, column = np.rint(segmentation.grid.xy_to_rc(xy)).astype(int).tolist()
    rows, columns = segmentation.labels.shape
    if not (0 <= row < rows and 0 <= column < columns):
        return None
    room = int(segmentation.labels[row, column]) - 1
    return room if room >= 0 else None
