# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Features for and against each placement of a submap on a plan.

They cover walls at several widths, before and after a small smooth deformation of the plan; plan
walls contradicted by observed free space; plan walls not observed; whole rooms and doors; the
matcher's probabilities; and competitors, compared only where they disagree. The features do not
depend on the rotation or position of either map, nor on the order of the placements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import functools

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements
from fpnet_core.matches import MatchResult
from fpnet_core.pose import PreparedMap
from fpnet_core.pose.estimate import MAX_ESTIMATES
from fpnet_core.scoring.competing import Explained, rival_figures
from fpnet_core.scoring.regions import region_figures
from fpnet_core.scoring.walls import LookedAt, look_at, wall_figures

Array = NDArray[np.float64]

FIGURES = (
    'support_fine', 'support', 'support_wide', 'straight_support', 'straight_aligned',
    'residual_50', 'residual_75', 'residual_90', 'patches_unexplained', 'unexplained_m',
    'bent_support', 'bent_support_fine', 'bend_m', 'bend_rough_m', 'bend_gain',
    'contrast_mean', 'contrast_least',
    'seen_fine', 'seen', 'denied', 'denied_m', 'bent_seen', 'bent_denied',
    'outside', 'outside_m2', 'on_wall',
    'rooms_pure', 'plan_rooms_pure', 'rooms_alike', 'rooms_whole', 'plan_share',
    'doors_met', 'doors_near', 'doors_missing', 'doors_counted',
    'match_rooms', 'match_doors', 'match_whole',
    'log_scale', 'log_scale_size', 'strain', 'score', 'bent_score',
    'rival_net', 'rival_bent_net', 'rival_z', 'rival_contested', 'rival_score', 'rival_bent_score',
    'rival_doors', 'rival_rooms', 'rival_match', 'rival_denied',
)  # fmt: skip
"""Features of one placement, in the order of the columns."""

CONTEXT = (
    'log_walls_m', 'log_free_m2', 'log_rooms', 'log_doors', 'log_plan_m2', 'plan_density',
    'log_placements', 'scale_range', 'straightness', 'best_score', 'second_score', 'mean_score',
)  # fmt: skip
"""Features of the whole comparison."""

Figures = dict[str, Array]


@dataclass(frozen=True, eq=False)
class Evidence:
    """
    Features of ``C`` placements and of the comparison as a whole, float32.

    ``figures (C, len(FIGURES))`` and ``context (len(CONTEXT),)`` are in that order. ``explained``
    holds which walls each placement explains; None if it was discarded, and then placements on
    other plans cannot be compared.
    """

    figures: NDArray[np.float32]
    context: NDArray[np.float32]
    explained: Explained | None = None

    def take(self, index: NDArray[np.int64]) -> Evidence:
        """Return the evidence of the placements at ``index``, in that order."""
        kept = None if self.explained is None else self.explained.take(index)
        return Evidence(self.figures[index], self.context, kept)

    def joined(self, other: Evidence) -> Evidence:
        """Return the evidence of the placements of both, in the context of this one."""
        both = None
        if self.explained is not None and other.explained is not None:
            both = self.explained.joined(other.explained)
        return Evidence(np.concatenate([self.figures, other.figures]), self.context, both)

    @property
    def figures_only(self) -> Evidence:
        """The evidence without ``explained``: a hundredth of the memory."""
        return replace(self, explained=None)

    def of(self, name: str) -> NDArray[np.float32]:
        """Return one feature of every placement, ``(C,)``."""
        return self.figures[:, FIGURES.index(name)]

    def __len__(self) -> int:
        """Count the placements."""
        return len(self.figures)


def on_one_plan(drawn: Sequence[Evidence]) -> Evidence:
    """
    Return the evidence of one submap on several plans, treated as one plan, in their order.

    Placements on all plans compete, and the context covers all plans.
    """
    told = [each for each in drawn if len(each)] or drawn[:1]
    both = functools.reduce(Evidence.joined, told)
    if not len(both) or both.explained is None:
        return both
    named = {name: both.of(name).astype(np.float64) for name in FIGURES}
    named |= rival_figures(named, both.explained)
    figures = np.stack([named[name] for name in FIGURES], axis=1).astype(np.float32)
    whole = dict(zip(CONTEXT, both.context.astype(np.float64), strict=True))
    whole |= _of_all_drawings(told) | _contest(named['bent_score'])
    context = np.array([whole[name] for name in CONTEXT], dtype=np.float32)
    return Evidence(figures, context, both.explained)


