# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Candidate placements from soft region matches of the graphs.

A door pair determines a similarity up to scale and a half turn: its centre lies where two rooms
meet on both maps, even if little of the rooms was observed, and its opening line gives the
direction. A room pair determines it up to scale and quarter turns. Pairs are used in order of the
matcher's probability until the budget is spent, so a good matcher makes the search fast and a
poor one only slows it down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements, rotation
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.types import RegionLabel, Segmentation

# Chosen, not measured:
_SNAP_RAD = np.deg2rad(15.0)  # largest deviation of a door's direction that is snapped
_SNAP_STRENGTH = 0.35  # orientation strength of both maps required to snap yaw


@dataclass(frozen=True, eq=False)
class _Anchors:
    """Region pairs with a point in each map and the admissible rotations."""

    plan_xy: NDArray[np.float64]  # (K, 2)
    sub_xy: NDArray[np.float64]  # (K, 2)
    yaw: NDArray[np.float64]  # (K,) one row per admissible rotation


def propose(
    plan: Segmentation,
    sub: Segmentation,
    probability: NDArray[np.float32],
    plan_evidence: MapEvidence,
    sub_evidence: MapEvidence,
    stretches: NDArray[np.float64],
    max_pairs: int,
) -> Placements:
    """
    Return candidates anchored at doors and rooms, at most ``6 * max_pairs * len(stretches)``.

    Parameters
    ----------
    plan, sub : both segmentations; without regions in either there are no candidates
    probability : (M, N) soft assignment of all regions, columns as in ``sub.regions``
    plan_evidence, sub_evidence : for the dominant wall directions
    stretches : (L, 2, 2) symmetric, plan metres per submap metre in the plan's axes, to try
    max_pairs : budget of region pairs of each kind, most probable first
    """
    grid_yaw = _rectangular_yaw(plan_evidence, sub_evidence)
    doors = _door_anchors(plan, sub, probability, max_pairs, grid_yaw)
    rooms = _room_anchors(plan, sub, probability, max_pairs, grid_yaw)
    return _placements(doors, stretches).joined(_placements(rooms, stretches))


def _rectangular_yaw(plan: MapEvidence, sub: MapEvidence) -> float | None:
    """Return the rotation (mod 90 degrees) that aligns the wall directions; None without one."""
    if min(plan.orientation_strength, sub.orientation_strength) < _SNAP_STRENGTH:
        return None
    return plan.orientation - sub.orientation


def _ranked_pairs(
    plan: Segmentation,
    sub: Segmentation,
    label: RegionLabel,
    probability: NDArray[np.float32],
    max_pairs: int,
) -> NDArray[np.int64]:
    """Return region id pairs (K, 2) of one label, most probable first."""
    plan_ids = np.array([r.id for r in plan.regions if r.label is label], dtype=np.int64)
    sub_ids = np.array([r.id for r in sub.regions if r.label is label], dtype=np.int64)
    if len(plan_ids) == 0 or len(sub_ids) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    block = probability[np.ix_(plan_ids, sub_ids)]
    order = np.argsort(-block, axis=None, kind='stable')[:max_pairs]
    i, j = np.unravel_index(order, block.shape)
    return np.stack([plan_ids[i], sub_ids[j]], axis=1)


def _door_anchors(
    plan: Segmentation,
    sub: Segmentation,
    probability: NDArray[np.float32],
    max_pairs: int,
    grid_yaw: float | None,
) -> _Anchors:
    pairs = _ranked_pairs(plan, sub, RegionLabel.DOOR, probability, max_pairs)
    plan_mid, plan_dir = _door_lines(plan)
    sub_mid, sub_dir = _door_lines(sub)
    yaw = plan_dir[pairs[:, 0]] - sub_dir[pairs[:, 1]]
    if grid_yaw is not None:
        yaw = _snapped(yaw, grid_yaw)
    return _Anchors(
        np.tile(plan_mid[pairs[:, 0]], (2, 1)),
        np.tile(sub_mid[pairs[:, 1]], (2, 1)),
        np.concatenate([yaw, yaw + np.pi]),
    )


def _door_lines(segmentation: Segmentation) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return centre (R, 2) and direction (R,) of each door's opening line, NaN for rooms."""
    mid = np.full((len(segmentation.regions), 2), np.nan)
    direction = np.full(len(segmentation.regions), np.nan)
    doors = [portal.door for portal in segmentation.portals]
    ends = np.array([portal.ends for portal in segmentation.portals]).reshape(-1, 2, 2)
    along = ends[:, 1] - ends[:, 0]
    mid[doors] = ends.mean(axis=1)
    direction[doors] = np.arctan2(along[:, 1], along[:, 0])
    return mid, direction


def _snapped(yaw: NDArray[np.float64], grid_yaw: float) -> NDArray[np.float64]:
    """Return yaw snapped to the nearest multiple of 90 degrees from ``grid_yaw`` if close."""
    quarter = np.pi / 2
    nearest = grid_yaw + quarter * np.round((yaw - grid_yaw) / quarter)
    return np.where(np.abs(nearest - yaw) < _SNAP_RAD, nearest, yaw)


def _room_anchors(
    plan: Segmentation,
    sub: Segmentation,
    probability: NDArray[np.float32],
    max_pairs: int,
    grid_yaw: float | None,
) -> _Anchors:
    pairs = _ranked_pairs(plan, sub, RegionLabel.ROOM, probability, max_pairs)
    plan_xy = np.array([r.centroid for r in plan.regions]).reshape(-1, 2)[pairs[:, 0]]
    sub_xy = np.array([r.centroid for r in sub.regions]).reshape(-1, 2)[pairs[:, 1]]
    if grid_yaw is None:
        yaw = _principal_yaw(plan)[pairs[:, 0]] - _principal_yaw(sub)[pairs[:, 1]]
    else:
        yaw = np.full(len(pairs), grid_yaw)
    turns = np.arange(4) * np.pi / 2
    return _Anchors(
        np.tile(plan_xy, (4, 1)),
        np.tile(sub_xy, (4, 1)),
        (yaw[None, :] + turns[:, None]).ravel(),
    )


def _principal_yaw(segmentation: Segmentation) -> NDArray[np.float64]:
    """Return the direction (R,) of each region's longer side, by its vertices' second moments."""
    yaw = np.zeros(len(segmentation.regions))
    for region in segmentation.regions:
        centred = region.polygon - region.polygon.mean(axis=0)
        _, _, axes = np.linalg.svd(centred, full_matrices=False)
        yaw[region.id] = np.arctan2(axes[0, 1], axes[0, 0])
    return yaw


def _placements(anchors: _Anchors, stretches: NDArray[np.float64]) -> Placements:
    """Return the placements of all anchors at all stretches; stretch is the outer loop."""
    linear = (stretches[:, None] @ rotation(anchors.yaw)).reshape(-1, 2, 2)
    plan_xy, sub_xy = (
        np.tile(anchors.plan_xy, (len(stretches), 1)),
        np.tile(anchors.sub_xy, (len(stretches), 1)),
    )
    return Placements(linear, plan_xy - np.einsum('cij,cj->ci', linear, sub_xy))
