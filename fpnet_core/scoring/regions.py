# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence from whole rooms and doors, and from the matcher's probabilities."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements
from fpnet_core.matches import LEAST_DECADES, WELL_SEEN, MatchResult
from fpnet_core.pose import PreparedMap
from fpnet_core.scoring import kernels
from fpnet_core.scoring.walls import LookedAt

Array = NDArray[np.float64]
Figures = dict[str, Array]

_NO_ROOM = np.int32(0)  # given
# Chosen, not measured:
_TOUCHED = 0.3  # share of the area of a plan room from which it counts as entered
_DOOR_M, _DOOR_REACH_M = 0.5, 1.0  # standard deviation and limit of a door's distance to its pair
_SAME_M = 1.5  # distance within which a placement equals one of the matcher


def region_figures(
    plan: PreparedMap,
    sub: PreparedMap,
    placements: Placements,
    looked: LookedAt,
    match: MatchResult,
) -> Figures:
    """Return the features of rooms, doors and matches, ``(C,)`` each."""
    apart = _doors_apart(plan, sub, placements)
    return (
        _rooms(plan, sub, placements, looked)
        | _doors(plan, sub, looked, apart)
        | _matches(plan, sub, looked, match, apart)
        | {'match_whole': _matched_whole(sub, placements, match)}
    )


def _rooms(
    plan: PreparedMap, sub: PreparedMap, placements: Placements, looked: LookedAt
) -> Figures:
    """Return how well the rooms of both maps cover each other."""
    names = ('rooms_pure', 'plan_rooms_pure', 'rooms_alike', 'rooms_whole', 'plan_share')
    nothing = dict.fromkeys(names, np.zeros(len(placements)))
    if not (len(looked.free) and sub.segmentation.rooms and plan.segmentation.rooms):
        return nothing
    counts = _overlap(plan, sub, looked)
    samples_m2 = len(looked.free) / max(sub.evidence.free_area_m2, 1e-6)
    drawn = _room_areas(plan) * samples_m2 / (placements.scale**2)[:, None]  # samples (C, rooms)
    both = counts[:, :, 1:]
    entered = both.sum(axis=1) > _TOUCHED * drawn
    area = _room_areas(plan)
    return nothing | {
        'rooms_pure': _share(both.max(axis=2).sum(axis=1), counts.sum(axis=(1, 2))),
        'plan_rooms_pure': _share(both.max(axis=1).sum(axis=1), both.sum(axis=(1, 2))),
        'plan_share': entered @ area / max(float(area.sum()), 1e-6),
        **_whole_rooms(sub, counts, drawn),
    }


def _overlap(plan: PreparedMap, sub: PreparedMap, looked: LookedAt) -> Array:
    """Count free samples per pair of rooms, ``(C, rooms of sub, 1 + rooms of plan)``."""
    grid, labels = sub.segmentation.grid, sub.segmentation.labels
    rc = np.clip(np.rint(grid.xy_to_rc(looked.free)), 0, np.array(labels.shape) - 1)
    row, col = rc.astype(np.int64).T
    placed = kernels.look_up(looked.to_plan, looked.free, plan.room_of_cell, _NO_ROOM)
    sizes = (len(side.segmentation.rooms) + 1 for side in (sub, plan))
    counts = kernels.room_overlap(placed, labels[row, col].astype(np.int64), *sizes)
    return counts[:, 1:].astype(np.float64)


def _room_areas(side: PreparedMap) -> Array:
    """Return the areas of the rooms [m^2], in the order of their ids: rooms come first."""
    return np.array([room.area_m2 for room in side.segmentation.rooms])


