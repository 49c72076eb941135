# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from graph_pairs import toy_pair
import numpy as np
import pytest

from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import Weights
from fpnet_core.matching.consensus import (
    EVIDENCE,
    EvidenceModel,
    find_assignments,
    rank,
)
from fpnet_core.matching.evidence_model import evidence_entry, evidence_model
from fpnet_core.matching.geometry import graph_geometry
from fpnet_core.matching.kernels import nearest_regions
from fpnet_core.matching.marginals import hypotheses_of, pair_probability

KNOWN = [1.5, -0.7, 0.8, -0.8, 0.25, 0.2, -0.6, -0.7, -0.15, -0.7]
MODEL = EvidenceModel(np.array(KNOWN + (len(EVIDENCE) - len(KNOWN)) * [0.0]), 3.0)


def settled(plan, sub, log_p):
    prepared_plan, prepared_submap = graph_geometry(plan), graph_geometry(sub)
    assignments = find_assignments(prepared_plan, prepared_submap, log_p)
    return prepared_plan, prepared_submap, *rank(assignments, MODEL)


def test_consensus_finds_the_rooms_that_no_likelihood_tells_apart():
    rng = np.random.default_rng(5)
    right = total = 0
    for _ in range(6):
        plan, sub, labels = toy_pair(rng, rooms=7, seen=5)
        _, _, assignments, _ = settled(plan, sub, np.zeros((len(plan), len(sub))))
        right += int(np.count_nonzero(assignments.partner[0] == labels))
        total += len(labels)
    assert right > 0.8 * total


def test_hypotheses_lead_from_the_submap_to_the_plan():
    plan, sub, labels = toy_pair(np.random.default_rng(6), rooms=7, seen=5)
    likely = np.full((len(plan), len(sub)), -6.0)
    likely[labels, np.arange(len(sub))] = 0.0
    prepared_plan, prepared_submap, assignments, posterior = settled(plan, sub, likely)
    best = hypotheses_of(assignments, posterior, prepared_plan, prepared_submap)[0]
    assert best.probability > 0.9
    assert best.pairs.tolist() == [[label, j] for j, label in enumerate(labels)]
    source = np.array([region.centroid for region in sub.regions])
    target = np.array([plan.regions[label].centroid for label in labels])
    # Toy outlines carry noise of 2 cm.
    assert np.abs(best.S_plan_sub.apply(source) - target).max() < 0.15


def test_probabilities_are_those_of_an_assignment():
    plan, sub, _ = toy_pair(np.random.default_rng(7), rooms=8, seen=4)
    rng = np.random.default_rng(8)
    base = rng.random((len(plan), len(sub)))
    base /= 2.0 * max(base.sum(axis=0).max(), base.sum(axis=1).max())
    _, prepared_submap, assignments, posterior = settled(plan, sub, np.log(base))
    probability = pair_probability(base, assignments, posterior, prepared_submap)
    assert probability.min() >= 0.0
    assert probability.sum(axis=0).max() <= 1.0 + 1e-9
    assert probability.sum(axis=1).max() <= 1.0 + 1e-9


def test_unknown_evidence_is_refused():
    entry = evidence_entry(MODEL) | {'colour': 1.0}
    with pytest.raises(WeightsError, match='colour'):
        evidence_model(Weights({}, {'evidence': entry}))


@pytest.mark.parametrize('count', [0, 1, 6, 39])
def test_nearest_regions_are_those_of_a_stable_sort(count):
    rng = np.random.default_rng(count)
    # On a coarse grid many are equally far away.
    point = rng.integers(0, 7, (count + 1, 2)).astype(np.float64)
    distance = np.linalg.norm(point[:, None] - point[None], axis=2)
    np.fill_diagonal(distance, np.inf)
    expected = np.argsort(distance, axis=1, kind='stable')[:, : min(6, count)]
    assert np.array_equal(nearest_regions(point, min(6, count)), expected)
