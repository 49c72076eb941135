# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The one judge of placements: who ranks, weighs and claims asks it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Placements
from fpnet_core.matches import MatchResult
from fpnet_core.pose import PreparedMap
from fpnet_core.scoring.evidence import Evidence, gather_evidence, on_one_plan
from fpnet_core.scoring.model import PlacementModel, read_scorer

Array = NDArray[np.float64]

STOREY_CONTRAST = 2.0
"""
By how much more the walls tell between storeys than between places on one plan, which the judge
has learned: a storey's odds against a better one are taken to this power. Fitted by
``python benchmarks/storey_contrast.py`` to 475 ticks of 12 generated sites: 2.1, and hardly worse
from 1.5 to 3; no tick is sure of a wrong storey.
"""

_RULED_OUT = 4.0
"""Chosen [nats]: a storey so much less probable than the best one before looking is ruled out."""

WORD = float(np.log(1e4))
"""
Chosen [nats]: the odds that a pose given by somebody is right, its storey included. They decide
between a hundred rooms that look alike, at the probability that a claim takes; walls that
contradict weigh more.
"""


@dataclass(frozen=True)
class OtherStoreys:
    """
    The other storeys of a site beside the plan that a verdict is about, in logarithms.

    ``log_prior`` is how much more probable this plan's storey is before looking than each of as
    many even ones as it may be;
    ``weight`` are the odds of all placements on the others against a plan of another building,
    each with its own storey's prior.
    """

    log_prior: float = 0.0
    weight: float = -np.inf


