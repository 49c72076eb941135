# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The one judge of placements: who ranks, weighs and claims asks it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Placements
from fpnet_core.judging.evidence import Evidence, as_rivals, gather_evidence
from fpnet_core.judging.model import JudgeModel, read_judge
from fpnet_core.matches import MatchResult
from fpnet_core.pose import MapSide

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Beside:
    """
    The other storeys of a site beside the plan that a verdict is about, in logarithms.

    ``log_prior`` is the probability of this plan's storey before looking; ``weight`` and
    ``none_weight`` are the odds of the placements on the others, and of none there, against a
    plan of another building, each with its own storey's prior.
    """

    log_prior: float = 0.0
    weight: float = -np.inf
    none_weight: float = -np.inf


ALONE = Beside()
"""Given: the plan is the only one."""


@dataclass(frozen=True, eq=False)
class Verdict:
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
    beside: Beside = ALONE
    elsewhere: float = 0.0

    def of(self, index: NDArray[np.int64]) -> Verdict:
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


def configured_model(config: LocalizerConfig) -> JudgeModel:
    """
    Return the trained network that the configuration names, by default the packaged one.

    Raises
    ------
    WeightsError
        If the weights are missing, damaged, or made for other figures.
    """
    return read_judge(Path(config.judge_weights) if config.judge_weights else None)


