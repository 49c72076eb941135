# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots run on arrays what training runs on tensors."""

from graph_pairs import toy_pair
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
import torch

from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import Weights, read_weights
from fpnet_core.models.arrays import NUMPY, JointBias
from fpnet_core.models.batch import pad_graphs
from fpnet_core.models.config import InvariantConfig
from fpnet_core.models.inference import inference_of
from fpnet_core.models.invariant import InvariantNetwork
from fpnet_core.models.joint_attention import JointAttention, shapes
from fpnet_core.models.loading import load_network
from fpnet_core.models.tensor_inference import OnTensors
from fpnet_core.models.tensors import TORCH
from fpnet_core.small_networks import product
from fpnet_core.types import FEATURE_SCHEMA


def random_network(seed, **sizes):
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = InvariantNetwork(InvariantConfig(**sizes))
        for parameter in network.parameters():
            torch.nn.init.normal_(parameter, std=0.3)
    return network.double().eval()


def as_double(batch):
    return type(batch)(
        batch.node_feat.astype(np.float64), batch.adjacency.astype(np.float64), batch.mask
    )


@given(seed=st.integers(0, 10_000), rooms=st.integers(2, 9))
@settings(max_examples=15, deadline=None)
def test_arrays_and_tensors_give_the_same_assignments(seed, rooms):
    network = random_network(seed, width=16, heads=4, layers=2)
    rng = np.random.default_rng(seed)
    pairs = [toy_pair(rng, count, 2)[:2] for count in (rooms, rooms + 2)]
    batches = [
        as_double(pad_graphs([network.rows(p[i]) for p in pairs], [p[i].edges for p in pairs]))
        for i in (0, 1)
    ]
    state = {name: value.numpy() for name, value in network.state_dict().items()}
    on_arrays = JointAttention(network.config, NUMPY, state).assignments(*batches)
    tensors = [
        type(b)(*map(torch.from_numpy, (b.node_feat, b.adjacency, b.mask))) for b in batches
    ]
    with torch.inference_mode():
        on_tensors = network.assignments(*tensors)
    for found, expected in zip(on_arrays, on_tensors, strict=True):
        assert found == pytest.approx(expected.numpy(), rel=1e-4, abs=1e-4)


def test_packaged_network_says_the_same_on_arrays_and_tensors():
    weights = read_weights(None, FEATURE_SCHEMA)
    plan, sub, _ = toy_pair(np.random.default_rng(4), rooms=40, seen=12)
    on_arrays, on_tensors = inference_of(weights), OnTensors(load_network(weights))
    found, expected = (
        n.likelihood(n.prepared(plan), n.prepared(sub)) for n in (on_arrays, on_tensors)
    )
    assert found == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize('sizes', [{}, {'width': 12, 'heads': 3, 'layers': 2}])
def test_shapes_are_those_of_what_is_trained(sizes):
    config = InvariantConfig(**sizes)
    state = InvariantNetwork(config).state_dict()
    assert shapes(config) == {name: tuple(value.shape) for name, value in state.items()}


def test_misshapen_parameter_is_named():
    weights = read_weights(None, FEATURE_SCHEMA)
    tensors = {**weights.tensors, 'across': np.zeros((5, 4), np.float32)}
    with pytest.raises(WeightsError, match=r'across: expected shape \(6, 4\), got shape \(5, 4\)'):
        inference_of(Weights(tensors, weights.manifest))


@pytest.mark.parametrize(
    ('a', 'b'), [((7, 64), (64, 192)), ((500, 64), (64, 192)), ((2, 3, 400, 16), (2, 3, 16, 400))]
)
def test_product_in_parts_is_the_product(a, b):
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=a), rng.normal(size=b)
    assert product(a, b) == pytest.approx(a @ b, abs=1e-9)


def attention_case(rng, plan, sub, lift=0.0):
    ours, theirs = (rng.normal(size=(2, 4, size, size)).astype(np.float32) for size in (plan, sub))
    query, key, value = rng.normal(size=(3, 2, 4, plan + sub, 16)).astype(np.float32)
    mask = np.ones((2, plan + sub), dtype=bool)
    mask[1, [plan - 1, -1]] = False
    bias = JointBias(ours + np.float32(lift), theirs, np.array([3, -3, 0, 1], np.float32), mask)
    return query, key, value, bias


@pytest.mark.parametrize('lift', [0.0, 300.0, -300.0])
@pytest.mark.parametrize(('plan', 'sub'), [(1, 1), (7, 3), (90, 300)])
def test_attention_on_arrays_is_that_on_tensors(plan, sub, lift):
    case = attention_case(np.random.default_rng(plan), plan, sub, lift)
    *rows, bias = case
    parts = (bias.ours, bias.theirs, bias.across, bias.mask)
    tensors = JointBias(*(torch.from_numpy(part) for part in parts))
    expected = TORCH.attention(*(torch.from_numpy(each) for each in rows), tensors).numpy()
    assert NUMPY.attention(*case) == pytest.approx(expected, abs=2e-5)
