# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.matching.consensus import EVIDENCE
from fpnet_lab.training.evidence import (
    PlacementExample,
    fit_evidence_model,
    negative_log_likelihood,
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
