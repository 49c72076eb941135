# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Consensus of a drawing's texts on its scale: a distribution from votes of all kinds.

Each text votes for every scale that it implies if it measures a given line or room. Texts with
the same length count as one witness, so that room numbers and repeated axes do not confirm
themselves. The probability that a witness is right is unknown and differs by kind, so it is
integrated out; wrong witnesses follow the broad distribution of all votes. The most likely scale
must beat the hypothesis of agreement by chance.
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
    """Kind of a text; the value is its noun in messages."""

    DIMENSION = 'dimension'
    AREA = 'room area'
    SIZE = 'room size'
    BAR = 'scale bar'
    PAPER = 'stated ratio'


@dataclass(frozen=True)
class Vote:
    """
    Scale that a text implies if it measures one element of the drawing.

    Parameters
    ----------
    log_scale : natural logarithm of metres per pixel
    kind : kind of the text
    value : stated length [m], or root of a stated area [m]
    text : index of the text in the drawing's labels
    unit : unit assumed for a bare number; empty if the text states it
    spread : standard deviation of ``log_scale`` if the assignment is right
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
    Scale that texts agree on.

    Parameters
    ----------
    resolution_m : most likely metres per pixel
    low_m, high_m : 90 % interval
    log_odds : natural logarithm of the odds against chance
    counts : number of agreeing texts by kind
    apart : 90 % quantile of their relative deviation
    typical_m : median of the stated lengths [m]
    texts : indices of the agreeing labels
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
        """Summary of the agreeing texts: ``12 room areas and 7 dimensions agree within 2 %``."""
        parts = [_counted(kind, n) for kind, n in self.counts.items()]
        listed = ' and '.join(filter(None, (', '.join(parts[:-1]), parts[-1])))
        within = max(1, math.ceil(100.0 * self.apart - 1e-9))
        is_one = sum(self.counts.values()) == 1
        return listed if is_one else f'{listed} agree within {within} %'


@dataclass(frozen=True)
class Prior:
    """Prior of the scale: ``log_scale`` and its standard deviation."""

    log_scale: float
    spread: float


_STEP = 0.001  # numerical: step of log scales; lines of drawings are exact to 0.003
_RESOLUTIONS_M = (5e-4, 1.0)  # physical: metres per pixel of any drawing of a building
_RANGE = math.log(_RESOLUTIONS_M[1] / _RESOLUTIONS_M[0])  # numerical
_TEN = math.log(10.0)  # numerical: units of bare numbers differ by powers of ten
_NEAR = 3.0  # numerical: standard deviations within which a vote supports a scale
_QUANTILES = (0.05, 0.95)  # given: of the interval
_RIGHT = np.array([0.1, 0.3, 0.6, 0.9])  # numerical: assumed shares of right witnesses of a kind
# Chosen, not measured:
_SAME = 0.03  # relative difference of lengths that count as equal
_FEWEST = 3  # smallest number of witnesses without a prior
_LOG_ODDS, _LOG_ODDS_WITH_PRIOR = math.log(1e3), math.log(1e2)  # against chance
_TYPICAL_M = 3.5  # typical length of a dimension
_BROAD = 0.5  # standard deviation of the kernel that spreads all votes for wrong witnesses
_PRIOR_SHARE = 0.8  # of buildings follow the prior
_DISTINCTIVE = {VoteKind.BAR: 1e4, VoteKind.PAPER: 1e3}
"""Factor by which even ticks and round ratios are rarer by chance than other votes. Chosen."""
_COMMON = {
    VoteKind.DIMENSION: 0.005, VoteKind.BAR: 0.005, VoteKind.SIZE: 0.02, VoteKind.AREA: 0.02,
    VoteKind.PAPER: 0.01,
}  # fmt: skip
"""Standard deviation of the error common to all votes of a kind. Chosen."""
_CONTRADICTION = 0.5  # of the texts of a scale: as many for another scale contradict it
_AGREE = 0.04  # difference of log scale up to which two scales agree


def most_likely(votes: Sequence[Vote], prior: Prior | None = None) -> Consensus | None:
    """
    Return the consensus of votes; None if chance explains them or they contradict each other.

    All bare numbers get one unit: the one with most agreeing texts, then with the best odds or,
    without a prior, the most usual lengths.
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
    """Return the sort key of units: agreeing texts, then odds or how usual the lengths are."""
    usual = -abs(math.log(found.typical_m / _TYPICAL_M))
    return sum(found.counts.values()), usual if prior is None else found.log_odds


def _is_contradicted(votes: list[Vote], found: Consensus, prior: Prior | None) -> bool:
    """Return whether other texts, half as many or distinctive ones, agree on another scale."""
    others = [vote for vote in votes if vote.text not in found.texts]
    competing = _found(others, prior)
    if competing is None:
        return False
    apart = abs(math.log(competing.resolution_m / found.resolution_m))
    is_bare = all(vote.unit for vote in others if vote.text in competing.texts)
    # Storeys on one sheet may have different units, e.g. centimetres and millimetres.
    is_other_unit = is_bare and abs(apart - _TEN * round(apart / _TEN)) < _AGREE
    if apart < _AGREE or is_other_unit:
        return False
    is_distinctive = any(kind in _DISTINCTIVE for kind in competing.counts)
    return is_distinctive or len(competing.texts) >= _CONTRADICTION * len(found.texts)


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
    """Return whether a scale has several witnesses, or a text that states a scale as such."""
    if any(vote.kind in _DISTINCTIVE for vote in votes):
        return True
    return len(_witnesses(votes)) >= (_FEWEST if prior is None else _FEWEST - 1)


def _witnesses(votes: list[Vote]) -> list[list[Vote]]:
    """Return votes grouped by kind and by equal length."""
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
    """Return the log-likelihood ratio of each scale of ``grid (S,)`` against chance."""
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
        ratio = _DISTINCTIVE.get(VoteKind(kind), 1.0) * density[rows] / chance
        by_share = [np.log(1.0 - p + p * ratio).sum(axis=0) for p in _RIGHT]
        gain += np.logaddexp.reduce(by_share, axis=0) - math.log(len(_RIGHT))
    return gain


def _log_prior(grid: Array, prior: Prior | None) -> Array:
    """Return the log prior probability of each scale of ``grid (S,)``."""
    plain = _STEP / _RANGE
    if prior is None:
        return np.full(len(grid), math.log(plain))
    off = (grid - prior.log_scale) / prior.spread
    usual = np.exp(-0.5 * off**2) * _STEP / (prior.spread * math.sqrt(2.0 * math.pi))
    return np.asarray(np.log(_PRIOR_SHARE * usual + (1.0 - _PRIOR_SHARE) * plain))


def _agreement(grid: Array, gain: Array, odds: float, votes: list[Vote]) -> Consensus:
    """Return a summary of the distribution over scales near the best one."""
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
    if kind in _DISTINCTIVE and count == 1:
        return f'its {kind.value}'
    return f'{count} {kind.value}{"s" if count > 1 else ""}'
