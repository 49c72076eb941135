# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Multi-floor posterior: an update concerns one storey, and the others compete with it.

Acceptance requires a search of each storey with at least half of the area observed by then. Until
then several are searched per update, oldest results first, afterwards one in turn. Likely storeys
are tracked on new walls, like competing placements on one storey; other results are kept. While a
placement is accepted with sufficient probability, only the required searches are made.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
import logging
import math

import numpy as np

from fpnet_core.config import FpnetConfig, ScalePolicy
from fpnet_core.errors import HintError, MapFormatError
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.localizer.cached_search import NEWS_GROWTH
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.global_localizer import GlobalLocalizer, MatchQuery
from fpnet_core.localizer.prepared_maps import RobotXY, StageTimer
from fpnet_core.pose import PreparedMap
from fpnet_core.scoring import WORD, Evidence, PlacementScorer, Posterior
from fpnet_core.scoring.evidence import CONTEXT, FIGURES
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.types import GridMap, Segmentation, Submap

logger = logging.getLogger(__name__)

# Chosen, not measured:
_SEARCHED_PER_UPDATE = 1  # other storeys per update; the search of one takes half of an update
_SEARCHED_BEFORE_ACCEPTANCE = 6  # a dozen storeys within two updates
_FOLLOWED = 3  # tracked placements on a storey that is not searched in this update
_MOST_FOLLOWED = 3  # storeys
_LIKELY = 1e-3  # probability from which a storey is tracked
_WELL_SEARCHED = 0.5  # share of the observed area that a search must have covered


@dataclass(frozen=True, eq=False)
class StoreyPlan:
    """
    Drawing of one storey: its ``name``, unique, and the prior on its scale.

    The other fields are as in :meth:`fpnet_core.localizer.floorplan.Floorplan.prepared`.
    """

    name: str
    grid: GridMap
    scale: ScaleEstimate | None = None
    policy: ScalePolicy | None = None
    segmentation: Segmentation | None = None


def prepared_storeys(storeys: Sequence[StoreyPlan], config: FpnetConfig) -> list[Floorplan]:
    """
    Return storeys segmented into rooms, with equal priors.

    Raises
    ------
    MapFormatError
        If a drawing contains no room, or there is none; the message names the storey.
    """
    if not storeys:
        raise MapFormatError('no floorplan was given; at least one is required')
    plans = []
    for each in storeys:
        try:
            plan = Floorplan.prepared(
                each.grid, config, each.scale, each.policy, each.segmentation
            )
        except MapFormatError as error:
            raise MapFormatError(
                f'storey {each.name!r}: {error}' if each.name else error
            ) from None
        plans.append(replace(plan, name=each.name))
        if plan.scale_conflict is not None:
            _warn_scale_conflict(plan.scale_conflict, each)
    return plans


def _warn_scale_conflict(scale_conflict: ScaleEstimate, storey: StoreyPlan) -> None:
    stated_m = storey.grid.resolution
    logger.warning(
        '%s: %s, but %.3g is stated; measure one length of it, or have its scale estimated '
        '(localizer.scale_policy: unknown)',
        f'storey {storey.name!r}' if storey.name else 'the floorplan',
        scale_conflict.said_at(stated_m),
        stated_m,
    )


def check_weights(weights: Mapping[str, float], plans: Sequence[Floorplan]) -> None:
    """Raise HintError unless weights are positive and cover exactly the storeys."""
    names = {plan.name for plan in plans}
    if unknown := sorted(set(weights) ^ names):
        raise HintError(
            f'{unknown[0]!r} is missing or unknown; expected {", ".join(sorted(names))}'
        )
    if not all(0.0 < weight < math.inf for weight in weights.values()):
        raise HintError('storey weights must be positive and finite')


