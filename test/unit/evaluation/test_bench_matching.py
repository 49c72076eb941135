# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from graph_pairs import toy_pair
import numpy as np
import pytest

from fpnet_core.evaluation.matching import bench_matching
from fpnet_core.geometry import SE2
from fpnet_core.sim.pairs import MatchingPair
from fpnet_core.types import MatchResult


class Oracle:
    """Answers with the labels it was given, one of them wrong if asked."""

    def __init__(self, labels, spoil=False):
        self.labels, self.spoil = {len(v): v for v in labels}, spoil

    def match(self, plan, sub, explored_area_m2):
        assert explored_area_m2 == 123.0
        labels = self.labels[len(sub)].copy()
        if self.spoil:
            labels[[0, 1]] = labels[[1, 0]]
        pairs = np.stack([labels, np.arange(len(labels))], axis=1)
        return MatchResult(pairs, np.ones(len(pairs)), np.zeros((len(plan), len(sub))))


def test_methods_are_scored_on_the_same_pairs():
    rng = np.random.default_rng(0)
    toys = [toy_pair(rng, rooms=6, seen=seen) for seen in (2, 4)]
    pairs = [MatchingPair(*toy, SE2.identity(), 123.0, 0, 'toy') for toy in toys]
    sizes = [len(labels) for _, _, labels in toys]
    labels = [item[2] for item in toys]
    done = []
    report = bench_matching(
        iter(pairs), {'right': Oracle(labels), 'spoiled': Oracle(labels, True)}, done.append
    )
    assert report['pairs'] == 2 == sum(done)
    right, spoiled = report['methods']['right'], report['methods']['spoiled']
    assert right['ms'] == right['match_precision'] == right['match_recall'] == 1.0
    assert spoiled['match_precision'] == pytest.approx(1 - 4 / sum(sizes))
    assert spoiled['ms'] == pytest.approx(np.mean([1 - 2 / n for n in sizes]))
    assert right['ms_per_pair'] >= 0.0


def test_no_pairs_give_an_empty_report():
    report = bench_matching(iter([]), {'right': Oracle([])})
    assert report['pairs'] == 0
    assert report['methods']['right']['ms'] == 0.0
