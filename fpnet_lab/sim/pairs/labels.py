# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ground truth correspondences of submap and plan regions, from the true transform."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from fpnet_core.geometry import Affine2D
from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_core.types import Segmentation

MATCH_OVERLAP = 0.5
"""Rooms correspond if their overlap covers this share of the smaller room... Chosen."""

MATCH_INSIDE = 0.4
"""...and this share of the submap's room. Chosen."""

WHOLE_SHARE = 0.85
"""A submap room that covers a smaller share of its plan room is partial. Chosen."""

FOREIGN_OVERLAP = 0.2
"""A submap room is unmatched if no plan room overlaps more than this share of it. Chosen."""

SAMPLE_M = 0.15
"""Numerical: approximate cell size of the grid for counting overlaps."""

DOOR_MATCH_M = 0.6
DOOR_FOREIGN_M = 1.2
DOOR_MATCH_RAD = float(np.deg2rad(35.0))
"""
Doors correspond within the first distance and the angle; unmatched beyond the second. Chosen.
"""


class Relation(IntFlag):
    """
    Relation of a submap region to the plan's regions; several flags may be set.

    A region without flags and with label ``UNMATCHED`` has no counterpart in the plan.
    """

    MATCHED = 1
    """The region has a counterpart: its label."""
    PARTIAL = 2
    """It covers less than :data:`WHOLE_SHARE` of the plan room with the largest overlap."""
    SPLIT = 4
    """One of several submap rooms inside one plan room; the largest one is its match."""
    MERGED = 8
    """It covers most of several plan rooms; the one with the largest overlap is its match."""


@dataclass(frozen=True, eq=False)
class Correspondences:
    """
    Ground truth matches of two segmentations, with the overlaps that determine them.

    Parameters
    ----------
    labels : (N,) int64
        Plan region of each submap region, or ``UNMATCHED`` or ``IGNORE``; one-to-one.
    relations : (N,) int8
        Flags of :class:`Relation`.
    overlap_pairs : (Q, 2) int64
        Indices of overlapping rooms, columns [plan, sub].
    overlap_m2 : (Q,) float32
        Their common area, in the plan's scale [m^2].
    """

    labels: NDArray[np.int64]
    relations: NDArray[np.int8]
    overlap_pairs: NDArray[np.int64]
    overlap_m2: NDArray[np.float32]


def label_regions(
    plan: Segmentation, sub: Segmentation, A_plan_submap: Affine2D
) -> Correspondences:
    """
    Return the ground truth plan region of each submap region.

    If the submap splits a plan room, the largest part is matched and the others are ``IGNORE``,
    like all regions that are neither clearly matched nor clearly unmatched.
    """
    overlap = overlap_m2(plan, sub, A_plan_submap)
    scale = abs(float(np.linalg.det(A_plan_submap.linear)))
    sub_area = np.array([room.area_m2 for room in sub.rooms]) * scale
    plan_area = np.array([room.area_m2 for room in plan.rooms])
    labels = np.concatenate(
        [_label_rooms(overlap, plan_area, sub_area), _label_doors(plan, sub, A_plan_submap)]
    )
    relations = np.where(labels >= 0, int(Relation.MATCHED), 0).astype(np.int8)
    relations[: len(sub_area)] |= _room_relations(overlap, plan_area, sub_area)
    rows, cols = np.nonzero(overlap)
    pairs = np.stack([cols, rows], axis=1).astype(np.int64)
    return Correspondences(labels, relations, pairs, overlap[rows, cols].astype(np.float32))