def _whole_rooms(sub: PreparedMap, counts: Array, drawn: Array) -> Figures:
    """Return how well fully observed rooms match the size of the plan rooms they lie on."""
    rooms = sub.segmentation.rooms
    whole = np.array([room.observed_fraction >= WELL_SEEN for room in rooms], dtype=np.bool_)
    if not whole.any():
        return {}
    seen = counts[:, whole]
    both, size = seen[:, :, 1:], seen.sum(axis=2)
    union = size[:, :, None] + drawn[:, None] - both
    best = (both / np.maximum(union, 1.0)).max(axis=2)
    return {
        'rooms_alike': _share((best * size).sum(axis=1), size.sum(axis=1)),
        'rooms_whole': np.full(len(counts), np.log1p(whole.sum())),
    }


def _share(part: Array, whole: Array) -> Array:
    return np.asarray(part / np.maximum(whole, 1.0), dtype=np.float64)


def _doors_apart(plan: PreparedMap, sub: PreparedMap, placements: Placements) -> Array:
    """Return the distances [m] of observed from plan doors, ``(C, doors, plan doors)``."""
    apart = placements.apply(sub.door_points)[:, :, None] - plan.door_points
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]))


def _doors(plan: PreparedMap, sub: PreparedMap, looked: LookedAt, apart: Array) -> Figures:
    """Return the shares of matched doors, and of plan doors missing in the observed area."""
    count, seen_doors, drawn_doors = apart.shape
    counted = {'doors_counted': np.full(count, np.log1p(seen_doors))}
    if not (seen_doors and drawn_doors):
        return counted | dict.fromkeys(
            ('doors_met', 'doors_near', 'doors_missing'), np.zeros(count)
        )
    nearest = apart.min(axis=2)
    observed = sub.evidence.observed
    expected = kernels.look_up(looked.to_sub, plan.door_points, observed, np.False_)
    missing = expected & (apart.min(axis=1) > _DOOR_REACH_M)
    return counted | {
        'doors_met': np.exp(-0.5 * (nearest / _DOOR_M) ** 2).mean(axis=1),
        'doors_near': (nearest < _DOOR_REACH_M).mean(axis=1),
        'doors_missing': _share(missing.sum(axis=1), expected.sum(axis=1)),
    }


def _matches(
    plan: PreparedMap, sub: PreparedMap, looked: LookedAt, match: MatchResult, apart: Array
) -> Figures:
    """Return the matcher's probability of the region pairs of each placement, in decades."""
    nothing = np.zeros(len(looked.to_plan))
    found = {'match_rooms': nothing, 'match_doors': nothing}
    if not match.probability.size:
        return found
    decades = np.log10(np.maximum(match.probability, 10.0**-LEAST_DECADES)) + LEAST_DECADES
    rooms = sub.segmentation.rooms
    if rooms:
        middles = np.array([room.centroid for room in rooms])
        on = kernels.look_up(looked.to_plan, middles, plan.room_of_cell, _NO_ROOM).astype(np.int64)
        ids = np.array([room.id for room in rooms])
        found['match_rooms'] = np.where(on > 0, decades[on - 1, ids], 0.0).mean(axis=1)
    if apart.shape[1] and apart.shape[2]:
        drawn = np.array([portal.door for portal in plan.segmentation.portals])
        ids = np.array([portal.door for portal in sub.segmentation.portals])
        value = decades[drawn[apart.argmin(axis=2)], ids]
        found['match_doors'] = np.where(apart.min(axis=2) < _DOOR_REACH_M, value, 0.0).mean(axis=1)
    return found


def _matched_whole(sub: PreparedMap, placements: Placements, match: MatchResult) -> Array:
    """Return the probability of the matcher's complete assignment at that placement, ``(C,)``."""
    if not match.hypotheses:
        return np.zeros(len(placements))
    corners = sub.evidence.corners
    whole = np.array([each.S_plan_sub.apply(corners) for each in match.hypotheses])
    apart = np.linalg.norm(placements.apply(corners)[:, None] - whole, axis=3).mean(axis=2)
    probable = np.array([each.probability for each in match.hypotheses])
    return np.asarray((probable * (apart < _SAME_M)).max(axis=1))
