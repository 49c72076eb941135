# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Alignment of regions by their oriented bounding boxes.

This is the published idea behind the paper's "Shahbandi" column, reimplemented: any pair of
corresponding rooms aligns two maps of the same rooms, since their bounding boxes give rotation
(up to half turns), scale and translation. Every pair of rooms of similar shape yields a
candidate; the placement with the most submap rooms on plan rooms of equal size wins.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import MatcherConfig
from fpnet_core.matches import MatchResult
from fpnet_core.matching.geometry import GraphGeometry, graph_geometry
from fpnet_core.matching.kernels import fit_regions, keep_one_per_plan_region
from fpnet_core.types import RegionGraph

Array = NDArray[np.float64]

ASPECT_SLACK = 0.25
"""
Largest difference of the log aspect ratios of the boxes of two corresponding rooms. Chosen.
"""

SCALE_SLACK = 0.5
"""Largest absolute log scale between the units of both maps that is tried. Chosen."""

MIN_FIT = 0.3
"""Smallest fit of a matched pair of regions under the winning placement. Chosen."""


class BoundingBoxMatcher:
    """Matcher that pairs overlapping regions under the best alignment of two rooms' boxes."""

    def __init__(self, config: MatcherConfig) -> None:
        del config  # unused: all matcher factories share one signature

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        """Return the pairs under the best placement; the score of a pair is its fit."""
        del explored_area_m2
        soft = np.zeros((len(plan), len(sub)), dtype=np.float32)
        nothing = MatchResult(np.zeros((0, 2), np.int64), np.zeros(0, np.float32), soft)
        if not (len(plan) and len(sub)):
            return nothing
        prepared_plan, prepared_submap = graph_geometry(plan), graph_geometry(sub)
        similarity = _alignments(prepared_plan, prepared_submap)
        if not len(similarity):
            return nothing
        partner, fit = _fitted(prepared_plan, prepared_submap, similarity)
        best = int(fit.sum(axis=1).argmax())
        columns = np.flatnonzero((partner[best] >= 0) & (fit[best] >= MIN_FIT))
        rows, scores = partner[best, columns], fit[best, columns]
        soft[rows, columns] = scores
        return MatchResult(np.stack([rows, columns], axis=1), scores.astype(np.float32), soft)


def _alignments(plan: GraphGeometry, sub: GraphGeometry) -> Array:
    """Return similarities ``(C, 4)`` that align a submap room's box with a plan room's box."""
    plan_box, sub_box = plan.box[~plan.is_door], sub.box[~sub.is_door]
    i, j = (index.ravel() for index in np.indices((len(plan_box), len(sub_box))))
    ratio = np.log(plan_box[i, 2:4]) - np.log(sub_box[j, 2:4])
    log_scale = ratio.mean(axis=1)
    similar = (np.abs(ratio[:, 0] - ratio[:, 1]) < ASPECT_SLACK) & (
        np.abs(log_scale) < SCALE_SLACK
    )
    i, j, scale = i[similar], j[similar], np.exp(log_scale[similar])
    yaw = plan_box[i, 4] - sub_box[j, 4]
    rows = [_placed(plan_box[i, :2], sub_box[j, :2], scale, yaw + turn) for turn in (0.0, np.pi)]
    return np.concatenate(rows)


def _placed(plan_xy: Array, sub_xy: Array, scale: Array, yaw: Array) -> Array:
    a, b = scale * np.cos(yaw), scale * np.sin(yaw)
    x = plan_xy[:, 0] - a * sub_xy[:, 0] + b * sub_xy[:, 1]
    y = plan_xy[:, 1] - b * sub_xy[:, 0] - a * sub_xy[:, 1]
    return np.column_stack([a, b, x, y])


def _fitted(
    plan: GraphGeometry, sub: GraphGeometry, similarity: Array
) -> tuple[NDArray[np.int64], Array]:
    """Return one-to-one partners and fits of the rooms; doors are left out."""
    partner = np.empty((len(similarity), len(sub)), dtype=np.int64)
    fit = np.empty((len(similarity), len(sub)))
    weight = np.ones((len(plan), len(sub)))
    weight[:, sub.is_door] = 0.0
    sides = (plan.point, plan.box, plan.is_door, sub.point, sub.box, sub.is_door)
    fit_regions(similarity, weight, *sides, partner, fit)
    keep_one_per_plan_region(partner, fit, len(plan))
    return partner, fit