class Judge:
    """
    Tells the probability of placements, of none of them, and of another building's plan.

    Parameters
    ----------
    model : the trained network
    plan_prior : probability that a plan is of the building the robot is in, before looking
    """

    def __init__(self, model: JudgeModel, plan_prior: float) -> None:
        self._model = model
        self.plan_prior = plan_prior

    @classmethod
    def configured(cls, config: LocalizerConfig) -> Judge:
        """
        Return the judge that the configuration names, by default the packaged one.

        Raises
        ------
        WeightsError
            If the weights are missing, damaged, or made for other figures.
        """
        return cls(configured_model(config), config.plan_prior)

    def judge(
        self,
        plan: MapSide,
        sub: MapSide,
        placements: Placements,
        match: MatchResult,
        scale_range: float,
    ) -> Verdict:
        """
        Weigh all placements of ``sub`` on ``plan`` against each other and against none.

        ``scale_range`` is the logarithm of the largest over the smallest scale that was searched.
        """
        evidence = gather_evidence(plan, sub, placements, match, scale_range)
        return self.weighed(placements, evidence)

    def weighed(self, placements: Placements, evidence: Evidence) -> Verdict:
        """Return the verdict on evidence that has been gathered."""
        log_p = self._model.log_probability(evidence)
        weights = log_p[:-1] - log_p[-1]
        return self.verdict(placements, evidence, weights[:-1], float(weights[-1]))

    def best_of(self, evidence: Evidence, right: NDArray[np.bool_]) -> tuple[float, bool]:
        """Return the probability of the best placement, and whether it is ``right (C,)``."""
        log_p = self._model.log_probability(evidence)
        weights = log_p[:-1] - log_p[-1]
        best = int(weights[:-1].argmax())
        return float(self._probabilities(weights[:-1], float(weights[-1]))[best]), bool(
            right[best]
        )

    def verdict(
        self,
        placements: Placements,
        evidence: Evidence,
        weights: Array,
        none_weight: float,
        beside: Beside = ALONE,
    ) -> Verdict:
        """Return the verdict that follows from the ``weights`` of :class:`Verdict`."""
        order = np.argsort(-weights, kind='stable')
        p = self._probabilities(weights[order], none_weight, beside)
        return Verdict(
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
        self, drawn: Sequence[Verdict], log_priors: Sequence[float], is_fresh: Sequence[bool]
    ) -> list[Verdict]:
        """
        Return the verdicts on one submap's placements on several storeys, one against another.

        Placements on other storeys are rivals like those on the same one: compared where they
        disagree. ``log_priors`` are the storeys', before looking. Of a storey that is not fresh,
        what was found on an earlier submap stands, and nobody compares walls with it.
        """
        weighed = self._weighed_as_rivals(drawn, is_fresh)
        totals = [float(logsumexp(np.append(each.weights, -np.inf))) for each in weighed]
        made = []
        for k, here in enumerate(weighed):
            others = [j for j in range(len(weighed)) if j != k]
            beside = Beside(
                log_priors[k],
                _sum_of([totals[j] + log_priors[j] for j in others]),
                _sum_of([weighed[j].none_weight + log_priors[j] for j in others]),
            )
            made.append(
                self.verdict(
                    here.placements, here.evidence, here.weights, here.none_weight, beside
                )
            )
        return made

    def _weighed_as_rivals(
        self, drawn: Sequence[Verdict], is_fresh: Sequence[bool]
    ) -> list[Verdict]:
        """Return the verdicts with the weights by which rivals on other storeys change them."""
        fresh = [k for k, is_new in enumerate(is_fresh) if is_new]
        compared = as_rivals([drawn[k].evidence for k in fresh])
        weighed = list(drawn)
        for k, evidence in zip(fresh, compared, strict=True):
            if evidence is drawn[k].evidence:
                continue
            before, after = (
                self._model.log_probability(each) for each in (drawn[k].evidence, evidence)
            )
            change = (after[:-1] - after[-1]) - (before[:-1] - before[-1])
            weighed[k] = replace(
                drawn[k],
                evidence=evidence,
                weights=drawn[k].weights + change[:-1],
                none_weight=drawn[k].none_weight + float(change[-1]),
            )
        return weighed

    def narrowed(self, verdict: Verdict, index: NDArray[np.int64]) -> Verdict:
        """Return the verdict where all placements but those at ``index`` are ruled out."""
        return self.weighed(verdict.placements.take(index), verdict.evidence.take(index))

    def reduced(self, verdict: Verdict, index: NDArray[np.int64]) -> Verdict:
        """Return the verdict without placements that say the same as those at ``index``."""
        kept = verdict.of(index)
        return self.verdict(kept.placements, kept.evidence, kept.weights, kept.none_weight)

    def with_doubt(self, stated: Verdict, doubt: Verdict, log_odds: float) -> Verdict:
        """
        Return one verdict on the placements of two, which rest on different hypotheses.

        ``log_odds`` are those of what ``doubt`` supposes against what ``stated`` does.
        """
        return self.verdict(
            stated.placements.joined(doubt.placements),
            stated.evidence.joined(doubt.evidence),
            np.append(stated.weights, doubt.weights + log_odds),
            float(np.logaddexp(stated.none_weight, doubt.none_weight + log_odds)),
        )

    def against_mirror(self, drawn: Verdict, mirrored: Verdict, log_odds: float) -> Verdict:
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
        of_none = np.logaddexp(none_weight + beside.log_prior, beside.none_weight)
        image = np.exp(none_weight + beside.log_prior - of_none) * (
            1.0 - np.exp(drawn.none_weight - none_weight)
        )
        mirror = none * float(image)
        left = _left(p, beside)
        return replace(
            drawn, placements=ranked, none=none, foreign=foreign, mirror=mirror, elsewhere=left
        )

    def _probabilities(self, weights: Array, none_weight: float, beside: Beside = ALONE) -> Array:
        """
        Return ``(C + 2,)``: of each placement, of none anywhere, and of another building.

        What is missing to one is that of the placements on other storeys.
        """
        prior = np.log(self.plan_prior / (1.0 - self.plan_prior))
        none = np.logaddexp(none_weight + beside.log_prior, beside.none_weight)
        logits = np.append(np.append(weights + beside.log_prior, none) + prior, 0.0)
        elsewhere = beside.weight + prior
        top = max(logits.max(), elsewhere)
        share = np.exp(logits - top)
        return np.asarray(share / (share.sum() + np.exp(elsewhere - top)))


def _left(p: Array, beside: Beside) -> float:
    """Return the probability that is left for the other storeys' placements."""
    return 0.0 if beside.weight == -np.inf else max(0.0, 1.0 - float(p.sum()))


def _sum_of(logs: Sequence[float]) -> float:
    """Return the logarithm of the sum; that of nothing is minus infinity."""
    return float(logsumexp(logs)) if len(logs) else -np.inf