@dataclass(frozen=True, eq=False)
class OtherStorey:
    """
    A storey other than that of the update.

    ``tracked`` are its placements, ``A_plan_odom`` in working metres; ``posterior`` is the last
    result, None before the first; ``searched_m2`` is the floor observed at its last complete
    search.
    """

    plan: Floorplan
    tracked: Placements = field(default_factory=Placements.empty)
    posterior: Posterior | None = None
    searched_m2: float = 0.0

    @property
    def probability(self) -> float:
        """Total probability of its placements."""
        return (
            0.0 if self.posterior is None else float(self.posterior.placements.probability.sum())
        )

    @property
    def best(self) -> float:
        """Probability of its best placement."""
        return 0.0 if self.posterior is None else self.posterior.best

    @property
    def said(self) -> tuple[str, float, float]:
        """Name, share of the walls that its best placement explains, and probability of that."""
        if self.posterior is None or not len(self.posterior.evidence):
            return self.plan.name, 0.0, 0.0
        return self.plan.name, float(self.posterior.evidence.of('support')[0]), self.best

    def is_searched(self, area_m2: float) -> bool:
        """Return whether it was searched with as much floor as acceptance requires."""
        return self.searched_m2 >= _WELL_SEARCHED * area_m2

    def forgotten(self) -> OtherStorey:
        """Return the storey without results."""
        return OtherStorey(self.plan)


@dataclass(frozen=True, eq=False)
class StoreyLook:
    """
    Inputs for updates of the other storeys.

    ``submap``, its prepared map ``sub`` and ``robot_xy`` are those of the update.
    """

    submap: Submap
    sub: PreparedMap
    global_localizer: GlobalLocalizer
    robot_xy: RobotXY

    def looked_at(
        self, others: Sequence[OtherStorey], is_settled: bool, searches: bool, timer: StageTimer
    ) -> tuple[tuple[OtherStorey, ...], list[bool]]:
        """
        Return the storeys after this update, and which of them have new results.

        ``is_settled``: a placement is accepted with sufficient probability; ``searches``: this
        update searches at all.
        """
        if not others:
            return (), []
        with timer.stage('storeys'):
            wanted = self._wanted(others, is_settled) if searches else []
            followed = self._followed(others)
            after, is_fresh = [], []
            for storey in others:
                is_searched = any(storey is each for each in wanted)
                is_fresh.append(is_searched or any(storey is each for each in followed))
                if is_searched:
                    after.append(self._searched(storey))
                else:
                    after.append(self._kept(storey) if is_fresh[-1] else storey)
            return tuple(after), is_fresh

    def _wanted(self, others: Sequence[OtherStorey], is_settled: bool) -> list[OtherStorey]:
        """
        Return the storeys to search in this update, those with the least area first.

        Storeys that block acceptance come first, up to a limit; while a placement is settled, one
        per update. If there are none and no placement is settled, one is searched in turn.
        """
        area_m2 = self.submap.free_area_m2
        due = [each for each in others if not each.is_searched(area_m2)]
        most = _SEARCHED_PER_UPDATE if is_settled else _SEARCHED_BEFORE_ACCEPTANCE
        if not due and not is_settled:
            due = [each for each in others if area_m2 >= NEWS_GROWTH * each.searched_m2]
            most = _SEARCHED_PER_UPDATE
        return sorted(due, key=lambda each: (each.searched_m2, -each.probability))[:most]

    def _followed(self, others: Sequence[OtherStorey]) -> list[OtherStorey]:
        likely = [each for each in others if each.probability >= _LIKELY]
        return sorted(likely, key=lambda each: -each.probability)[:_MOST_FOLLOWED]

    def _searched(self, storey: OtherStorey) -> OtherStorey:
        plan, area_m2 = storey.plan, self.submap.free_area_m2
        tracked = storey.tracked @ self.submap.T_odom_submap
        found = self.global_localizer.find(self._query(plan, tracked), StageTimer())
        return replace(
            storey,
            tracked=self._in_odom(found.estimates),
            posterior=found.posterior,
            searched_m2=area_m2,
        )

    def _kept(self, storey: OtherStorey) -> OtherStorey:
        """Return the storey with its best placements tracked on the current walls."""
        plan, tracked = storey.plan, storey.tracked.take(slice(_FOLLOWED))
        area_m2 = self.submap.free_area_m2
        match = self.global_localizer.matcher.match(plan.working.graph, self.sub.graph, area_m2)
        query = self._query(plan, tracked @ self.submap.T_odom_submap)
        found = self.global_localizer.follow(query, match, StageTimer())
        tracked = self._in_odom(found.estimates)
        return replace(storey, tracked=tracked, posterior=found.posterior)

    def _query(self, plan: Floorplan, tracked: Placements) -> MatchQuery:
        area_m2, search = self.submap.free_area_m2, plan.scale.search.as_stated
        return MatchQuery(plan.working, self.sub, area_m2, search, tracked, self.robot_xy)

    def _in_odom(self, found: Placements) -> Placements:
        in_odom: Placements = found @ self.submap.T_odom_submap.inv()
        return in_odom


