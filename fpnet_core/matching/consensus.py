# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Geometric consensus: placements of the submap on which the likely region pairs agree.

The network gives each submap region likely plan regions. Rooms repeat, so many pairs look alike,
but two pairs determine a similarity, and under the true one every other region falls on a partner.
The module proposes placements from pairs of likely pairs, refines them and scores them with a
log-linear model of a few kinds of evidence, such as regions that should have a partner and have
none. The weights are fitted on training buildings, so the softmax of the scores is the probability
that a placement is correct; the remainder is the probability that none is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry.distinct import first_distinct
from fpnet_core.matches import LEAST_DECADES, WELL_SEEN
from fpnet_core.matching.alignment import GLIMPSED_WEIGHT, aligned
from fpnet_core.matching.anchors import anchored
from fpnet_core.matching.geometry import GraphGeometry
from fpnet_core.matching.kernels import (
    fit_regions,
    keep_one_per_plan_region,
    nearest_regions,
    propose_similarities,
)
from fpnet_core.matching.outlines import EXPLAINED, explained, walls_apart
from fpnet_core.small_networks import product

Array = NDArray[np.float64]

EVIDENCE = (
    'door_fit',
    'door_misses',
    'room_fit',
    'room_misses',
    'likelihood',
    'edges_kept',
    'edges_broken',
    'scale_error',
    'plan_door_misses',
    'size_error',
    'fit_share',
    'doors_apart',
    'rooms_apart',
    'glimpses_apart',
    'mean_doors_apart',
    'mean_rooms_apart',
    'doors_scatter',
    *EXPLAINED,
)
"""
Kinds of evidence in the order of the model's weights: sums, a share and means over regions, and
how well the plan explains the observed walls and floors.
"""

CANDIDATES_PER_REGION = 8  # numerical: likely plan regions considered per submap region
NEIGHBOURS = 6  # numerical: other regions that each submap region is paired with
MAX_PROPOSALS = 200  # numerical: placements whose fit is computed
MAX_REFINED = 24  # numerical: distinct placements that are refined and scored

ANCHORED_REGIONS = 8
"""
Submaps with at most this many regions also try placements from single regions; larger ones hardly
benefit. Chosen.
"""

_REFINEMENTS = 2  # numerical
_LEAST_SPREAD = 1e-3  # numerical: square units, least spread of regions that determines a rotation
# Chosen, not measured:
_DISTINCT_UNITS = 1.0  # placements that move the submap's corners by less are one
_NEGLIGIBLE = 1e-5  # numerical: likelihoods below this share of a region's best are not tried
_FLOOR = -5.0  # numerical: lower bound of a partner's log-likelihood relative to the best one
_LOG_WINDOW = 0.7  # largest log ratio of plan units to submap units that is tried
_PRESELECTION = np.array([1.0, 0.0, 0.0, 4.0, 1.0])  # weights of ``EXPLAINED`` in the preselection
_LEAST_APART = 0.05  # least distance of doorways from their partners', as in ``doors_apart``
_SCALE_WIDTH = 0.15  # spread of the log ratio between both graphs' units
_UNLIKELY_WEIGHT = 0.3  # of a region's least likely partners; its likeliest partner has 1.3


@dataclass(frozen=True, eq=False)
class EvidenceModel:
    """``weights (K,)`` of the kinds of evidence, and the score of the null hypothesis."""

    weights: Array
    null: float

    def posterior(self, evidence: Array) -> Array:
        """Return the probability of each row of ``evidence (C, K)``; the null has the rest."""
        scores = np.append(evidence @ self.weights, self.null)
        share = np.exp(scores - scores.max())
        probability: Array = share[:-1] / share.sum()
        return probability


@dataclass(frozen=True, eq=False)
class Assignments:
    """
    Distinct placements of a submap, and the plan region that each assigns to a submap region.

    ``similarity (C, 4)`` as in :mod:`fpnet_core.matching.kernels`; ``partner (C, N)`` plan indices
    or -1, one-to-one; ``fit (C, N)`` 0 to 1; ``evidence (C, K)``.
    """

    similarity: Array
    partner: NDArray[np.int64]
    fit: Array
    evidence: Array

    def take(self, index: NDArray[np.int64]) -> Assignments:
        """Return the assignments at ``index`` in that order."""
        return Assignments(
            self.similarity[index], self.partner[index], self.fit[index], self.evidence[index]
        )

    def __len__(self) -> int:
        """Return the number of assignments."""
        return len(self.similarity)


