# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots run on arrays what training runs on tensors."""

from pathlib import Path

from graph_pairs import toy_pair
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
import torch

from fpnet_core import weights as weights_package
from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import Weights, read_weights
from fpnet_core.models import arrays
from fpnet_core.models.arrays import NUMPY, JointBias
from fpnet_core.models.batch import pad_graphs
from fpnet_core.models.config import EdgeMapping, InvariantConfig, PaperConfig, network_config
from fpnet_core.models.inference import inference_of, parameter_shapes
from fpnet_core.models.joint_attention import JointAttention
from fpnet_core.small_networks import product
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.training.networks.invariant import InvariantModule
from fpnet_lab.training.networks.modules import load_tensors
from fpnet_lab.training.networks.paper import PaperModule
from fpnet_lab.training.networks.tensors import TORCH

INVARIANT = InvariantConfig(width=16, heads=4, layers=2)
SMALL = {'width': 8, 'heads': 2, 'blocks': 2, 'position_widths': (6,)}


WEIGHTS = Path(weights_package.__file__).parent


def module_of(config):
    return PaperModule(config) if isinstance(config, PaperConfig) else InvariantModule(config)


def random_network(seed, config):
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = module_of(config)
        for parameter in network.parameters():
            torch.nn.init.normal_(parameter, std=0.3)
    return network.double().eval()


def as_double(batch):
    return type(batch)(
        batch.node_feat.astype(np.float64), batch.adjacency.astype(np.float64), batch.mask
    )


@pytest.mark.parametrize(
    'config', [INVARIANT, *(PaperConfig(edge_mapping=each, **SMALL) for each in EdgeMapping)]
)
@given(seed=st.integers(0, 10_000), rooms=st.integers(2, 9))
@settings(max_examples=8, deadline=None)
def test_arrays_and_tensors_give_the_same_assignments(config, seed, rooms):
    network = random_network(seed, config)
    rng = np.random.default_rng(seed)
    pairs = [toy_pair(rng, count, 2)[:2] for count in (rooms, rooms + 2)]
    batches = [
        as_double(
            pad_graphs([network.network.rows(p[i]) for p in pairs], [p[i].edges for p in pairs])
        )
        for i in (0, 1)
    ]
    state = {name: value.numpy() for name, value in network.state_dict().items()}
    on_arrays = type(network.network)(config, NUMPY, state).assignments(*batches)
    tensors = [
        type(b)(*map(torch.from_numpy, (b.node_feat, b.adjacency, b.mask))) for b in batches
    ]
    with torch.inference_mode():
        on_tensors = network.assignments(*tensors)
    for found, expected in zip(on_arrays, on_tensors, strict=True):
        assert found == pytest.approx(expected.numpy(), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize('name', ['matcher', 'paper', 'superglue'])
def test_packaged_networks_say_the_same_on_arrays_and_tensors(name):
    weights = read_weights(WEIGHTS / f'{name}.safetensors', FEATURE_SCHEMA)
    plan, sub, _ = toy_pair(np.random.default_rng(4), rooms=40, seen=12)
    on_arrays = inference_of(weights)
    module = module_of(network_config(weights))
    load_tensors(module, weights)
    found = on_arrays.likelihood(on_arrays.prepared(plan), on_arrays.prepared(sub))
    with torch.inference_mode():
        expected = module(module.batch([plan]), module.batch([sub]))[0, :-1, :-1].exp().numpy()
    assert found == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(
    'config',
    [InvariantConfig(), INVARIANT, PaperConfig(), PaperConfig(**SMALL)],
)
def test_shapes_are_those_of_what_is_trained(config):
    module = module_of(config)
    expected = {name: tuple(value.shape) for name, value in module.state_dict().items()}
    assert parameter_shapes(config) == expected


def test_misshapen_parameter_is_named():
    weights = read_weights(None, FEATURE_SCHEMA)
    tensors = {**weights.tensors, 'across': np.zeros((5, 4), np.float32)}
    with pytest.raises(WeightsError, match=r'across: expected shape \(6, 4\), got shape \(5, 4\)'):
        inference_of(Weights(tensors, weights.manifest))


def test_gelu_is_exact_to_single_precision():
    x = np.linspace(-9.0, 9.0, 4001, dtype=np.float32)
    expected = torch.nn.functional.gelu(torch.from_numpy(x).double()).numpy()
    found = arrays.gelu(x)
    assert found.dtype == np.float32
    assert np.abs(found - expected).max() < 1e-6


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


def test_layer_norm_on_arrays_is_that_on_tensors():
    rng = np.random.default_rng(1)
    x, weight, bias = (rng.normal(2.0, 3.0, s).astype(np.float32) for s in ((2, 5, 64), 64, 64))
    expected = TORCH.layer_norm(*(torch.from_numpy(each) for each in (x, weight, bias))).numpy()
    assert NUMPY.layer_norm(x, weight, bias) == pytest.approx(expected, abs=2e-6)


def test_prepared_graphs_are_matched_like_others():
    network = inference_of(read_weights(None, FEATURE_SCHEMA)).network
    graphs = toy_pair(np.random.default_rng(4), rooms=40, seen=12)[:2]
    plan, sub = (pad_graphs([JointAttention.rows(g)], [g.edges]) for g in graphs)
    found = network.log_assignment(network.prepared(plan), sub)
    assert np.array_equal(found, network.log_assignment(plan, network.prepared(sub)))
