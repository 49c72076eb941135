# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The scale that texts of a drawing agree on: a distribution from votes of all kinds.

Each text casts a vote for each scale that it would have if it measured this line or that room.
Texts that say the same length are one witness, which saves room numbers and repeated axes from
agreeing with themselves. A witness is right with a probability that is not known and differs by
kind, so it is integrated out; one that is wrong votes as all votes are spread, which is broadly.
The most likely scale must beat the hypothesis that it is there by chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import groupby
import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

Array = NDArray[np.float64]


class VoteKind(StrEnum):
    """What a text is, in words of a sentence that counts them."""

    DIMENSION = 'dimension'
    AREA = 'room area'
    SIZE = 'room size'
    BAR = 'scale bar'
    PAPER = 'stated ratio'


@dataclass(frozen=True)
class Vote:
    """
    A scale that a text has if it measures one thing on the drawing.

    Parameters
    ----------
    log_scale : natural logarithm of metres per pixel
    kind : what the text is
    value : what it says [m], or the root of an area [m]
    text : number of the text among the drawing's labels
    unit : under which unit a bare number was read; empty where the text says it
    spread : standard deviation of ``log_scale`` if it measures that
    """

    log_scale: float
    kind: VoteKind
    value: float
    text: int
    unit: str = ''
    spread: float = 0.003


@dataclass(frozen=True)
class Consensus:
    """
    What texts say of a scale together.

    Parameters
    ----------
    resolution_m : most likely metres per pixel
    low_m, high_m : hold it with 90 % probability
    log_odds : natural logarithm of the odds against chance
    counts : texts that agree, by kind
    apart : by which share nine in ten of them differ from it at most
    typical_m : median of what they say [m]
    texts : numbers of the labels that agree
    """

    resolution_m: float
    low_m: float
    high_m: float
    log_odds: float
    counts: dict[VoteKind, int]
    apart: float
    typical_m: float
    texts: frozenset[int]

    @property
    def why(self) -> str:
        """Return in words what agrees: ``12 room areas and 7 dimensions agree within 2 %``."""
        said = [_counted(kind, n) for kind, n in self.counts.items()]
        listed = ' and '.join(filter(None, (', '.join(said[:-1]), said[-1])))
        within = max(1, math.ceil(100.0 * self.apart - 1e-9))
        is_one = sum(self.counts.values()) == 1
        return listed if is_one else f'{listed} agree within {within} %'


@dataclass(frozen=True)
class Prior:
    """What is known before texts are read: ``log_scale`` and its standard deviation."""

    log_scale: float
    spread: float


_STEP = 0.001  # numerical: of logarithms of scales; drawings' lines are exact to 0.003
_RESOLUTIONS_M = (5e-4, 1.0)  # physical: of a pixel of any drawing of a building
_RANGE = math.log(_RESOLUTIONS_M[1] / _RESOLUTIONS_M[0])  # numerical
_TEN = math.log(10.0)  # numerical: units of bare numbers differ by powers of it
_NEAR = 3.0  # numerical: standard deviations within which a vote is for a scale
_QUANTILES = (0.05, 0.95)  # given: of the interval
_RIGHT = np.array([0.1, 0.3, 0.6, 0.9])  # numerical: shares of a kind's witnesses that are right
# Chosen, not measured:
_SAME = 0.03  # lengths that differ less are the same
_FEWEST = 3  # witnesses where nothing else is known
_LOG_ODDS, _LOG_ODDS_WITH_PRIOR = math.log(1e3), math.log(1e2)  # against chance
_TYPICAL_M = 3.5  # length that a dimension gives
_BROAD = 0.5  # standard deviation of what wrong votes spread around all votes
_PRIOR_SHARE = 0.8  # of buildings are as the prior has them
_LOUD = {VoteKind.BAR: 1e4, VoteKind.PAPER: 1e3}
"""How much rarer than one wrong vote even ticks under numbers and round ratios are. Chosen."""
_COMMON = {
    VoteKind.DIMENSION: 0.005, VoteKind.BAR: 0.005, VoteKind.SIZE: 0.02, VoteKind.AREA: 0.02,
    VoteKind.PAPER: 0.01,
}  # fmt: skip
"""Standard deviation of the error that all votes of a kind share. Chosen."""
_CONTRADICTION = 0.5  # of the witnesses of a scale agree on another one
_AGREE = 0.04  # logarithm, within which two scales are no contradiction


def most_likely(votes: Sequence[Vote], prior: Prior | None = None) -> Consensus | None:
    """
    Return what votes agree on; None where chance explains them or they contradict.

    Bare numbers are read under one unit: the one with which most agrees, then as long as rooms
    are.
    """
    low, high = (math.log(each) for each in _RESOLUTIONS_M)
    votes = [vote for vote in votes if low < vote.log_scale < high]
    runs = [[vote for vote in votes if vote.unit in (unit, '')]
            for unit in sorted({vote.unit for vote in votes} | {''})]  # fmt: skip
    found = [each for each in (_found(run, prior) for run in runs) if each is not None]
    if not found:
        return None
    best = max(found, key=lambda each: _merit(each, prior))
    return None if any(_is_contradicted(run, best, prior) for run in runs) else best


def _merit(found: Consensus, prior: Prior | None) -> tuple[int, float]:
    """Return by what units compare: texts that agree, then odds or how usual lengths are."""
    usual = -abs(math.log(found.typical_m / _TYPICAL_M))
    return sum(found.counts.values()), usual if prior is None else found.log_odds