def floor_posterior(
    scorer: PlacementScorer,
    here: Posterior,
    plan: Floorplan,
    others: Sequence[OtherStorey],
    is_fresh: Sequence[bool],
) -> tuple[Posterior, tuple[OtherStorey, ...]]:
    """
    Return the posteriors of ``plan`` and of the other storeys, weighed against each other.

    Likely storeys are weighed a second time without the unlikely ones.
    """
    if not others:  # a site with one storey is a plan
        return here, ()
    drawn = [here, *(each.posterior or _UNSEEN for each in others)]
    priors = [plan.log_prior, *(each.plan.log_prior for each in others)]
    fresh = [True, *is_fresh]
    posteriors = scorer.among_storeys(drawn, priors, fresh)
    # More plan area makes "none" more probable, so unlikely storeys must not count.
    likely = [
        new and (not k or float(each.placements.probability.sum()) >= _LIKELY)
        for k, (new, each) in enumerate(zip(fresh, posteriors, strict=True))
    ]
    if likely != fresh:
        drawn = [d if may else v for d, v, may in zip(drawn, posteriors, likely, strict=True)]
        posteriors = scorer.among_storeys(drawn, priors, likely)
    told = (
        each if each.posterior is None else replace(each, posterior=posterior)
        for each, posterior in zip(others, posteriors[1:], strict=True)
    )
    return posteriors[0], tuple(told)


_UNSEEN = Posterior(
    Placements.empty(),
    Evidence(np.zeros((0, len(FIGURES)), np.float32), np.zeros(len(CONTEXT), np.float32)),
    np.zeros(0),
    0.0,
    0.0,
    0.0,
)
"""Given: of a storey without results; as probable as another building."""


def weights_of_word(storey: str, names: Collection[str]) -> dict[str, float]:
    """Return the storeys' weights, of sum 1, given a hint that the robot is on one of them."""
    odds = {name: 1.0 if name == storey else math.exp(-WORD) for name in names}
    return {name: each / sum(odds.values()) for name, each in odds.items()}


def with_priors(plan: Floorplan, weights: Mapping[str, float]) -> Floorplan:
    """
    Return a storey with its prior from ``weights``, which need not sum to one.

    It is relative to equally probable storeys, as many as the perplexity of the weights. If only
    one storey is left, the site equals that plan and gains nothing from those ruled out.
    """
    share = np.array(list(weights.values())) / sum(weights.values())
    log_even = float(share @ np.log(share))
    log_share = math.log(weights[plan.name] / sum(weights.values()))
    return replace(plan, log_prior=log_share - log_even)


def unsearched(others: Sequence[OtherStorey], area_m2: float) -> int:
    """Count the storeys whose missing search blocks acceptance at this observed area."""
    return sum(not each.is_searched(area_m2) for each in others)


def probabilities(
    plan: Floorplan, posterior: Posterior, others: Sequence[OtherStorey]
) -> dict[str, float]:
    """Return the total probability of each storey's placements, by name."""
    here = float(posterior.placements.probability.sum())
    return {plan.name: here, **{each.plan.name: each.probability for each in others}}


def to_try(plan: Floorplan, starts: Mapping[str, Affine2D]) -> Placements:
    """Return the placement to try first on a storey, working metres; empty without one."""
    if plan.name not in starts:
        return Placements.empty()
    return Placements.of([plan.placed_in_working(starts[plan.name])])


def strongest(others: Sequence[OtherStorey]) -> OtherStorey | None:
    """Return the storey with the most probable placement; None without any placement."""
    placed = [each for each in others if each.best > 0.0]
    return max(placed, key=lambda each: each.best, default=None)
