# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import json

from graph_pairs import toy_pair
import numpy as np
import pytest
import torch

from fpnet_core.config import MatcherConfig
from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import read_weights, write_weights
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.models.config import PaperConfig
from fpnet_core.models.loading import load_network
from fpnet_core.models.paper import PaperNetwork
from fpnet_core.types import FEATURE_SCHEMA, RegionGraph

NETWORK = PaperConfig(width=8, blocks=1, position_widths=(6,))
EMPTY = RegionGraph((), np.zeros((0, 2)), np.zeros((0, 28)), np.zeros((0, 3)), 'submap')


@pytest.fixture
def checkpoint(tmp_path):
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = PaperNetwork(NETWORK)
    tensors = {key: value.numpy() for key, value in network.state_dict().items()}
    path = tmp_path / 'small.safetensors'
    write_weights(path, tensors, FEATURE_SCHEMA, {'network': NETWORK.model_dump(mode='json')})
    return path


def change_manifest(path, change):
    manifest_path = path.with_suffix('.json')
    manifest = json.loads(manifest_path.read_text())
    change(manifest)
    manifest_path.write_text(json.dumps(manifest))


def test_matches_are_those_of_the_network(checkpoint):
    matcher = LearnedMatcher(MatcherConfig(weights=str(checkpoint), grade_thresholds=(0, 0, 0)))
    plan, sub, _ = toy_pair(np.random.default_rng(0))
    result = matcher.match(plan, sub, 300.0)
    with torch.inference_mode():
        network = load_network(read_weights(checkpoint, FEATURE_SCHEMA))
        expected = network(network.batch([plan]), network.batch([sub]))[0, :-1, :-1].exp().numpy()
    assert result.probability == pytest.approx(expected, abs=1e-6)
    assert (expected.sum(axis=0) <= 1 + 1e-5).all()
    for (i, j), score in zip(result.pairs, result.scores, strict=True):
        assert score == pytest.approx(expected[i].max()) == pytest.approx(expected[:, j].max())


def test_the_papers_network_names_the_extra_that_it_needs(checkpoint, monkeypatch):
    monkeypatch.setattr('fpnet_core.models.inference.find_spec', lambda name: None)
    with pytest.raises(WeightsError, match=r"pip install 'fpnet_ros\[train\]'"):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_threshold_follows_the_explored_area(checkpoint):
    config = MatcherConfig(weights=str(checkpoint), grade_thresholds=(0.0, 0.0, 0.99))
    matcher = LearnedMatcher(config)
    plan, sub, _ = toy_pair(np.random.default_rng(1))
    assert len(matcher.match(plan, sub, 10.0).pairs) > len(matcher.match(plan, sub, 900.0).pairs)


@pytest.mark.parametrize('side', ['plan', 'sub', 'both'])
def test_empty_graphs_have_no_matches(checkpoint, side):
    matcher = LearnedMatcher(MatcherConfig(weights=str(checkpoint)))
    plan, sub, _ = toy_pair(np.random.default_rng(2))
    plan, sub = (EMPTY if side != 'sub' else plan), (EMPTY if side != 'plan' else sub)
    result = matcher.match(plan, sub, 0.0)
    assert result.pairs.shape == (0, 2)
    assert result.probability.shape == (len(plan), len(sub))


def test_another_plan_replaces_the_cached_one(checkpoint):
    matcher = LearnedMatcher(MatcherConfig(weights=str(checkpoint)))
    rng = np.random.default_rng(3)
    (plan_a, sub, _), (plan_b, _, _) = toy_pair(rng, rooms=6), toy_pair(rng, rooms=9)
    first = matcher.match(plan_a, sub, 100.0).probability
    assert matcher.match(plan_b, sub, 100.0).probability.shape == (len(plan_b), len(sub))
    assert matcher.match(plan_a, sub, 100.0).probability == pytest.approx(first)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(WeightsError, match=r'gone\.json: No such file'):
        LearnedMatcher(MatcherConfig(weights=str(tmp_path / 'gone.safetensors')))


def test_wrong_hash_is_refused(checkpoint):
    data = bytearray(checkpoint.read_bytes())
    data[-1] ^= 1
    checkpoint.write_bytes(bytes(data))
    with pytest.raises(WeightsError, match='sha256'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_other_schema_is_refused(checkpoint):
    change_manifest(checkpoint, lambda manifest: manifest.update(schema=FEATURE_SCHEMA + 1))
    with pytest.raises(WeightsError, match=f'feature schema {FEATURE_SCHEMA + 1}'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


@pytest.mark.parametrize('key', ['sha256', 'schema', 'network', 'tensors'])
def test_incomplete_manifest_is_refused(checkpoint, key):
    change_manifest(checkpoint, lambda manifest: manifest.pop(key))
    with pytest.raises(WeightsError, match=f"lacks '{key}'"):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_missing_tensor_is_named(checkpoint):
    change_manifest(checkpoint, lambda m: m['tensors'].update({'extra.weight': [3]}))
    with pytest.raises(WeightsError, match=r'extra\.weight: expected shape \(3,\), got none'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_misshapen_tensor_is_named(checkpoint):
    change_manifest(checkpoint, lambda m: m['tensors'].update({'project.bias': [9]}))
    with pytest.raises(WeightsError, match=r'project\.bias: expected shape \(9,\), got shape'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_network_that_the_tensors_do_not_fit_is_refused(checkpoint):
    change_manifest(checkpoint, lambda m: m['network'].update(blocks=2))
    with pytest.raises(WeightsError, match=r'cross_layers\.1\..*got none'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_unknown_network_setting_is_refused(checkpoint):
    change_manifest(checkpoint, lambda m: m['network'].update(dropout=0.1))
    with pytest.raises(WeightsError, match=r'network\.dropout'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_file_that_is_no_safetensors_is_refused(checkpoint):
    import hashlib

    checkpoint.write_bytes(b'nonsense')
    digest = hashlib.sha256(b'nonsense').hexdigest()
    change_manifest(checkpoint, lambda manifest: manifest.update(sha256=digest))
    with pytest.raises(WeightsError, match='not a safetensors file'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))
    checkpoint.rename(checkpoint.with_suffix('.pt'))
    with pytest.raises(WeightsError, match=r'expected a \.safetensors file'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint.with_suffix('.pt'))))


def test_manifest_that_is_no_json_is_refused(checkpoint):
    checkpoint.with_suffix('.json').write_text('{')
    with pytest.raises(WeightsError, match='not valid JSON'):
        LearnedMatcher(MatcherConfig(weights=str(checkpoint)))


def test_two_plans_in_turn_and_their_submap_are_prepared_once_each(monkeypatch):
    matcher = LearnedMatcher(MatcherConfig())
    rng = np.random.default_rng(5)
    (plan, sub, _), (mirror, _, _), (other, _, _) = (toy_pair(rng, rooms=n) for n in (6, 7, 8))
    prepared = []
    prepare = type(matcher._network).prepared
    monkeypatch.setattr(
        type(matcher._network),
        'prepared',
        lambda self, graph: prepared.append(graph) or prepare(self, graph),
    )
    for graph in (plan, mirror, plan, mirror, other, mirror):
        matcher.match(graph, sub, 100.0)
    expected = (plan, sub, mirror, other)
    assert [id(graph) for graph in prepared] == [id(graph) for graph in expected]