def find_assignments(plan: GraphGeometry, sub: GraphGeometry, log_p: Array) -> Assignments:
    """
    Return the assignments that several likely pairs agree on; none for a single region.

    Parameters
    ----------
    plan, sub : both graphs, neither empty
    log_p : (M, N) log-likelihood of each pair of regions; only differences within a column matter
    """
    relative = _relative(plan, sub, log_p)
    weight = _UNLIKELY_WEIGHT + np.clip(1.0 + relative / (LEAST_DECADES * np.log(10.0)), 0.0, 1.0)
    proposals = propose_similarities(
        relative,
        _likely_partners(relative),
        nearest_regions(sub.point, min(NEIGHBOURS, len(sub) - 1)),
        plan.point,
        sub.point,
        np.ascontiguousarray(plan.box[:, 4]),  # contiguous, so that numba compiles one array type
        np.ascontiguousarray(sub.box[:, 4]),
        sub.is_door,
        _LOG_WINDOW,
    )
    order = np.argsort(-proposals[:, 4], kind='stable')[:MAX_PROPOSALS]
    similarity = proposals[order, :4]
    _, fit = _fit(plan, sub, similarity, weight)
    order = np.argsort(-fit.sum(axis=1), kind='stable')
    similarity = similarity[order]
    similarity = similarity[_distinct_index(similarity, sub, MAX_REFINED)]
    for _ in range(_REFINEMENTS):
        similarity = _refined(plan, sub, similarity, *_fit(plan, sub, similarity, weight))
    log_scale = 0.5 * np.log((similarity[:, :2] ** 2).sum(axis=1))
    similarity = similarity[np.abs(log_scale) <= _LOG_WINDOW]
    partner, fit = _fit(plan, sub, similarity, weight)
    keep_one_per_plan_region(partner, fit, len(plan))
    # Placements that refinement made equal are one; the best fit stays.
    order = np.argsort(-fit.sum(axis=1), kind='stable')
    order = order[_distinct_index(similarity[order], sub, MAX_REFINED)]
    similarity, partner, fit = similarity[order], partner[order], fit[order]
    if 1 < len(sub) <= ANCHORED_REGIONS:
        similarity, partner, fit = _with_anchored(plan, sub, similarity, relative, weight)
    similarity, apart = aligned(similarity, partner, fit, plan, sub)
    evidence = _evidence(plan, sub, similarity, partner, fit, apart, relative)
    return Assignments(similarity, partner, fit, evidence)


def _with_anchored(
    plan: GraphGeometry, sub: GraphGeometry, similarity: Array, relative: Array, weight: Array
) -> tuple[Array, NDArray[np.int64], Array]:
    """Add the best placements from single regions; return all, distinct and fitted."""
    single = anchored(plan, sub, _likely_partners(relative), _LOG_WINDOW)
    few = sub.seen.thinned()
    penalty = walls_apart(single, plan.painted, few) + _scale_penalty(single)
    single = single[np.argsort(penalty, kind='stable')[:MAX_PROPOSALS]]
    similarity = np.concatenate([similarity, single])
    penalty = explained(similarity, plan.painted, few) @ _PRESELECTION + _scale_penalty(similarity)
    similarity = similarity[np.argsort(penalty, kind='stable')]
    similarity = similarity[_distinct_index(similarity, sub, 2 * MAX_REFINED)]
    partner, fit = _fit(plan, sub, similarity, weight)
    keep_one_per_plan_region(partner, fit, len(plan))
    return similarity, partner, fit


def rank(assignments: Assignments, model: EvidenceModel) -> tuple[Assignments, Array]:
    """Return the assignments, most probable first, and their probabilities ``(C,)``."""
    probability = model.posterior(assignments.evidence)
    order = np.argsort(-probability, kind='stable')
    return assignments.take(order), probability[order]


