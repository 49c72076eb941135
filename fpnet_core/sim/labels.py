# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which plan region each submap region really is, from the true transform."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from fpnet_core.geometry import Affine2D
from fpnet_core.types import IGNORE, UNMATCHED, Segmentation

MATCH_OVERLAP = 0.5
"""Rooms correspond where their overlap covers this much of the smaller one..."""

MATCH_INSIDE = 0.4
"""...and this much of the submap's room."""

FOREIGN_OVERLAP = 0.2
"""A submap room that overlaps no plan room by this much of itself has no partner."""

SAMPLE_M = 0.15
"""Overlaps are counted on a grid about this coarse."""

DOOR_MATCH_M = 0.6
DOOR_FOREIGN_M = 1.2
DOOR_MATCH_RAD = float(np.deg2rad(35.0))
"""Doors correspond within this distance and angle, and have no partner beyond the second."""


def label_regions(
    plan: Segmentation, sub: Segmentation, A_plan_submap: Affine2D
) -> NDArray[np.int64]:
    """
    Return for each submap region (N,) the plan region's id, ``UNMATCHED`` or ``IGNORE``.

    Labels are one-to-one. Where the submap splits a plan room, the largest part gets it and the
    others are ``IGNORE``, as is whatever is neither clearly a partner nor clearly foreign.
    """
    rooms = _label_rooms(plan, sub, A_plan_submap)
    doors = _label_doors(plan, sub, A_plan_submap)
    return np.concatenate([rooms, doors])


def overlap_m2(
    plan: Segmentation, sub: Segmentation, A_plan_submap: Affine2D
) -> NDArray[np.float64]:
    """Return areas (sub rooms, plan rooms) [m^2 of the plan] that rooms have in common."""
    count = len(sub.rooms), len(plan.rooms)
    stride = max(1, round(SAMPLE_M / sub.grid.resolution))
    rc = np.argwhere(sub.labels[::stride, ::stride] > 0) * stride
    source = sub.labels[rc[:, 0], rc[:, 1]] - 1
    target_rc = np.rint(plan.grid.xy_to_rc(A_plan_submap.apply(sub.grid.rc_to_xy(rc)))).astype(int)
    rows, cols = plan.grid.shape
    inside = ((target_rc >= 0) & (target_rc < (rows, cols))).all(axis=1)
    target = plan.labels[target_rc[inside, 0], target_rc[inside, 1]]
    flat = source[inside] * (count[1] + 1) + target
    table = np.bincount(flat, minlength=count[0] * (count[1] + 1)).reshape(count[0], -1)
    scale = abs(float(np.linalg.det(A_plan_submap.linear)))
    return np.asarray(table[:, 1:] * ((stride * sub.grid.resolution) ** 2 * scale))


def _label_rooms(
    plan: Segmentation, sub: Segmentation, A_plan_submap: Affine2D
) -> NDArray[np.int64]:
    labels = np.full(len(sub.rooms), UNMATCHED, dtype=np.int64)
    if not plan.rooms or not sub.rooms:
        return labels
    overlap = overlap_m2(plan, sub, A_plan_submap)
    scale = abs(float(np.linalg.det(A_plan_submap.linear)))
    sub_area = np.array([room.area_m2 for room in sub.rooms]) * scale
    plan_area = np.array([room.area_m2 for room in plan.rooms])
    best = overlap.argmax(axis=1)
    shared = overlap[np.arange(len(best)), best]
    is_match = (shared > MATCH_OVERLAP * np.minimum(sub_area, plan_area[best])) & (
        shared > MATCH_INSIDE * sub_area
    )
    labels[shared > FOREIGN_OVERLAP * sub_area] = IGNORE
    for target in np.unique(best[is_match]).tolist():
        rivals = np.flatnonzero(is_match & (best == target))
        labels[rivals[shared[rivals].argmax()]] = target
    return labels


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
