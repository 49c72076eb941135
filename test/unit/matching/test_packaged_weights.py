# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The checkpoint that ships."""

from importlib import resources

from graph_pairs import toy_pair
import numpy as np
import pytest

from fpnet_core.config import MatcherConfig
from fpnet_core.io.weights import PACKAGED_NAME, read_weights
from fpnet_core.matching import mutual_pairs
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.evaluation.pair_sets import SEED
from fpnet_lab.metrics import MatchCounts, count_matches
from fpnet_lab.sim.pairs.pair import generate_pair
from fpnet_lab.sim.pairs.presets import preset


def test_packaged_weights_are_small_and_tell_where_they_come_from():
    weights = read_weights(None, FEATURE_SCHEMA)
    size = len((resources.files('fpnet_core.weights') / PACKAGED_NAME).read_bytes())
    assert size < 10_000_000
    assert {'config', 'data', 'versions'} <= set(weights.manifest['training'])
    assert weights.manifest['training']['data']['pairs'] > 1000
    assert weights.manifest['training']['data']['source'] == {'kind': 'generated'}


def test_the_figure_in_the_manifest_comes_out_on_buildings_made_now():
    """Pairs of the benchmark's seed, which no training has seen; 48 of them give 0.926."""
    manifest = read_weights(None, FEATURE_SCHEMA).manifest
    assert manifest['training']['data']['seed'] != SEED
    matcher = LearnedMatcher(MatcherConfig(), settle=False)
    counts = MatchCounts(0, 0, 0)
    for index in range(16):
        pair = generate_pair(SEED, 8 * index, preset('default').config)
        soft = matcher.likelihood(pair.plan_graph, pair.sub_graph)
        matches = mutual_pairs(soft, manifest['training']['config']['match_threshold'])
        counts = counts + count_matches(matches, pair.sub_labels)
    # Eight pairs scatter by 0.03, and the generator has changed since the weights were made.
    assert counts.f1 == pytest.approx(manifest['figures']['validation']['val_f1'], abs=0.08)
    # These sixteen are no harder from day to day; positions in units twice as long cost 0.03.
    assert counts.f1 == pytest.approx(0.962, abs=0.02)


def test_packaged_network_finds_rooms_of_buildings_it_never_saw():
    rng = np.random.default_rng(11)
    matcher = LearnedMatcher(MatcherConfig())
    right = total = 0
    for _ in range(10):
        plan, sub, labels = toy_pair(rng, rooms=12, seen=7)
        pairs = matcher.match(plan, sub, 300.0).pairs
        right += int(np.count_nonzero(labels[pairs[:, 1]] == pairs[:, 0]))
        total += len(labels)
    # Toy corridors are no building of the generator; chance would be one in 25.
    assert right > 0.6 * total
