# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest
import torch

from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.sinkhorn import log_assignment
from fpnet_lab.training.config import LossConfig
from fpnet_lab.training.losses import (
    match_loss,
    matching_loss,
)

LABELS = torch.tensor([[2, 0, UNMATCHED, IGNORE]])
PLAN_MASK = torch.tensor([[True, True, True, True, False]])


def prepared_plan():
    """Return a plan of four nodes on a line, 0-1-2 connected, and one padded node."""
    features = torch.zeros((1, 5, 28), dtype=torch.float64)
    features[0, :4, 0] = torch.tensor([0.0, 0.3, 1.0, 1.6])
    features[0, :4, 1] = torch.tensor([0.0, 0.4, 0.1, -0.7])
    adjacency = torch.zeros((1, 5, 5), dtype=torch.float64)
    for i, j in ((0, 1), (1, 2)):
        adjacency[0, i, j] = adjacency[0, j, i] = 1.0
    return GraphBatch(features, adjacency, PLAN_MASK)


def hard_assignment():
    x = torch.zeros((1, 6, 5), dtype=torch.float64)
    x[0, 2, 0] = x[0, 0, 1] = x[0, 5, 2] = 1.0
    x[0, 1, 4] = x[0, 3, 4] = 1.0
    return x


def test_the_true_assignment_costs_nothing():
    terms = matching_loss((hard_assignment() + 1e-12).log(), LABELS, prepared_plan(), LossConfig())
    assert float(terms.match) == pytest.approx(0.0, abs=1e-5)
    assert float(terms.topology) == pytest.approx(0.0, abs=1e-9)
    assert float(terms.spatial) == pytest.approx(0.0, abs=1e-9)


def test_match_loss_is_the_mean_likelihood_of_each_kind_of_node():
    probability = torch.full((1, 6, 5), 0.5, dtype=torch.float64)
    probability[0, 2, 0] = probability[0, 0, 1] = 0.25
    probability[0, 5, 2] = 0.1
    loss = match_loss(probability, LABELS, PLAN_MASK)
    # Two partners at 1/4; one submap dustbin at 0.1; plan dustbins of nodes 1 and 3 at 1/2.
    expected = math.log(4) + 0.5 * (math.log(10) + math.log(2))
    assert float(loss) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    'weights',
    [
        LossConfig(match=1.0, topology=0.0, spatial=0.0),
        LossConfig(match=0.0, topology=1.0, spatial=0.0),
        LossConfig(match=0.0, topology=0.0, spatial=1.0),
        LossConfig(),
    ],
    ids=['match', 'topology', 'spatial', 'paper'],
)
def test_gradients_agree_with_finite_differences(weights):
    scores = torch.randn((1, 5, 4), generator=torch.Generator().manual_seed(4)).double()
    mask = torch.ones((1, 4), dtype=torch.bool)

    def loss(values):
        dustbin = torch.tensor(0.3).double()
        log_x = log_assignment(values, dustbin, PLAN_MASK, mask, 20)
        return matching_loss(log_x, LABELS, prepared_plan(), weights).total

    scores.requires_grad_(True)
    (gradient,) = torch.autograd.grad(loss(scores), scores)
    step = 1e-6
    numeric = np.zeros((5, 4))
    for i, j in np.ndindex(5, 4):
        nudge = torch.zeros_like(scores)
        nudge[0, i, j] = step
        with torch.no_grad():
            numeric[i, j] = float(loss(scores + nudge) - loss(scores - nudge)) / (2 * step)
    assert gradient[0].numpy() == pytest.approx(numeric, abs=1e-6)
    assert np.abs(numeric).max() > 1e-3
