# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Training of the matcher: losses, optimiser, runs that go on, what is refused."""

import csv
import json
import math

from graph_pairs import toy_pair
import numpy as np
import pytest
import torch
from torch import nn

from fpnet_core.config import MatcherConfig
from fpnet_core.errors import ConfigError, WeightsError
from fpnet_core.graphs.features import AREA, LABEL, PAPER_LAYOUT
from fpnet_core.io.weights import read_weights
from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.joint_attention import JointAttention
from fpnet_core.models.paper import pair_distances, sinkhorn
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.baselines import NearestNeighborMatcher
from fpnet_lab.metrics import MatchCounts, count_matches
from fpnet_lab.training import Hooks, PairArrays, Trainer, parse_training_config, split_by_plan
from fpnet_lab.training.checkpoint import load_state, save_state
from fpnet_lab.training.config import AugmentationConfig, LossConfig
from fpnet_lab.training.data import augment
from fpnet_lab.training.loop import make_fabric
from fpnet_lab.training.losses import match_loss, matching_loss, spatial_loss, topology_loss
from fpnet_lab.training.networks.tensors import TORCH
from fpnet_lab.training.optimizer import Muon, orthogonalized

NO_CHANGE = AugmentationConfig(
    mirror_probability=0.0,
    feature_noise=0.0,
    scale_noise=0.0,
    crop_probability=0.0,
    drop_probability=0.0,
)
QUICK = {
    'epochs': 3, 'batch_size': 8, 'network.kind': 'paper', 'network.width': 8,
    'network.blocks': 1, 'network.position_widths': [6],
}  # fmt: skip


def arrays(plan, sub, labels, plan_id=0):
    return PairArrays(plan.node_feat, plan.edges, sub.node_feat, sub.edges, labels, plan_id, 0)


def toy_arrays(count, seed=0, rooms=8, seen=4):
    rng = np.random.default_rng(seed)
    return [arrays(*toy_pair(rng, rooms, seen), plan_id=i) for i in range(count)]