def _evidence(
    plan: GraphGeometry,
    sub: GraphGeometry,
    similarity: Array,
    partner: NDArray[np.int64],
    fit: Array,
    apart: Array,
    relative: Array,
) -> Array:
    """Return the evidence ``(C, K)`` of final placements; columns as in ``EVIDENCE``."""
    matched = partner >= 0
    door, room = sub.is_door[None], ~sub.is_door[None]
    likelihood = np.where(matched, np.maximum(relative[partner, np.arange(len(sub))], _FLOOR), 0.0)
    kept, broken = _edges(plan, sub, partner)
    log_scale = 0.5 * np.log((similarity[:, :2] ** 2).sum(axis=1) + 1e-12)
    well_seen = matched & room & (sub.observed >= WELL_SEEN)[None]
    size = np.log(plan.box[:, 2:4]).sum(axis=1)[partner] - np.log(sub.box[:, 2:4]).sum(axis=1)
    size_error = np.abs(size - 2.0 * log_scale[:, None]).clip(0.0, 1.0)
    doors_apart, rooms_apart = ((apart * kind).sum(axis=1) for kind in (door, well_seen))
    doors, rooms = ((matched & kind).sum(axis=1).clip(1) for kind in (door, well_seen))
    return np.column_stack(
        [
            (fit * door).sum(axis=1),
            (~matched & door).sum(axis=1),
            (fit * room).sum(axis=1),
            (~matched & room).sum(axis=1),
            likelihood.sum(axis=1),
            kept,
            broken,
            np.log1p((log_scale / _SCALE_WIDTH) ** 2),
            _plan_door_misses(plan, partner, well_seen),
            (size_error * well_seen).sum(axis=1),
            fit.mean(axis=1),
            doors_apart,
            rooms_apart,
            (apart * (room & ~well_seen)).sum(axis=1),
            doors_apart / doors,
            rooms_apart / rooms,
            _scatter(doors_apart, (matched & door).sum(axis=1)),
            explained(similarity, plan.painted, sub.seen),
        ]
    ).astype(np.float64)


def _scale_penalty(similarity: Array) -> Array:
    """Return the scale penalty of placements, comparable to that of ``_PRESELECTION``."""
    log_scale = 0.5 * np.log((similarity[:, :2] ** 2).sum(axis=1))
    penalty: Array = 0.5 * np.log1p((log_scale / _SCALE_WIDTH) ** 2)
    return penalty


def _scatter(apart: Array, count: NDArray[np.int64]) -> Array:
    """
    Return minus the log-likelihood of ``count (C,)`` gaps of unknown spread.

    A gap that is large in exact drawings is small in rough ones. Each placement therefore uses the
    spread under which its gaps, ``apart (C,)`` in total, are most likely.
    """
    scatter: Array = count * np.log(apart / count.clip(1) + _LEAST_APART)
    return scatter


def _relative(plan: GraphGeometry, sub: GraphGeometry, log_p: Array) -> Array:
    """Return log-likelihoods relative to each column's best; -inf between a door and a room."""
    same = plan.is_door[:, None] == sub.is_door[None]
    allowed = np.where(same, log_p, -np.inf)
    best = allowed.max(axis=0, keepdims=True)
    return np.where(same, log_p - np.where(np.isfinite(best), best, 0.0), -np.inf)


def _likely_partners(relative: Array) -> NDArray[np.int64]:
    """Return ``(N, K)`` plan indices per submap region, best first, -1 where unlikely."""
    count = min(CANDIDATES_PER_REGION, len(relative))
    best = np.argsort(-relative, axis=0, kind='stable')[:count].T
    value = np.take_along_axis(relative.T, best, axis=1)
    likely = np.where(value > np.log(_NEGLIGIBLE), best, -1)
    return np.ascontiguousarray(likely, dtype=np.int64)


