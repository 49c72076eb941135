# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How a submap is found on a plan: the graph proposes, the raster verifies, the judge weighs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

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

    def find(
        self,
        plan: MapSide,
        sub: MapSide,
        explored_area_m2: float,
        search: ScaleSearch,
        timer: StageTimer,
        tracked: Placements | None = None,
        robot_xy: RobotXY = None,
        enough: float | None = None,
    ) -> Comparison:
        """
        Match, propose, verify and judge: all placements worth knowing, most probable first.

        Where what the graph proposes leads to no claim, the rasters propose as well. Where
        ``search`` doubts what was stated, both propose beyond it, too: what fits within may fit
        better there.

        Parameters
        ----------
        plan, sub : both sides
        explored_area_m2 : observed free area, grades the matcher's threshold
        search : scales of the plan to try
        timer : receives stage durations
        tracked : placements from the previous tick, refined beside the new ones
        robot_xy : (2,) where the robot is in the submap, None without one
        enough : probability that is a claim; None takes the configured one of robots
        """
        limit = enough or self.config.localizer.claim_probability
        found = None
        for found in self.looks(plan, sub, explored_area_m2, search, timer, tracked, robot_xy):
            if found.verdict.best >= limit:
                break
        assert found is not None  # there is a first look
        return self.doubted(plan, sub, found, search, timer, tracked, robot_xy)

    def looks(
        self,
        plan: MapSide,
        sub: MapSide,
        explored_area_m2: float,
        search: ScaleSearch,
        timer: StageTimer,
        tracked: Placements | None = None,
        robot_xy: RobotXY = None,
    ) -> Iterator[Comparison]:
        """Yield what the graph leads to, then what the graph and the rasters lead to."""
        with timer.stage('match'):
            match = self.matcher.match(plan.graph, sub.graph, explored_area_m2)
        with timer.stage('propose'):
            promising = self._proposed(plan, sub, match, search)
        with timer.stage('verify'):
            if tracked is not None:
                promising = tracked.joined(promising)
            found = verified_estimates(
                plan.evidence, sub.evidence, promising, search.freedom, robot_xy
            )
        verdict = self._judged(plan, sub, found, match, search, timer)
        yield Comparison(match, verdict)
        with timer.stage('raster'):
            found = self._widened(plan, sub, verdict.placements, search, robot_xy)
        yield Comparison(match, self._judged(plan, sub, found, match, search, timer), True)

    def doubted(
        self,
        plan: MapSide,
        sub: MapSide,
        found: Comparison,
        search: ScaleSearch,
        timer: StageTimer,
        tracked: Placements | None = None,
        robot_xy: RobotXY = None,
    ) -> Comparison:
        """
        Return ``found`` with the placements that a scale beyond what was stated leads to.

        That is ``found`` itself where ``search`` tries none. Parameters are those of :meth:`find`.
        """
        wide, match = search.misstated, found.match
        if wide is None:
            return found
        with timer.stage('misstated'):
            known = found.estimates if tracked is None else tracked.joined(found.estimates)
            promising = known.joined(self._proposed(plan, sub, match, wide))
            placed = self._widened(plan, sub, promising, wide, robot_xy)
            doubt = self._judged(plan, sub, placed, match, wide, StageTimer())
            scale = doubt.placements.scale
            beyond = doubt.of(np.flatnonzero(wide.is_within(scale) & ~search.is_within(scale)))
            # What was held at the bounds has been let go of in the doubt.
            stated = found.verdict.of(np.flatnonzero(search.is_within(found.estimates.scale)))
            both = self.judge.with_doubt(stated, beyond, search.log_odds)
            distinct = both.placements.distinct(
                compared_at(sub.evidence, robot_xy), DISTINCT_M, MAX_ESTIMATES
            )
            return Comparison(match, self.judge.reduced(both, distinct))

    def follow(
        self,
        plan: MapSide,
        sub: MapSide,
        match: MatchResult,
        search: ScaleSearch,
        timer: StageTimer,
        tracked: Placements,
        robot_xy: RobotXY,
    ) -> Comparison:
        """Verify and judge the ``tracked`` placements on new evidence, and look for no others."""
        with timer.stage('verify'):
            found = verified_estimates(
                plan.evidence, sub.evidence, tracked, search.freedom, robot_xy
            )
        return Comparison(match, self._judged(plan, sub, found, match, search, timer))

    def _proposed(
        self, plan: MapSide, sub: MapSide, match: MatchResult, search: ScaleSearch
    ) -> Placements:
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

    def _widened(
        self,
        plan: MapSide,
        sub: MapSide,
        found: Placements,
        search: ScaleSearch,
        robot_xy: RobotXY,
    ) -> Placements:
        """
        Return the best of the graph's and the rasters' placements.

        Every other scale will do: refinement closes the gaps, and time goes with their number.
        """
        from fpnet_core.pose.raster_search import search_placements  # loads SciPy's transforms

        raster = search_placements(
            plan.evidence, sub.evidence, search.factors[::2], _RASTER_CANDIDATES
        )
        return estimates_across_scales(
            plan.evidence,
            sub.evidence,
            found.joined(raster),
            search.freedom,
            robot_xy,
        )

    def _judged(
        self,
        plan: MapSide,
        sub: MapSide,
        found: Placements,
        match: MatchResult,
        search: ScaleSearch,
        timer: StageTimer,
    ) -> Verdict:
        with timer.stage('judge'):
            return self.judge.judge(plan, sub, found, match, search.log_range)


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