def test_split_keeps_plans_apart():
    pairs = [p for plan in range(10) for p in [toy_arrays(1)[0]] * 3]
    pairs = [
        PairArrays(p.plan_feat, p.plan_edges, p.sub_feat, p.sub_edges, p.labels, i // 3, i)
        for i, p in enumerate(pairs)
    ]
    training, validation = split_by_plan(pairs, 0.2, seed=0)
    ids = [{p.plan_id for p in part} for part in (training, validation)]
    assert not ids[0] & ids[1]
    assert len(training) + len(validation) == 30
    assert len(validation) in (3, 6, 9, 12)
    fewer = split_by_plan(pairs[:15], 0.2, seed=0)[1]
    assert {p.plan_id for p in fewer} <= ids[1]


def test_dropping_regions_keeps_labels_on_the_same_regions():
    pair = toy_arrays(1)[0]
    config = NO_CHANGE.model_copy(update={'drop_probability': 0.4})
    changed = augment(pair, PAPER_LAYOUT, config, np.random.default_rng(4))
    assert len(changed.plan_feat) < len(pair.plan_feat)
    assert len(changed.labels) == len(changed.sub_feat) < len(pair.sub_feat)
    # Area tells the toy rooms apart and survives augmentation.
    kept = changed.plan_feat[:, AREA.start]
    by_area = {float(a): i for i, a in enumerate(pair.plan_feat[:, AREA.start])}
    by_sub_area = {float(a): i for i, a in enumerate(pair.sub_feat[:, AREA.start])}
    for row, label in zip(changed.sub_feat, changed.labels, strict=True):
        original = pair.labels[by_sub_area[float(row[AREA.start])]]
        is_room = row[LABEL][1] == 1.0
        if label == UNMATCHED and is_room:
            assert float(pair.plan_feat[original, AREA.start]) not in kept.tolist()
        elif is_room:
            assert by_area[float(kept[label])] == original
    for edges, rows in (
        (changed.plan_edges, changed.plan_feat),
        (changed.sub_edges, changed.sub_feat),
    ):
        assert edges.max(initial=0) < len(rows)


def test_run_folder_holds_what_the_matcher_loads(tmp_path):
    pairs = toy_arrays(16)
    seen = []
    trainer = Trainer(parse_training_config(QUICK), tmp_path, recipe={'pairs': 16})
    trainer.fit(pairs[:12], pairs[12:], Hooks(on_pairs=seen.append))
    assert sum(seen) == 3 * 12
    rows = list(csv.DictReader((tmp_path / 'curves.csv').open()))
    assert [row['epoch'] for row in rows] == ['0', '1', '2']
    manifest = json.loads((tmp_path / 'matcher.json').read_text())
    assert manifest['training']['data'] == {'pairs': 16}
    assert manifest['figures']['validation']['val_loss'] == trainer.best_loss
    LearnedMatcher(MatcherConfig(weights=str(tmp_path / 'matcher.safetensors')))


def test_resumed_run_equals_an_uninterrupted_one(tmp_path):
    pairs = toy_arrays(20)
    config = parse_training_config(QUICK)
    whole = Trainer(config, tmp_path / 'whole')
    whole.fit(pairs[:16], pairs[16:])

    class Stop(Exception):
        pass

    def stop_after_first(record):
        if record.epoch == 0:
            raise Stop

    with pytest.raises(Stop):
        Trainer(config, tmp_path / 'parts').fit(
            pairs[:16], pairs[16:], Hooks(on_epoch=stop_after_first)
        )
    resumed = Trainer(config, tmp_path / 'parts')
    assert resumed.next_epoch == 1
    resumed.fit(pairs[:16], pairs[16:])
    for name, value in whole.bare_network.state_dict().items():
        torch.testing.assert_close(resumed.bare_network.state_dict()[name], value)


def test_folder_of_another_run_is_refused(tmp_path):
    Trainer(parse_training_config(QUICK), tmp_path)
    with pytest.raises(ConfigError, match='other settings'):
        Trainer(parse_training_config(QUICK | {'seed': 1}), tmp_path)


def test_run_may_start_from_a_checkpoint(tmp_path):
    pairs = toy_arrays(4)
    config = parse_training_config(QUICK | {'epochs': 1})
    first = Trainer(config, tmp_path / 'first')
    first.fit(pairs[:3], pairs[3:])
    initial = read_weights(tmp_path / 'first' / 'matcher.safetensors', FEATURE_SCHEMA)
    second = Trainer(config, tmp_path / 'second', initial=initial)
    for name, value in first.bare_network.state_dict().items():
        torch.testing.assert_close(second.bare_network.state_dict()[name], value)
    assert second.recipe['initial_sha256'] == initial.manifest['sha256']
    wider = parse_training_config(QUICK | {'network.width': 10})
    with pytest.raises(WeightsError, match='expected shape'):
        Trainer(wider, tmp_path / 'wider', initial=initial)


def test_damaged_state_is_refused(tmp_path):
    pairs = toy_arrays(4)
    config = parse_training_config(QUICK)
    Trainer(config, tmp_path).fit(pairs[:3], pairs[3:])
    (tmp_path / 'last.safetensors').write_bytes(b'nonsense')
    with pytest.raises(WeightsError, match='not a training state'):
        Trainer(config, tmp_path)


@pytest.mark.parametrize(
    ('overrides', 'message'),
    [
        ({'network.widht': 64}, r'network\.invariant\.widht'),
        ({'epochs': 0}, 'epochs'),
        ({'network.width': 27}, 'multiple of heads'),
    ],
)
def test_bad_settings_are_named(overrides, message):
    with pytest.raises(ConfigError, match=message):
        parse_training_config(overrides)


@pytest.mark.parametrize('device', ['tpu', 'cuda:x', 'cuda:99'])
def test_bad_devices_are_refused(device, tmp_path):
    with pytest.raises(ConfigError, match='device'):
        make_fabric(device, tmp_path)


@pytest.mark.timeout(120)
def test_network_learns_to_beat_nearest_neighbour(tmp_path):
    rng = np.random.default_rng(0)
    toys = [toy_pair(rng, rooms=6, seen=3) for _ in range(48)]
    pairs = [
        PairArrays(
            JointAttention.rows(plan),
            plan.edges,
            JointAttention.rows(sub),
            sub.edges,
            labels,
            i,
            i,
        )
        for i, (plan, sub, labels) in enumerate(toys)
    ]
    config = parse_training_config(
        {
            'epochs': 20,
            'batch_size': 8,
            'learning_rate': 4e-3,
            'patience': 25,
            'network.width': 32,
            'network.layers': 3,
            'augmentation.drop_probability': 0.0,
            'augmentation.crop_probability': 0.0,
        }
    )
    # Overfitting is the aim: the same pairs validate.
    Trainer(config, tmp_path).fit(pairs, pairs)
    settings = MatcherConfig(
        weights=str(tmp_path / 'matcher.safetensors'), grade_thresholds=(0.1, 0.1, 0.1)
    )
    learned, nearest = (
        sum(
            (count_matches(m.match(p, s, 500.0).pairs, labels) for p, s, labels in toys),
            MatchCounts(0, 0, 0),
        )
        for m in (LearnedMatcher(settings), NearestNeighborMatcher(settings))
    )
    assert learned.recall > nearest.recall + 0.1
    assert learned.f1 > nearest.f1 + 0.1


def test_small_parameters_step_as_under_adamw():
    ours, theirs = (nn.Linear(8, 4) for _ in range(2))
    theirs.load_state_dict(ours.state_dict())
    pair = (
        (ours, Muon(ours.parameters(), lr=0.01, weight_decay=0.1)),
        (theirs, torch.optim.AdamW(theirs.parameters(), lr=0.01, weight_decay=0.1)),
    )
    rows = torch.linspace(-1.0, 1.0, 24).reshape(3, 8)
    for _ in range(3):
        for layer, optimizer in pair:
            optimizer.zero_grad()
            layer(rows).square().sum().backward()
            optimizer.step()

    assert torch.equal(ours.weight, theirs.weight)


def test_a_linear_map_is_learned():
    torch.manual_seed(0)
    truth, learned = torch.randn(32, 32), nn.Linear(32, 32, bias=False)
    optimizer = Muon(learned.parameters(), lr=0.1, weight_decay=0.0)
    rows = torch.randn(256, 32)

    def loss():
        return (learned(rows) - rows @ truth.T).square().mean()

    first = loss().item()
    for _ in range(150):
        optimizer.zero_grad()
        loss().backward()
        optimizer.step()
    assert loss().item() < 0.05 * first


def test_a_saved_state_goes_on_where_it_was(tmp_path):
    def stepped(layer, optimizer, count):
        for _ in range(count):
            optimizer.zero_grad()
            layer(torch.linspace(-1.0, 1.0, 48).reshape(1, 48)).square().sum().backward()
            optimizer.step()

    torch.manual_seed(3)
    whole, parts = nn.Linear(48, 40), nn.Linear(48, 40)
    parts.load_state_dict(whole.state_dict())
    first = Muon(whole.parameters(), lr=0.01, weight_decay=0.1)
    stepped(whole, first, 4)
    second = Muon(parts.parameters(), lr=0.01, weight_decay=0.1)
    stepped(parts, second, 2)
    save_state(tmp_path / 'state.safetensors', parts, second, {'epoch': 1})

    again = nn.Linear(48, 40)
    third = Muon(again.parameters(), lr=0.01, weight_decay=0.1)
    assert load_state(tmp_path / 'state.safetensors', again, third) == {'epoch': 1}
    stepped(again, third, 2)

    assert torch.equal(again.weight, whole.weight)
    assert torch.equal(again.bias, whole.bias)


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
        log_x = sinkhorn(TORCH, values, dustbin, PLAN_MASK, mask, 20)
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


def test_topology_loss_counts_broken_and_invented_edges():
    assignment = hard_assignment()[:, :-1, :-1]
    adjacency = prepared_plan().adjacency
    labels = torch.tensor([[2, 1, UNMATCHED, IGNORE]])
    # True partners 2 and 1 are adjacent; the assignment says 2 and 0, which are not.
    assert float(topology_loss(assignment, labels, adjacency)) == pytest.approx(1.0)


def test_spatial_loss_is_the_expected_distance():
    assignment = torch.zeros((1, 5, 4), dtype=torch.float64)
    assignment[0, 1, 0], assignment[0, 2, 0] = 0.5, 0.25
    labels = torch.tensor([[2, IGNORE, IGNORE, IGNORE]])
    # Nodes 1 and 2 are at (0.3, 0.4) and (1.0, 0.1).
    expected = 0.5 * math.hypot(0.7, 0.3)
    loss = spatial_loss(assignment, labels, pair_distances(TORCH, prepared_plan()))
    assert float(loss) == pytest.approx(expected)


@pytest.mark.parametrize('shape', [(3, 40, 40), (2, 32, 64), (1, 96, 48)])
def test_directions_have_singular_values_of_about_one(shape):
    matrices = torch.randn(shape, generator=torch.Generator().manual_seed(1))

    values = torch.linalg.svdvals(orthogonalized(matrices))

    assert values.min() > 0.3
    assert values.max() < 1.3


def test_directions_keep_the_singular_vectors():
    matrix = torch.randn((1, 40, 40), generator=torch.Generator().manual_seed(2))
    u, _, vh = torch.linalg.svd(matrix)

    turned = u.mT @ orthogonalized(matrix) @ vh.mT

    off_diagonal = turned - torch.diag_embed(torch.diagonal(turned, dim1=-2, dim2=-1))
    assert off_diagonal.abs().max() < 1e-3


def test_blocks_of_a_tall_matrix_step_on_their_own():
    layer = nn.Linear(32, 96, bias=False)
    before = layer.weight.detach().clone()
    optimizer = Muon(layer.parameters(), lr=0.1, weight_decay=0.0)
    layer.weight.grad = torch.zeros_like(layer.weight)
    layer.weight.grad[:32] = torch.eye(32)

    optimizer.step()

    moved = (layer.weight.detach() - before).abs().amax(dim=1)
    assert (moved[:32] > 0.0).all()
    assert (moved[32:] == 0.0).all()