def overlap_m2(
    plan: Segmentation, sub: Segmentation, A_plan_submap: Affine2D
) -> NDArray[np.float64]:
    """Return common areas (sub rooms, plan rooms), in the plan's scale [m^2]."""
    count = len(sub.rooms), len(plan.rooms)
    stride = max(1, round(SAMPLE_M / sub.grid.resolution))
    rc = np.argwhere(sub.labels[::stride, ::stride] > 0) * stride
    source = sub.labels[rc[:, 0], rc[:, 1]] - 1
    target_rc = np.rint(plan.grid.xy_to_rc(A_plan_submap.apply(sub.grid.rc_to_xy(rc)))).astype(int)
    rows, cols = plan.grid.shape
    inside = ((target_rc >= 0) & (target_rc < (rows, cols))).all(axis=1)
    target = plan.labels[target_rc[inside, 0], target_rc[inside, 1]]
    flat = source[inside] * (count[1] + 1) + target
    table = np.bincount(flat, minlength=count[0] * (count[1] + 1))
    scale = abs(float(np.linalg.det(A_plan_submap.linear)))
    shares = table.reshape(count[0], count[1] + 1)[:, 1:]
    return np.asarray(shares * ((stride * sub.grid.resolution) ** 2 * scale))


def _label_rooms(
    overlap: NDArray[np.float64], plan_area: NDArray[np.float64], sub_area: NDArray[np.float64]
) -> NDArray[np.int64]:
    labels = np.full(len(sub_area), UNMATCHED, dtype=np.int64)
    if not overlap.size:
        return labels
    best = overlap.argmax(axis=1)
    shared = overlap[np.arange(len(best)), best]
    is_match = (shared > MATCH_OVERLAP * np.minimum(sub_area, plan_area[best])) & (
        shared > MATCH_INSIDE * sub_area
    )
    labels[shared > FOREIGN_OVERLAP * sub_area] = IGNORE
    for target in np.unique(best[is_match]).tolist():
        candidates = np.flatnonzero(is_match & (best == target))
        labels[candidates[shared[candidates].argmax()]] = target
    return labels


def _room_relations(
    overlap: NDArray[np.float64], plan_area: NDArray[np.float64], sub_area: NDArray[np.float64]
) -> NDArray[np.int8]:
    """Return the flags PARTIAL, SPLIT and MERGED of each submap room."""
    relations = np.zeros(len(sub_area), dtype=np.int8)
    if not overlap.size:
        return relations
    best = overlap.argmax(axis=1)
    shared = overlap[np.arange(len(best)), best]
    overlaps = shared > FOREIGN_OVERLAP * sub_area
    is_inside = overlap > MATCH_OVERLAP * sub_area[:, None]
    covers = overlap > MATCH_OVERLAP * plan_area
    relations[overlaps & (shared < WHOLE_SHARE * plan_area[best])] |= Relation.PARTIAL
    relations[is_inside[:, is_inside.sum(axis=0) > 1].any(axis=1)] |= Relation.SPLIT
    relations[covers.sum(axis=1) > 1] |= Relation.MERGED
    return relations


def _label_doors(
    plan: Segmentation, sub: Segmentation, A_plan_submap: Affine2D
) -> NDArray[np.int64]:
    labels = np.full(len(sub.doors), UNMATCHED, dtype=np.int64)
    if not plan.doors or not sub.doors:
        return labels
    plan_ends, sub_ends = _door_ends(plan), A_plan_submap.apply(_door_ends(sub))
    middle = sub_ends.mean(axis=1)[:, None] - plan_ends.mean(axis=1)[None]
    distance = np.linalg.norm(middle, axis=2)
    labels[distance.min(axis=1) < DOOR_FOREIGN_M] = IGNORE
    cost = distance + 1e3 * (_angle(sub_ends, plan_ends) > DOOR_MATCH_RAD)
    for i, j in zip(*linear_sum_assignment(np.minimum(cost, DOOR_FOREIGN_M)), strict=True):
        if cost[i, j] < DOOR_MATCH_M:
            labels[i] = plan.doors[j].id
    return labels


def _door_ends(segmentation: Segmentation) -> NDArray[np.float64]:
    """Return the opening lines (doors, 2, 2) in the order of the doors."""
    ends = {portal.door: portal.ends for portal in segmentation.portals}
    return np.stack([ends[door.id] for door in segmentation.doors])


def _angle(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angles (len(a), len(b)) in [0, pi / 2] between lines."""
    u, v = a[:, 1] - a[:, 0], b[:, 1] - b[:, 0]
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    return np.asarray(np.arccos(np.clip(np.abs(u @ v.T), 0.0, 1.0)))