def _fit(
    plan: GraphGeometry, sub: GraphGeometry, similarity: Array, weight: Array
) -> tuple[NDArray[np.int64], Array]:
    partner = np.empty((len(similarity), len(sub)), dtype=np.int64)
    fit = np.empty((len(similarity), len(sub)))
    sides = (plan.point, plan.box, plan.is_door, sub.point, sub.box, sub.is_door)
    fit_regions(np.ascontiguousarray(similarity), weight, *sides, partner, fit)
    return partner, fit


def _refined(
    plan: GraphGeometry,
    sub: GraphGeometry,
    similarity: Array,
    partner: NDArray[np.int64],
    fit: Array,
) -> Array:
    """Return weighted least-squares similarities; rows with under two partners are unchanged."""
    pull = np.where(sub.is_door, 1.0, GLIMPSED_WEIGHT)[None] * fit
    total = pull.sum(axis=1, keepdims=True)
    share = pull / np.maximum(total, 1e-12)
    target = plan.point[partner]
    sub_mean = share @ sub.point
    plan_mean = np.einsum('cn,cnd->cd', share, target)
    source = sub.point[None] - sub_mean[:, None]
    target = target - plan_mean[:, None]
    spread = np.einsum('cn,cnd->c', share, source**2)
    along = np.einsum('cn,cnd,cnd->c', share, source, target)
    turn = source[..., 0] * target[..., 1] - source[..., 1] * target[..., 0]
    across = np.einsum('cn,cn->c', share, turn)
    usable = ((pull > 0.0).sum(axis=1) >= 2) & (spread > _LEAST_SPREAD)
    usable &= along**2 + across**2 > _LEAST_SPREAD**2
    a, b = (value / np.where(usable, spread, 1.0) for value in (along, across))
    x = plan_mean[:, 0] - a * sub_mean[:, 0] + b * sub_mean[:, 1]
    y = plan_mean[:, 1] - b * sub_mean[:, 0] - a * sub_mean[:, 1]
    return np.where(usable[:, None], np.column_stack([a, b, x, y]), similarity)


def _distinct_index(similarity: Array, sub: GraphGeometry, limit: int) -> NDArray[np.int64]:
    """Return indices of placements that differ from every earlier one, at most ``limit``."""
    low, high = sub.point.min(axis=0), sub.point.max(axis=0)
    corners = np.array([low, high, [low[0], high[1]]])
    a, b = similarity[:, :1], similarity[:, 1:2]
    x = a * corners[:, 0] - b * corners[:, 1] + similarity[:, 2:3]
    y = b * corners[:, 0] + a * corners[:, 1] + similarity[:, 3:4]
    placed = np.concatenate([x, y], axis=1)

    def is_same(index: int, others: NDArray[np.int64]) -> NDArray[np.bool_]:
        apart = np.abs(placed[others] - placed[index]).max(axis=1)
        return np.asarray(apart <= _DISTINCT_UNITS)

    return first_distinct(len(placed), is_same, limit)


def _edges(
    plan: GraphGeometry, sub: GraphGeometry, partner: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Count submap edges between matched regions whose partners are, and are not, connected."""
    first, second = np.nonzero(np.triu(sub.linked))
    i, k = partner[:, first], partner[:, second]
    both = (i >= 0) & (k >= 0)
    joined = plan.linked[i, k]
    return (both & joined).sum(axis=1), (both & ~joined).sum(axis=1)


def _plan_door_misses(
    plan: GraphGeometry, partner: NDArray[np.int64], well_seen: NDArray[np.bool_]
) -> Array:
    """Count unmatched plan doors of plan rooms whose submap room is well observed."""
    rows = np.arange(len(partner))[:, None]
    # Column M collects regions without a partner and is dropped.
    seen, taken = (np.zeros((len(partner), len(plan) + 1), dtype=np.float32) for _ in range(2))
    seen[rows, np.where(well_seen, partner, len(plan))] = 1.0
    taken[rows, np.where(partner >= 0, partner, len(plan))] = 1.0
    doors = np.flatnonzero(plan.is_door)
    expected = product(seen[:, :-1], plan.linked[:, doors].astype(np.float32)) > 0.0
    misses: Array = (expected & (taken[:, doors] == 0.0)).sum(axis=1).astype(np.float64)
    return misses
