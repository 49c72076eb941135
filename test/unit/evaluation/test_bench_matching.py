# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from graph_pairs import toy_pair
import numpy as np
import pytest

from fpnet_core.geometry import Similarity2D
from fpnet_core.matches import MatchResult
from fpnet_lab.evaluation.matching import predict, score
from fpnet_lab.sim.pairs.pair import MatchingPair


class Oracle:
    """Answers with the labels it was given, two of them exchanged if asked."""

    def __init__(self, labels, spoil=False):
        self.labels, self.spoil = {len(v): v for v in labels}, spoil

    def match(self, plan, sub, explored_area_m2):
        assert explored_area_m2 == 123.0
        labels = self.labels[len(sub)].copy()
        if self.spoil:
            labels[[0, 1]] = labels[[1, 0]]
        pairs = np.stack([labels, np.arange(len(labels))], axis=1)
        return MatchResult(pairs, np.ones(len(pairs)), np.zeros((len(plan), len(sub))))


def fitted(plan, sub, labels):
    """Return the true transform of a toy pair, from the centroids of its partners."""
    target = np.array([plan.regions[i].centroid for i in labels]) @ [1, 1j]
    source = np.array([region.centroid for region in sub.regions]) @ [1, 1j]
    slope, offset = np.polyfit(source, target, 1)
    return Similarity2D.from_scale_yaw(abs(slope), np.angle(slope), [offset.real, offset.imag])


@pytest.fixture
def pairs():
    rng = np.random.default_rng(0)
    toys = [toy_pair(rng, rooms=6, seen=seen) for seen in (2, 4)]
    return [MatchingPair(*toy, fitted(*toy), 123.0, 0, 'toy') for toy in toys]


def test_methods_are_scored_on_the_same_pairs(pairs):
    labels = [pair.sub_labels for pair in pairs]
    done = []
    said = predict(
        iter(pairs), {'right': Oracle(labels), 'spoiled': Oracle(labels, True)}, done.append
    )
    assert sum(done) == 2
    figures = score(pairs, said)
    right, spoiled = figures['right'], figures['spoiled']
    assert right['ms'] == right['match_precision'] == right['match_recall'] == 1.0
    assert right['ts'] == right['recall_05m_5deg'] == 1.0
    assert right['auc10'] > 0.9 > 0.0
    sizes = [len(v) for v in labels]
    assert spoiled['match_precision'] == pytest.approx(1 - 4 / sum(sizes))
    assert spoiled['ms'] == pytest.approx(np.mean([1 - 2 / n for n in sizes]))
    assert right['ms_per_pair'] > 0.0