def _is_contradicted(votes: list[Vote], found: Consensus, prior: Prior | None) -> bool:
    """Tell whether the other texts agree on another scale, half as many at least."""
    others = [vote for vote in votes if vote.text not in found.texts]
    rival = _found(others, prior)
    if rival is None:
        return False
    apart = abs(math.log(rival.resolution_m / found.resolution_m))
    is_bare = all(vote.unit for vote in others if vote.text in rival.texts)
    # One storey of a sheet may be in centimetres and another one in millimetres.
    is_other_unit = is_bare and abs(apart - _TEN * round(apart / _TEN)) < _AGREE
    if apart < _AGREE or is_other_unit:
        return False
    loud = any(kind in _LOUD for kind in rival.counts)
    return loud or len(rival.texts) >= _CONTRADICTION * len(found.texts)


def _found(votes: list[Vote], prior: Prior | None) -> Consensus | None:
    witnesses = _witnesses(votes)
    if not witnesses:
        return None
    logs = np.array([vote.log_scale for vote in votes])
    grid = np.arange(logs.min() - 0.1, logs.max() + 0.1, _STEP)
    gain = _gain(witnesses, grid) + _log_prior(grid, prior)
    top = int(np.argmax(gain))
    near = np.abs(grid - grid[top]) < _AGREE
    won = float(np.logaddexp.reduce(gain[near]))
    lost = float(np.logaddexp.reduce([0.0, *gain[~near]]))
    supporting = [
        vote for vote in votes if abs(vote.log_scale - grid[top]) < _NEAR * vote.spread + _STEP
    ]
    least = _LOG_ODDS if prior is None else _LOG_ODDS_WITH_PRIOR
    if won - lost < least or not _is_enough(supporting, prior):
        return None
    return _agreement(grid[near], gain[near], won - lost, supporting)


def _is_enough(votes: list[Vote], prior: Prior | None) -> bool:
    """Tell whether more than one text stands for a scale, or one that states it as such."""
    if any(vote.kind in _LOUD for vote in votes):
        return True
    return len(_witnesses(votes)) >= (_FEWEST if prior is None else _FEWEST - 1)


def _witnesses(votes: list[Vote]) -> list[list[Vote]]:
    """Return votes of one kind that say the same length, together."""
    groups: list[list[Vote]] = []
    ordered = sorted(votes, key=lambda vote: (vote.kind, vote.value))
    for _, kind in groupby(ordered, key=lambda vote: vote.kind):
        first = 0.0
        for vote in kind:
            if vote.value > first * (1.0 + _SAME):
                groups.append([])
                first = vote.value
            groups[-1].append(vote)
    return groups


def _gain(witnesses: list[list[Vote]], grid: Array) -> Array:
    """Return by how much each scale of ``grid (S,)`` explains all votes better than chance."""
    spread = np.array([np.mean([vote.spread for vote in group]) for group in witnesses])
    density = np.zeros((len(witnesses), len(grid)))
    for row, group in enumerate(witnesses):
        at = (np.array([vote.log_scale for vote in group]) - grid[0]) / _STEP
        density[row] = np.bincount(np.rint(at).astype(int), minlength=len(grid))
        density[row] /= len(group) * _STEP
    broad = gaussian_filter1d(density.mean(axis=0), _BROAD / _STEP, mode='constant')
    chance = 0.5 / _RANGE + 0.5 * broad
    gain = np.zeros(len(grid))
    kinds = np.array([group[0].kind for group in witnesses])
    for kind in np.unique(kinds):
        rows = np.flatnonzero(kinds == kind)
        for row in rows.tolist():
            density[row] = gaussian_filter1d(density[row], spread[row] / _STEP, mode='constant')
        ratio = _LOUD.get(VoteKind(kind), 1.0) * density[rows] / chance
        by_share = [np.log(1.0 - p + p * ratio).sum(axis=0) for p in _RIGHT]
        gain += np.logaddexp.reduce(by_share, axis=0) - math.log(len(_RIGHT))
    return gain


def _log_prior(grid: Array, prior: Prior | None) -> Array:
    """Return the logarithm of the probability of each scale of ``grid (S,)`` before."""
    plain = _STEP / _RANGE
    if prior is None:
        return np.full(len(grid), math.log(plain))
    off = (grid - prior.log_scale) / prior.spread
    usual = np.exp(-0.5 * off**2) * _STEP / (prior.spread * math.sqrt(2.0 * math.pi))
    return np.asarray(np.log(_PRIOR_SHARE * usual + (1.0 - _PRIOR_SHARE) * plain))


def _agreement(grid: Array, gain: Array, odds: float, votes: list[Vote]) -> Consensus:
    """Return the distribution over scales near the best one, in a few numbers."""
    weight = np.exp(gain - gain.max())
    share = (np.cumsum(weight) - 0.5 * weight) / weight.sum()
    low, middle, high = np.interp((_QUANTILES[0], 0.5, _QUANTILES[1]), share, grid)
    kinds = {vote.kind for vote in votes}
    common = 1.645 * min(_COMMON[kind] for kind in kinds)
    off = [min(abs(v.log_scale - middle) for v in votes if v.text == text)
           for text in {vote.text for vote in votes}]  # fmt: skip
    counts = {
        kind: len({vote.text for vote in votes if vote.kind is kind})
        for kind in VoteKind
        if kind in kinds
    }
    return Consensus(
        resolution_m=math.exp(middle),
        low_m=math.exp(middle - math.hypot(middle - low, common)),
        high_m=math.exp(middle + math.hypot(high - middle, common)),
        log_odds=odds,
        counts=counts,
        apart=float(np.quantile(off, 0.9)),
        typical_m=float(np.median([vote.value for vote in votes])),
        texts=frozenset(vote.text for vote in votes),
    )


def _counted(kind: VoteKind, count: int) -> str:
    if kind in _LOUD and count == 1:
        return f'its {kind.value}'
    return f'{count} {kind.value}{"s" if count > 1 else ""}'