def _of_all_drawings(told: Sequence[Evidence]) -> dict[str, float]:
    """Return the context features that depend on the plan, for all plans as one."""
    log_m2, density, straightness, scale_range = (
        np.array([each.context[CONTEXT.index(name)] for each in told], dtype=np.float64)
        for name in ('log_plan_m2', 'plan_density', 'straightness', 'scale_range')
    )
    area_m2 = np.expm1(log_m2)
    return {
        'log_plan_m2': np.log1p(area_m2.sum()),
        'plan_density': np.average(density, weights=np.maximum(area_m2, 1.0)),
        'straightness': np.average(straightness, weights=[len(each) for each in told]),
        'scale_range': scale_range.max(),
    }


def gather_evidence(
    plan: PreparedMap,
    sub: PreparedMap,
    placements: Placements,
    match: MatchResult,
    scale_range: float,
) -> Evidence:
    """
    Return the evidence of ``C`` placements.

    Parameters
    ----------
    plan, sub : both maps, in metres
    placements : any number, from the submap's metres to the plan's
    match : the matcher's result for the regions of both maps
    scale_range : logarithm of the ratio of the largest to the smallest scale searched

    Returns
    -------
    Evidence; zeros if there are no placements or the submap has no walls.
    """
    count = len(placements)
    if count == 0 or not len(sub.evidence.walls):
        return Evidence(
            np.zeros((count, len(FIGURES)), np.float32), np.zeros(len(CONTEXT), np.float32)
        )
    looked = look_at(plan.evidence, sub.evidence, placements)
    figures: Figures = wall_figures(plan, sub, placements, looked)
    figures |= region_figures(plan, sub, placements, looked, match)
    figures |= _placement_figures(placements)
    figures['score'] = _score(figures, '')
    figures['bent_score'] = _score(figures, 'bent_')
    explained = Explained(looked.likelihood, looked.bent_likelihood, looked.metres)
    figures |= rival_figures(figures, explained)
    columns = np.stack([figures[name] for name in FIGURES], axis=1)
    context = _context(plan, sub, figures, looked, scale_range)
    return Evidence(columns.astype(np.float32), context.astype(np.float32), explained)


def _placement_figures(placements: Placements) -> Figures:
    log_scale = np.log(placements.scale)
    stretch = np.linalg.svd(placements.linear, compute_uv=False)
    return {
        'log_scale': log_scale,
        'log_scale_size': np.abs(log_scale),
        'strain': np.log(stretch[:, 0] / stretch[:, 1]),
    }


def _score(figures: Figures, kind: str) -> Array:
    """Return the agreement of both maps' walls, minus the share of free space outside."""
    walls = np.sqrt(figures[kind + 'support'] * figures[kind + 'seen'])
    return np.asarray(walls - figures['outside'])


def _context(
    plan: PreparedMap, sub: PreparedMap, figures: Figures, looked: LookedAt, scale_range: float
) -> Array:
    drawn, seen = plan.evidence, sub.evidence
    named = {
        'log_walls_m': np.log1p(seen.wall_length_m),
        'log_free_m2': np.log1p(seen.free_area_m2),
        'log_rooms': np.log1p(len(sub.segmentation.rooms)),
        'log_doors': np.log1p(len(sub.segmentation.portals)),
        'log_plan_m2': np.log1p(drawn.free_area_m2),
        'plan_density': drawn.wall_length_m / max(drawn.free_area_m2, 1.0),
        'scale_range': scale_range,
        'straightness': looked.straight.mean(),
        **_contest(figures['bent_score']),
    }
    return np.array([named[name] for name in CONTEXT])


def _contest(bent_score: Array) -> dict[str, float]:
    """
    Return the number of placements and how the best of them compare.

    Only the best ``MAX_ESTIMATES`` count: training trials had one plan and no more placements.
    """
    ranked = np.sort(bent_score)[::-1][:MAX_ESTIMATES]
    return {
        'log_placements': float(np.log(len(ranked))),
        'best_score': float(ranked[0]),
        'second_score': float(ranked[1]) if len(ranked) > 1 else 0.0,
        'mean_score': float(ranked.mean()),
    }
