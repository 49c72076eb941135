# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import csv
import json

from graph_pairs import toy_pair
import numpy as np
import pytest
import torch

from fpnet_core.config import MatcherConfig
from fpnet_core.errors import ConfigError, WeightsError
from fpnet_core.graphs.features import AREA, LABEL, PAPER_LAYOUT
from fpnet_core.io.weights import read_weights
from fpnet_core.matches import UNMATCHED
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.models.invariant import InvariantNetwork
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.baselines import NearestNeighborMatcher
from fpnet_lab.metrics import MatchCounts, count_matches
from fpnet_lab.training import (
    Hooks,
    PairArrays,
    Trainer,
    parse_training_config,
    split_by_plan,
)
from fpnet_lab.training.config import AugmentationConfig
from fpnet_lab.training.data import augment
from fpnet_lab.training.loop import make_fabric

NO_CHANGE = AugmentationConfig(
    mirror_probability=0.0,
    feature_noise=0.0,
    scale_noise=0.0,
    crop_probability=0.0,
    drop_probability=0.0,
)
QUICK = {
    'epochs': 3,
    'batch_size': 8,
    'network.kind': 'paper',
    'network.width': 8,
    'network.blocks': 1,
    'network.position_widths': [6],
}


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
            InvariantNetwork.rows(plan),
            plan.edges,
            InvariantNetwork.rows(sub),
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
