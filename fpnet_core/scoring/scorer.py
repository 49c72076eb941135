# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Placement scorer: ranks placements and computes the posterior used for acceptance."""

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
Exponent of a storey's odds against a better one: walls differ more between storeys than between
places on one plan, which the scorer was trained on. Fitted by ``python
benchmarks/storey_contrast.py`` to 475 updates of 12 generated sites: 2.1, hardly worse from 1.5
to 3; no update is certain of a wrong storey.
"""

_RULED_OUT = 4.0
"""Chosen [nats]: storeys whose prior is this much lower than the best one's are ruled out."""

WORD = float(np.log(1e4))
"""
Chosen [nats]: log odds that a given pose is correct, its storey included. They select one of a
hundred rooms that look alike, at the probability required for acceptance; contradicting walls
outweigh them.
"""


@dataclass(frozen=True)
class OtherStoreys:
    """
    The other storeys of a site, besides the plan of a posterior, in logarithms.

    ``log_prior`` is the prior of this plan's storey relative to equally probable storeys, as many
    as it may be on;
    ``weight`` are the odds of all placements on the others against a plan of another building,
    each with the prior of its storey.
    """

    log_prior: float = 0.0
    weight: float = -np.inf


ALONE = OtherStoreys()
"""Given: there is only one plan."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """
    Posterior over a submap's ``C`` placements on a plan.

    ``placements`` and ``evidence`` are ranked, most probable first, the former with their
    probabilities; ``none`` is the probability that the plan is correct but the robot is at none of
    them, and ``foreign`` that the plan is of another building. ``weights (C,)`` are the log odds
    of the placements against a plan of another building, before the plan prior, and
    ``none_weight`` those of ``none``. ``mirror`` is the part of ``none`` that belongs to the
    plan's mirror image. ``beside`` holds the odds of the other storeys, and ``elsewhere`` the
    probability of all placements there.
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
        """Return the posterior of the placements at ``index`` only, not normalised again."""
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
        If the weights are missing, damaged, or made for other features.
    """
    return read_scorer(Path(config.scorer_weights) if config.scorer_weights else None)


class PlacementScorer:
    """
    Computes the probability of placements, of none of them, and of another building's plan.

    Parameters
    ----------
    model : the trained network
    plan_prior : prior probability that a plan is of the building the robot is in
    """

    def __init__(self, model: PlacementModel, plan_prior: float) -> None:
        self._model = model
        self.plan_prior = plan_prior

    @classmethod
    def configured(cls, config: LocalizerConfig) -> PlacementScorer:
        """
        Return the scorer that the configuration names, by default the packaged one.

        Raises
        ------
        WeightsError
            If the weights are missing, damaged, or made for other features.
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
        Return the posterior over all placements of ``sub`` on ``plan`` and over none.

        ``scale_range`` is the logarithm of the largest over the smallest scale searched.
        """
        evidence = gather_evidence(plan, sub, placements, match, scale_range)
        return self.weighed(placements, evidence)

    def weighed(self, placements: Placements, evidence: Evidence) -> Posterior:
        """Return the posterior for evidence that has been gathered."""
        weights = self._odds(evidence)
        return self.normalized(placements, evidence, weights[:-1], float(weights[-1]))

    def best_of(self, evidence: Evidence, right: NDArray[np.bool_]) -> tuple[float, bool]:
        """Return the probability of the best placement, and whether it is correct, ``(C,)``."""
        weights = self._odds(evidence)
        best = int(weights[:-1].argmax())
        return float(self._probabilities(weights[:-1], float(weights[-1]))[best]), bool(
            right[best]
        )

    def _reweighed(
        self, posterior: Posterior, none_weight: float, beside: OtherStoreys
    ) -> Posterior:
        """Return a posterior with unchanged weights, next to other storeys."""
        p = self._probabilities(posterior.weights, none_weight, beside)
        return replace(
            posterior,
            placements=replace(posterior.placements, probability=p[:-2]),
            none_weight=none_weight,
            none=float(p[-2]),
            foreign=float(p[-1]),
            beside=beside,
            elsewhere=_elsewhere(p, beside),
        )

    def normalized(
        self,
        placements: Placements,
        evidence: Evidence,
        weights: Array,
        none_weight: float,
        beside: OtherStoreys = ALONE,
    ) -> Posterior:
        """Return the posterior given by the ``weights`` of :class:`Posterior`."""
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
            elsewhere=_elsewhere(p, beside),
        )

    def among_storeys(
        self, drawn: Sequence[Posterior], log_priors: Sequence[float], is_fresh: Sequence[bool]
    ) -> list[Posterior]:
        """
        Return the posteriors of one submap's placements on the storeys of a site.

        The site counts as one plan: all placements compete where they disagree, and "none of
        these" refers to all. ``log_priors`` are relative to equally probable storeys. A storey
        that is not fresh keeps the weights found on an earlier submap, and walls are not compared
        with it. The first one is fresh. A storey ruled out by its prior does not compete with the
        others, just as placements far from a hinted pose do not.
        """
        least = max(log_priors) - _RULED_OUT
        fresh = [k for k, new in enumerate(is_fresh) if new and (not k or log_priors[k] >= least)]
        weights, none_weight = self._weighed_together([drawn[k] for k in fresh])
        weights_of = {
            **dict(enumerate(each.weights for each in drawn)),
            **dict(zip(fresh, weights, strict=True)),
        }
        totals = np.array([_log_sum(weights_of[k] + log_priors[k]) for k in range(len(drawn))])
        made = []
        for k, here in enumerate(drawn):
            beside = OtherStoreys(log_priors[k], _log_sum(np.delete(totals, k)))
            if weights_of[k] is here.weights:  # still ranked
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
        Return the weights of placements on plans that count as one, and that of none.

        Competitors on other storeys decide which placement is correct, not whether one is: the
        best storey is as probable against none as it is alone, and several share that by weight.
        """
        placed = [each for each in drawn if len(each.placements)]
        if len(placed) < 2:
            first = (placed or drawn)[0]
            return [each.weights for each in drawn], first.none_weight
        together = self._odds(on_one_plan([each.evidence for each in drawn]))
        alone = [self._odds(on_one_plan([each.evidence])) for each in drawn]
        counts = np.cumsum([len(each.placements) for each in drawn])
        # Weights that do not come from evidence are kept: the odds of the wide scale prior.
        weights = [
            odds + each.weights - own[:-1]
            for odds, each, own in zip(
                np.split(together[:-1], counts[:-1]), drawn, alone, strict=True
            )
        ]
        weights = _contrasted(weights)
        totals = np.array([_log_sum(each) for each in weights if len(each)])
        share = np.exp(totals - _log_sum(totals))
        more = share @ (np.array([_log_sum(each.weights) for each in placed]) - totals)
        none_weight = share @ np.array([each.none_weight for each in placed])
        return [each + more for each in weights], float(none_weight)

    def _odds(self, evidence: Evidence) -> Array:
        """Return the log odds ``(C + 1,)`` of each placement and none against another building."""
        log_p = self._model.log_probability(evidence)
        return np.asarray(log_p[:-1] - log_p[-1])

    def with_hint(
        self, posterior: Posterior, agrees: NDArray[np.bool_], log_odds: float = WORD
    ) -> Posterior:
        """
        Return the posterior after a hint that the placement is one that ``agrees (C,)``.

        ``log_odds`` are those of the hint being correct.
        Scale down hypotheses that disagree with the hint. The odds of none and of another building
        are unchanged, so that a hint proves nothing and never lowers the confidence.
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
        """Return the posterior without the placements that duplicate those at ``index``."""
        kept = posterior.of(index)
        return self.normalized(kept.placements, kept.evidence, kept.weights, kept.none_weight)

    def with_wide_prior(self, stated: Posterior, doubt: Posterior, log_odds: float) -> Posterior:
        """
        Return one posterior over the placements under two hypotheses about the scale.

        ``log_odds`` are those of the hypothesis of ``doubt`` against that of ``stated``.
        """
        return self.normalized(
            stated.placements.joined(doubt.placements),
            stated.evidence.joined(doubt.evidence),
            np.append(stated.weights, doubt.weights + log_odds),
            float(np.logaddexp(stated.none_weight, doubt.none_weight + log_odds)),
        )

    def against_mirror(self, drawn: Posterior, mirrored: Posterior, log_odds: float) -> Posterior:
        """
        Return ``drawn`` with the placements on the plan's mirror image as competitors.

        ``log_odds`` are those against a mirrored plan. The probability of the mirror image counts
        as none.
        """
        against = np.append(mirrored.weights - log_odds, drawn.none_weight)
        top = against.max()
        none_weight = float(top + np.log(np.exp(against - top).sum()))
        beside = drawn.beside
        p = self._probabilities(drawn.weights, none_weight, beside)
        ranked = replace(drawn.placements, probability=p[:-2])
        none, foreign = float(p[-2]), float(p[-1])
        mirror = none * float(1.0 - np.exp(drawn.none_weight - none_weight))
        left = _elsewhere(p, beside)
        return replace(
            drawn, placements=ranked, none=none, foreign=foreign, mirror=mirror, elsewhere=left
        )

    def _probabilities(
        self, weights: Array, none_weight: float, beside: OtherStoreys = ALONE
    ) -> Array:
        """
        Return ``(C + 2,)``: each placement, none anywhere, and another building.

        The rest to one is the probability of the placements on other storeys.
        """
        prior = np.log(self.plan_prior / (1.0 - self.plan_prior))
        logits = np.append(np.append(weights + beside.log_prior, none_weight) + prior, 0.0)
        elsewhere = beside.weight + prior
        top = max(logits.max(), elsewhere)
        share = np.exp(logits - top)
        return np.asarray(share / (share.sum() + np.exp(elsewhere - top)))


def _contrasted(weights: list[Array]) -> list[Array]:
    """Return storeys' weights, with those behind the best one lowered further."""
    best = [float(each.max()) if len(each) else -np.inf for each in weights]
    ahead = max(best, default=-np.inf)
    return [
        each + (STOREY_CONTRAST - 1.0) * (own - ahead) if len(each) else each
        for each, own in zip(weights, best, strict=True)
    ]


def _elsewhere(p: Array, beside: OtherStoreys) -> float:
    """Return the probability of the other storeys' placements."""
    return 0.0 if beside.weight == -np.inf else max(0.0, 1.0 - float(p.sum()))


def _log_sum(logs: Array) -> float:
    """Return the logarithm of the sum; minus infinity for nothing."""
    return float(np.logaddexp.reduce(logs))
