# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How a submap is found on a plan: the graph proposes, the raster verifies, the judge weighs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import Placements
from fpnet_core.judging import Judge, Verdict
from fpnet_core.localizer.scale import ScaleSearch
from fpnet_core.localizer.sides import RobotXY, StageTimer
from fpnet_core.matches import MatchResult
from fpnet_core.matching import RegionMatcher
from fpnet_core.pose import (
    MapSide,
    compared_at,
    propose,
    select_promising,
    verified_estimates,
)
from fpnet_core.pose.estimate import DISTINCT_M, MAX_ESTIMATES
from fpnet_core.pose.scales import estimates_across_scales

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
class Question:
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

    plan: MapSide
    sub: MapSide
    area_m2: float
    search: ScaleSearch
    tracked: Placements = field(default_factory=Placements.empty)
    robot_xy: RobotXY = None

    def verified(self, placements: Placements) -> Placements:
        """Return placements aligned with the walls and scored, the best of them."""
        return verified_estimates(
            self.plan.evidence, self.sub.evidence, placements, self.search.freedom, self.robot_xy
        )


@dataclass(frozen=True, eq=False)
class Comparison:
    """What one comparison of a submap with the plan found; by rasters, too: ``is_widened``."""

    match: MatchResult
    verdict: Verdict
    is_widened: bool = False

    @property
    def estimates(self) -> Placements:
        """Return the placements, most probable first."""
        return self.verdict.placements


@dataclass(frozen=True, eq=False)
class Finder:
    """Finds submaps on plans: a matcher, a judge and their configuration."""

    matcher: RegionMatcher
    judge: Judge
    config: FpnetConfig

    def is_claim(self, verdict: Verdict) -> bool:
        """Tell whether the best placement is as probable as a claim takes."""
        return verdict.best >= self.config.localizer.claim_probability

    def find(self, asked: Question, timer: StageTimer, enough: float | None = None) -> Comparison:
        """
        Match, propose, verify and judge: all placements worth knowing, most probable first.

        Where what the graph proposes leads to no claim, the rasters propose as well. Where the
        search doubts what was stated, both propose beyond it, too: what fits within may fit
        better there. ``timer`` receives the durations of stages; ``enough`` is the probability
        that is a claim, None takes the configured one of robots.
        """
        limit = self.config.localizer.claim_probability if enough is None else enough
        found = None
        for found in self.looks(asked, timer):
            if found.verdict.best >= limit:
                break
        assert found is not None  # there is a first look
        return self.doubted(asked, found, timer)

    def looks(self, asked: Question, timer: StageTimer) -> Iterator[Comparison]:
        """Yield what the graph leads to, then what the graph and the rasters lead to."""
        match, found = self._by_graph(asked, timer)
        verdict = self._judged(asked, found, match, timer)
        yield Comparison(match, verdict)
        yield self._by_both(asked, match, verdict.placements, timer)

    def find_rivals(self, asked: Question, timer: StageTimer) -> Comparison:
        """
        Return what the graph and the rasters lead to; the graph alone is not judged.

        For a drawing that is probably wrong, on which nothing will be claimed at first sight.
        """
        found = self._by_both(asked, *self._by_graph(asked, timer), timer)
        return self.doubted(asked, found, timer)

    def doubted(self, asked: Question, found: Comparison, timer: StageTimer) -> Comparison:
        """
        Return ``found`` with the placements that a scale beyond what was stated leads to.

        That is ``found`` itself where the search tries none.
        """
        search, match = asked.search, found.match
        if search.misstated is None:
            return found
        wide = replace(asked, search=search.misstated)
        with timer.stage('misstated'):
            known = asked.tracked.joined(found.estimates)
            placed = self._widened(wide, known.joined(self._proposed(wide, match)))
            doubt = self._judged(wide, placed, match, StageTimer())
            scale = doubt.placements.scale
            is_beyond = wide.search.is_within(scale) & ~search.is_within(scale)
            beyond = doubt.of(np.flatnonzero(is_beyond))
            # What was held at the bounds has been let go of in the doubt.
            stated = found.verdict.of(np.flatnonzero(search.is_within(found.estimates.scale)))
            both = self.judge.with_doubt(stated, beyond, search.log_odds)
            distinct = both.placements.distinct(
                compared_at(asked.sub.evidence, asked.robot_xy), DISTINCT_M, MAX_ESTIMATES
            )
            return Comparison(match, self.judge.reduced(both, distinct))

    def follow(self, asked: Question, match: MatchResult, timer: StageTimer) -> Comparison:
        """Verify and judge the tracked placements on new evidence, and look for no others."""
        with timer.stage('verify'):
            found = asked.verified(asked.tracked)
        return Comparison(match, self._judged(asked, found, match, timer))

    def _by_graph(self, asked: Question, timer: StageTimer) -> tuple[MatchResult, Placements]:
        """Return what the matcher says, and the verified placements that it leads to."""
        with timer.stage('match'):
            match = self.matcher.match(asked.plan.graph, asked.sub.graph, asked.area_m2)
        with timer.stage('propose'):
            promising = self._proposed(asked, match)
        with timer.stage('verify'):
            return match, asked.verified(asked.tracked.joined(promising))

    def _by_both(
        self, asked: Question, match: MatchResult, found: Placements, timer: StageTimer
    ) -> Comparison:
        """Return what the rasters lead to beside what was ``found`` by the graph."""
        with timer.stage('raster'):
            found = self._widened(asked, found)
        return Comparison(match, self._judged(asked, found, match, timer), True)

    def _proposed(self, asked: Question, match: MatchResult) -> Placements:
        plan, sub, search = asked.plan, asked.sub, asked.search
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
        return _assigned(match, search.factors).joined(promising)

    def _widened(self, asked: Question, found: Placements) -> Placements:
        """
        Return the best of the graph's and the rasters' placements.

        Every other scale will do: refinement closes the gaps, and time goes with their number.
        """
        from fpnet_core.pose.raster_search import search_placements  # loads SciPy's transforms

        plan, sub, search = asked.plan.evidence, asked.sub.evidence, asked.search
        raster = search_placements(plan, sub, search.factors[::2], _RASTER_CANDIDATES)
        return estimates_across_scales(
            plan, sub, found.joined(raster), search.freedom, asked.robot_xy
        )

    def _judged(
        self, asked: Question, found: Placements, match: MatchResult, timer: StageTimer
    ) -> Verdict:
        with timer.stage('judge'):
            return self.judge.judge(asked.plan, asked.sub, found, match, asked.search.log_range)


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
