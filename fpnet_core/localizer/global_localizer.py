# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How a submap is found on a plan: the graph proposes, the raster verifies, the judge weighs."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import Placements
from fpnet_core.localizer.prepared_maps import RobotXY, StageTimer
from fpnet_core.localizer.scale import ScaleSearch
from fpnet_core.matches import MatchResult
from fpnet_core.matching import RegionMatcher
from fpnet_core.pose import (
    PreparedMap,
    aligned_placements,
    compared_at,
    propose,
    select_promising,
)
from fpnet_core.pose.estimate import DISTINCT_M, MAX_ESTIMATES
from fpnet_core.scoring import PlacementScorer, Posterior

# Numerical: more changed no answer and took longer.
_MAX_PAIRS = 800  # region pairs of each kind that become candidates
# Chosen, not measured:
_FOCUSED_PAIRS = 250  # the same once the matcher is sure of enough pairs
_SURE_PAIRS = 4  # above the graded threshold are enough

# Chosen, not measured:
_CENTROID_SHARE = 0.05  # centroids of half-seen rooms move the scale of an assignment by this
_RASTER_CANDIDATES = 96
"""Numerical: placements of the raster search that are refined; four to eight at each scale."""


@dataclass(frozen=True, eq=False)
class MatchQuery:
    """
    Where does a submap lie on a plan?

    Parameters
    ----------
    plan, sub
        Both sides.
    area_m2
        Floor that was seen; grades the matcher's threshold.
    search
        Scales of the plan to try.
    tracked
        Placements from the last tick, refined beside the new ones.
    robot_xy : (2,)
        Where the robot is in the submap; None without one.
    """

    plan: PreparedMap
    sub: PreparedMap
    area_m2: float
    search: ScaleSearch
    tracked: Placements = field(default_factory=Placements.empty)
    robot_xy: RobotXY = None

    def aligned(self, placements: Placements) -> Placements:
        """Return placements aligned with the walls and scored, the best of them."""
        return aligned_placements(
            self.plan.evidence,
            self.sub.evidence,
            placements,
            self.search.alignment_prior,
            self.robot_xy,
        )


@dataclass(frozen=True, eq=False)
class Candidates:
    """What one comparison of a submap with the plan found."""

    match: MatchResult
    posterior: Posterior

    @property
    def estimates(self) -> Placements:
        """Return the placements, most probable first."""
        return self.posterior.placements


@dataclass(frozen=True, eq=False)
class GlobalLocalizer:
    """Finds submaps on plans: a matcher, a judge and their configuration."""

    matcher: RegionMatcher
    scorer: PlacementScorer
    config: FpnetConfig

    def find(self, query: MatchQuery, timer: StageTimer) -> Candidates:
        """
        Match, propose, align and judge: all placements worth knowing, most probable first.

        The region graph and the rasters both propose, so that no competing hypothesis stays
        hidden behind one that fits. Where the search doubts the scale that was stated, both
        propose beyond it, too. ``timer`` receives the durations of the stages.
        """
        with timer.stage('match'):
            match = self.matcher.match(query.plan.graph, query.sub.graph, query.area_m2)
        with timer.stage('propose'):
            proposed = query.tracked.joined(self._proposed(query, match))
        with timer.stage('align'):
            found = query.aligned(proposed)
        return self.with_wide_scales(
            query, Candidates(match, self._scored(query, found, match, timer)), timer
        )

    def with_wide_scales(
        self, query: MatchQuery, found: Candidates, timer: StageTimer
    ) -> Candidates:
        """
        Return ``found`` with the placements that a scale beyond what was stated leads to.

        That is ``found`` itself where the search tries none.
        """
        search, match = query.search, found.match
        if search.wide_scales is None:
            return found
        wide = replace(query, search=search.wide_scales)
        with timer.stage('misstated'):
            known = query.tracked.joined(found.estimates)
            placed = wide.aligned(known.joined(self._proposed(wide, match)))
            doubt = self._scored(wide, placed, match, StageTimer())
            scale = doubt.placements.scale
            is_beyond = wide.search.is_within(scale) & ~search.is_within(scale)
            beyond = doubt.of(np.flatnonzero(is_beyond))
            # What was held at the bounds has been let go of in the doubt.
            stated = found.posterior.of(np.flatnonzero(search.is_within(found.estimates.scale)))
            both = self.scorer.with_wide_prior(stated, beyond, search.log_odds)
            distinct = both.placements.distinct(
                compared_at(query.sub.evidence, query.robot_xy), DISTINCT_M, MAX_ESTIMATES
            )
            return Candidates(match, self.scorer.reduced(both, distinct))

    def follow(self, query: MatchQuery, match: MatchResult, timer: StageTimer) -> Candidates:
        """Verify and judge the tracked placements on new evidence, and look for no others."""
        with timer.stage('align'):
            found = query.aligned(query.tracked)
        return Candidates(match, self._scored(query, found, match, timer))

    def _proposed(self, query: MatchQuery, match: MatchResult) -> Placements:
        """
        Return what the graph proposes, then what the rasters do.

        The rasters try every other scale: refinement closes the gaps, and time goes with their
        number.
        """
        from fpnet_core.pose.raster_search import search_placements  # loads SciPy's transforms

        plan, sub, search = query.plan, query.sub, query.search
        is_sure = len(match.pairs) >= _SURE_PAIRS
        candidates = propose(
            plan.segmentation,
            sub.segmentation,
            match.probability,
            plan.evidence,
            sub.evidence,
            search.stretches,
            _FOCUSED_PAIRS if is_sure else _MAX_PAIRS,
        )
        promising = select_promising(plan.evidence, sub.evidence, candidates)
        by_graph = _assigned(match, search.factors).joined(promising)
        by_raster = search_placements(
            plan.evidence, sub.evidence, search.factors[::2], _RASTER_CANDIDATES
        )
        return by_graph.joined(by_raster)

    def _scored(
        self, query: MatchQuery, found: Placements, match: MatchResult, timer: StageTimer
    ) -> Posterior:
        with timer.stage('score'):
            return self.scorer.posterior(
                query.plan, query.sub, found, match, query.search.log_range
            )


def _assigned(match: MatchResult, factors: NDArray[np.float64]) -> Placements:
    """
    Return the placements of the matcher's complete assignments.

    All regions together know the scale better than door widths do, so they may leave the range
    of scales to try by as much again, and by what their centroids may be off.
    """
    margin = factors.max() / factors.min() * (1.0 + _CENTROID_SHARE)
    middle = np.sqrt(factors.min() * factors.max())
    low, high = middle / margin, middle * margin
    placed = (h.S_plan_sub for h in match.hypotheses)
    return Placements.of(S for S in placed if low <= S.scale <= high)
