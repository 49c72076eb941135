# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.geometry import Similarity2D
from fpnet_core.matching.consensus import EVIDENCE, Assignments
from fpnet_core.matching.geometry import GraphGeometry
from fpnet_lab.training.evidence import (
    PlacementExample,
    fit_evidence_model,
    negative_log_likelihood,
    score_assignments,
)


def examples(rng, count, strength):
    """Return examples in which only the first kind of evidence tells right from wrong."""
    made = []
    for _ in range(count):
        is_right = np.zeros(5, dtype=bool)
        evidence = rng.normal(size=(5, len(EVIDENCE)))
        if rng.random() < 0.8:
            is_right[rng.integers(5)] = True
            evidence[is_right, 0] += strength
        made.append(PlacementExample(evidence, is_right))
    return made


def test_fit_finds_the_evidence_that_tells():
    rng = np.random.default_rng(0)
    model = fit_evidence_model(examples(rng, 400, 3.0))
    others = np.abs(np.delete(model.weights, 0))
    assert model.weights[0] > 1.5
    assert others.max() < 0.5
    # Calibrated: the mean probability of the best placement is the share of right ones.
    fresh = examples(rng, 600, 3.0)
    said = [model.posterior(example.evidence) for example in fresh]
    hit = [e.is_right[p.argmax()] for e, p in zip(fresh, said, strict=True)]
    assert np.mean([p.max() for p in said]) == pytest.approx(np.mean(hit), abs=0.04)


@pytest.mark.parametrize('right', [[], [2], [0, 3]])
def test_gradient_agrees_with_finite_differences(right):
    rng = np.random.default_rng(1)
    is_right = np.zeros(4, dtype=bool)
    is_right[right] = True
    example = PlacementExample(rng.normal(size=(4, len(EVIDENCE))), is_right)
    at, spread = rng.normal(size=len(EVIDENCE) + 1), rng.uniform(0.5, 2.0, len(EVIDENCE))
    _, gradient = negative_log_likelihood(example, at, spread)
    for k, step in enumerate(1e-6 * np.eye(len(at))):
        high, low = (negative_log_likelihood(example, at + s * step, spread)[0] for s in (1, -1))
        assert gradient[k] == pytest.approx((high - low) / 2e-6, abs=1e-6)


def test_placements_are_judged_in_the_graphs_own_units():
    truth = Similarity2D.from_scale_yaw(1.1, 0.6, [12.0, -3.0])

    def side(unit, origin):
        nothing = np.zeros((1, 2))
        box = np.zeros((1, 5))
        mask = np.zeros(1, dtype=bool)
        links = np.zeros((1, 1), bool)
        return GraphGeometry(nothing, box, mask, np.ones(1), links, unit, origin, (), np.zeros(1))

    plan, sub = side(0.9, np.array([5.0, 6.0])), side(1.3, np.array([-2.0, 1.0]))
    a, b = truth.linear[:, 0] * sub.unit / plan.unit
    x, y = (truth.apply(sub.origin) - plan.origin) / plan.unit
    rows = np.array([[a, b, x, y], [a, b, x + 3.0, y], [-a, -b, x, y], [1.3 * a, 1.3 * b, x, y]])
    assignments = Assignments(
        rows, np.zeros((4, 1), np.int64), np.zeros((4, 1)), np.zeros((4, 11))
    )
    assert score_assignments(assignments, plan, sub, truth).tolist() == [True, False, False, False]