ALONE = OtherStoreys()
"""Given: the plan is the only one."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """
    What is to be believed of a submap's ``C`` placements on a plan.

    ``placements`` and ``evidence`` are ranked, most probable first, the former with their
    probabilities; ``none`` is the probability that the plan is right but none of them, and
    ``foreign`` that the plan is of another building. ``weights (C,)`` are the placements' odds
    against a plan of another building before anything is known of the plan, in logarithms, and
    ``none_weight`` those of none here. ``mirror`` is the part of ``none`` that the plan's mirror
    image takes. ``beside`` is what other storeys weigh, and ``elsewhere`` the probability of all
    placements there.
    """

    placements: Placements
    evidence: Evidence
    weights: Array
    none_weight: float
    none: float
    foreign: float
    mirror: float = 0.0
    beside: OtherStoreys = ALONE
    elsewhere: float = 0.0

    def of(self, index: NDArray[np.int64]) -> Posterior:
        """Return the verdict on the placements at ``index`` only, as it stands."""
        return replace(
            self,
            placements=self.placements.take(index),
            evidence=self.evidence.take(index),
            weights=self.weights[index],
        )

    @property
    def best(self) -> float:
        """Probability of the best placement, 0 without any."""
        return float(self.placements.probability[0]) if len(self.placements) else 0.0


def configured_model(config: LocalizerConfig) -> PlacementModel:
    """
    Return the trained network that the configuration names, by default the packaged one.

    Raises
    ------
    WeightsError
        If the weights are missing, damaged, or made for other figures.
    """
    return read_scorer(Path(config.scorer_weights) if config.scorer_weights else None)


class PlacementScorer:
    """
    Tells the probability of placements, of none of them, and of another building's plan.

    Parameters
    ----------
    model : the trained network
    plan_prior : probability that a plan is of the building the robot is in, before looking
    """

    def __init__(self, model: PlacementModel, plan_prior: float) -> None:
        self._model = model
        self.plan_prior = plan_prior

    @classmethod
    def configured(cls, config: LocalizerConfig) -> PlacementScorer:
        """
        Return the judge that the configuration names, by default the packaged one.

        Raises
        ------
        WeightsError
            If the weights are missing, damaged, or made for other figures.
        """
        return cls(configured_model(config), config.plan_prior)

    def posterior(
        self,
        plan: PreparedMap,
        sub: PreparedMap,
        placements: Placements,
        match: MatchResult,
        scale_range: float,
    ) -> Posterior:
        """
        Weigh all placements of ``sub`` on ``plan`` against each other and against none.

        ``scale_range`` is the logarithm of the largest over the smallest scale that was searched.
        """
        evidence = gather_evidence(plan, sub, placements, match, scale_range)
        return self.weighed(placements, evidence)

    def weighed(self, placements: Placements, evidence: Evidence) -> Posterior:
        """Return the verdict on evidence that has been gathered."""
        weights = self._odds(evidence)
        return self.normalized(placements, evidence, weights[:-1], float(weights[-1]))

    def best_of(self, evidence: Evidence, right: NDArray[np.bool_]) -> tuple[float, bool]:
        """Return the probability of the best placement, and whether it is ``right (C,)``."""
        weights = self._odds(evidence)
        best = int(weights[:-1].argmax())
        return float(self._probabilities(weights[:-1], float(weights[-1]))[best]), bool(
            right[best]
        )

    def _reweighed(
        self, posterior: Posterior, none_weight: float, beside: OtherStoreys
    ) -> Posterior:
        """Return a verdict whose weights stand, beside others."""
        p = self._probabilities(posterior.weights, none_weight, beside)
        return replace(
            posterior,
            placements=replace(posterior.placements, probability=p[:-2]),
            none_weight=none_weight,
            none=float(p[-2]),
            foreign=float(p[-1]),
            beside=beside,
            elsewhere=_left(p, beside),
        )

    def normalized(
        self,
        placements: Placements,
        evidence: Evidence,
        weights: Array,
        none_weight: float,
        beside: OtherStoreys = ALONE,
    ) -> Posterior:
        """Return the verdict that follows from the ``weights`` of :class:`Posterior`."""
        order = np.argsort(-weights, kind='stable')
        p = self._probabilities(weights[order], none_weight, beside)
        return Posterior(
            replace(placements.take(order), probability=p[:-2]),
            evidence.take(order),
            weights[order],
            none_weight,
            float(p[-2]),
            float(p[-1]),
            beside=beside,
            elsewhere=_left(p, beside),
        )

    def among_storeys(
        self, drawn: Sequence[Posterior], log_priors: Sequence[float], is_fresh: Sequence[bool]
    ) -> list[Posterior]:
        """
        Return the verdicts on one submap's placements on the storeys of a site.

        The site counts as one plan: all placements are rivals, compared where they disagree, and
        "none of these" is said of all. ``log_priors`` are the storeys' against even ones. Of a
        storey that is not fresh, what was found on an earlier submap stands, and nobody compares
        walls with it. The first one is fresh. A storey that somebody has ruled out before looking
        is no rival to the others, as placements far from a given pose are none.
        """
        least = max(log_priors) - _RULED_OUT
        fresh = [k for k, new in enumerate(is_fresh) if new and (not k or log_priors[k] >= least)]
        weights, none_weight = self._weighed_together([drawn[k] for k in fresh])
        weights_of = {
            **dict(enumerate(each.weights for each in drawn)),
            **dict(zip(fresh, weights, strict=True)),
        }
        totals = np.array([_sum_of(weights_of[k] + log_priors[k]) for k in range(len(drawn))])
        made = []
        for k, here in enumerate(drawn):
            beside = OtherStoreys(log_priors[k], _sum_of(np.delete(totals, k)))
            if weights_of[k] is here.weights:  # they stay ranked
                made.append(self._reweighed(here, none_weight, beside))
            else:
                made.append(
                    self.normalized(
                        here.placements, here.evidence, weights_of[k], none_weight, beside
                    )
                )
        return made

    def _weighed_together(self, drawn: Sequence[Posterior]) -> tuple[list[Array], float]:
        """
        Return the weights of placements on drawings that count as one, and that of none.

        Rivals on other storeys tell which placement is right, and nothing of whether any is: the
        best storey is as probable against none as it is alone, and each of several in its share.
        """
        placed = [each for each in drawn if len(each.placements)]
        if len(placed) < 2:
            first = (placed or drawn)[0]
            return [each.weights for each in drawn], first.none_weight
        together = self._odds(on_one_plan([each.evidence for each in drawn]))
        alone = [self._odds(on_one_plan([each.evidence])) for each in drawn]
        counts = np.cumsum([len(each.placements) for each in drawn])
        # What no evidence tells stays: the odds of a scale that was doubted.
        weights = [
            odds + each.weights - own[:-1]
            for odds, each, own in zip(
                np.split(together[:-1], counts[:-1]), drawn, alone, strict=True
            )
        ]
        weights = _contrasted(weights)
        totals = np.array([_sum_of(each) for each in weights if len(each)])
        share = np.exp(totals - _sum_of(totals))
        more = share @ (np.array([_sum_of(each.weights) for each in placed]) - totals)
        none_weight = share @ np.array([each.none_weight for each in placed])
        return [each + more for each in weights], float(none_weight)

    def _odds(self, evidence: Evidence) -> Array:
        """Return ``(C + 1,)``: of each placement and of none against another building, in logs."""
        log_p = self._model.log_probability(evidence)
        return np.asarray(log_p[:-1] - log_p[-1])

    def with_hint(
        self, posterior: Posterior, agrees: NDArray[np.bool_], log_odds: float = WORD
    ) -> Posterior:
        """
        Return the verdict after someone's word that the placement is one that ``agrees (C,)``.

        ``log_odds`` are those of the word.
        The others lose; none of them here and another building stay as probable against those
        that agree as they were, so that a word proves nothing and never makes less sure.
        """
        weights = posterior.weights - np.where(agrees, 0.0, log_odds)
        return self.normalized(
            posterior.placements,
            posterior.evidence,
            weights,
            posterior.none_weight,
            posterior.beside,
        )

    def reduced(self, posterior: Posterior, index: NDArray[np.int64]) -> Posterior:
        """Return the verdict without placements that say the same as those at ``index``."""
        kept = posterior.of(index)
        return self.normalized(kept.placements, kept.evidence, kept.weights, kept.none_weight)

    def with_wide_prior(self, stated: Posterior, doubt: Posterior, log_odds: float) -> Posterior:
        """
        Return one verdict on the placements of two, which rest on different hypotheses.

        ``log_odds`` are those of what ``doubt`` supposes against what ``stated`` does.
        """
        return self.normalized(
            stated.placements.joined(doubt.placements),
            stated.evidence.joined(doubt.evidence),
            np.append(stated.weights, doubt.weights + log_odds),
            float(np.logaddexp(stated.none_weight, doubt.none_weight + log_odds)),
        )

    def against_mirror(self, drawn: Posterior, mirrored: Posterior, log_odds: float) -> Posterior:
        """
        Return ``drawn`` weighed against the placements on the plan's mirror image, too.

        ``log_odds`` are those against a plan that is drawn mirrored. What the mirror image takes
        counts as none here.
        """
        rivals = np.append(mirrored.weights - log_odds, drawn.none_weight)
        top = rivals.max()
        none_weight = float(top + np.log(np.exp(rivals - top).sum()))
        beside = drawn.beside
        p = self._probabilities(drawn.weights, none_weight, beside)
        ranked = replace(drawn.placements, probability=p[:-2])
        none, foreign = float(p[-2]), float(p[-1])
        mirror = none * float(1.0 - np.exp(drawn.none_weight - none_weight))
        left = _left(p, beside)
        return replace(
            drawn, placements=ranked, none=none, foreign=foreign, mirror=mirror, elsewhere=left
        )

    def _probabilities(
        self, weights: Array, none_weight: float, beside: OtherStoreys = ALONE
    ) -> Array:
        """
        Return ``(C + 2,)``: of each placement, of none anywhere, and of another building.

        What is missing to one is that of the placements on other storeys.
        """
        prior = np.log(self.plan_prior / (1.0 - self.plan_prior))
        logits = np.append(np.append(weights + beside.log_prior, none_weight) + prior, 0.0)
        elsewhere = beside.weight + prior
        top = max(logits.max(), elsewhere)
        share = np.exp(logits - top)
        return np.asarray(share / (share.sum() + np.exp(elsewhere - top)))


def _contrasted(weights: list[Array]) -> list[Array]:
    """Return storeys' weights with those of the ones behind the best one further behind it."""
    best = [float(each.max()) if len(each) else -np.inf for each in weights]
    ahead = max(best, default=-np.inf)
    return [
        each + (STOREY_CONTRAST - 1.0) * (own - ahead) if len(each) else each
        for each, own in zip(weights, best, strict=True)
    ]


def _left(p: Array, beside: OtherStoreys) -> float:
    """Return the probability that is left for the other storeys' placements."""
    return 0.0 if beside.weight == -np.inf else max(0.0, 1.0 - float(p.sum()))


def _sum_of(logs: Array) -> float:
    """Return the logarithm of the sum; that of nothing is minus infinity."""
    return float(np.logaddexp.reduce(logs))
