# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Global search for a submap: graph and rasters propose, alignment refines, the scorer ranks."""

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

# Numerical: larger values changed no result and took longer.
_MAX_PAIRS = 800  # region pairs of each kind that become candidates
# Chosen, not measured:
_FOCUSED_PAIRS = 250  # the same if the matcher has enough confident pairs
_SURE_PAIRS = 4  # number of pairs above the graded threshold that is enough

# Chosen, not measured:
_CENTROID_SHARE = 0.05  # scale error of an assignment by centroids of partly observed rooms
_RASTER_CANDIDATES = 96
"""Numerical: refined placements of the raster search; four to eight at each scale."""


@dataclass(frozen=True, eq=False)
class MatchQuery:
    """
    Search for the place of a submap on a plan.

    Parameters
    ----------
    plan, sub
        Both prepared maps.
    area_m2
        Observed floor; selects the graded threshold of the matcher.
    search
        Scales of the plan to try.
    tracked
        Placements of the last update, refined with the new ones.
    robot_xy : (2,)
        Position of the robot in the submap; None without one.
    """

    plan: PreparedMap
    sub: PreparedMap
    area_m2: float
    search: ScaleSearch
    tracked: Placements = field(default_factory=Placements.empty)
    robot_xy: RobotXY = None

    def aligned(self, placements: Placements) -> Placements:
        """Return the best placements after alignment with the walls, scored."""
        return aligned_placements(
            self.plan.evidence,
            self.sub.evidence,
            placements,
            self.search.alignment_prior,
            self.robot_xy,
        )


@dataclass(frozen=True, eq=False)
class Candidates:
    """Result of one comparison of a submap with the plan."""

    match: MatchResult
    posterior: Posterior

    @property
    def estimates(self) -> Placements:
        """Placements, most probable first."""
        return self.posterior.placements


@dataclass(frozen=True, eq=False)
class GlobalLocalizer:
    """Global search for submaps on plans, by a matcher and a placement scorer."""

    matcher: RegionMatcher
    scorer: PlacementScorer
    config: FpnetConfig

    def find(self, query: MatchQuery, timer: StageTimer) -> Candidates:
        """
        Match, propose, align and score; return all relevant placements, most probable first.

        Region graph and rasters both propose, so that a good placement does not hide a competing
        one. If the search has a wide scale prior, both propose at its scales, too. ``timer``
        receives the durations of the stages.
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
        Return ``found`` with the placements at scales beyond the stated range.

        Returns ``found`` itself if the search has no wide scale prior.
        """
        search, match = query.search, found.match
        if search.wide_scales is None:
            return found
        wide = replace(query, search=search.wide_scales)
        with timer.stage('wide_scales'):
            known = query.tracked.joined(found.estimates)
            placed = wide.aligned(known.joined(self._proposed(wide, match)))
            wider = self._scored(wide, placed, match, StageTimer())
            scale = wider.placements.scale
            is_beyond = wide.search.is_within(scale) & ~search.is_within(scale)
            beyond = wider.of(np.flatnonzero(is_beyond))
            # Placements stopped at the scale bounds are replaced by those of the wide prior.
            stated = found.posterior.of(np.flatnonzero(search.is_within(found.estimates.scale)))
            both = self.scorer.with_wide_prior(stated, beyond, search.log_odds)
            distinct = both.placements.distinct(
                compared_at(query.sub.evidence, query.robot_xy), DISTINCT_M, MAX_ESTIMATES
            )
            return Candidates(match, self.scorer.reduced(both, distinct))

    def follow(self, query: MatchQuery, match: MatchResult, timer: StageTimer) -> Candidates:
        """Align and score the tracked placements on new evidence, without a search."""
        with timer.stage('align'):
            found = query.aligned(query.tracked)
        return Candidates(match, self._scored(query, found, match, timer))

    def _proposed(self, query: MatchQuery, match: MatchResult) -> Placements:
        """
        Return the proposals of the graph, then those of the rasters.

        The rasters use every other scale: refinement closes the gaps, and the time is proportional
        to the number of scales.
        """
        from fpnet_core.pose.raster_search import search_placements  # loads scipy.fft

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

    All regions together determine the scale better than door widths do, so placements may exceed
    the range of scales by its own width, plus the error of the centroids.
    """
    margin = factors.max() / factors.min() * (1.0 + _CENTROID_SHARE)
    middle = np.sqrt(factors.min() * factors.max())
    low, high = middle / margin, middle * margin
    placed = (h.S_plan_sub for h in match.hypotheses)
    return Placements.of(S for S in placed if low <= S.scale <= high)
