# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys in one contest: probabilities add up, order says nothing, more prior helps."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from fpnet_core.geometry import SE2, Placements
from fpnet_core.scoring import CONTEXT, FIGURES, Evidence, PlacementScorer, read_scorer
from fpnet_core.scoring.competing import Explained
from fpnet_core.scoring.evidence import on_one_plan
from fpnet_core.sites import Link, LinkKind, Site, Storey
from fpnet_core.sites.storey_plans import weights_after_leaving

SCORER = PlacementScorer(read_scorer(), 0.99)
SUPPORTED = ('support', 'bent_support', 'score', 'bent_score', 'seen', 'rooms_pure')
storeys = st.lists(
    st.lists(st.floats(0.05, 1.0), min_size=1, max_size=4), min_size=2, max_size=5
)  # fmt: skip


def posterior(support, walls=120):
    support = np.sort(support)[::-1]
    figures = np.zeros((len(support), len(FIGURES)), np.float32)
    for name in SUPPORTED:
        figures[:, FIGURES.index(name)] = support
    explained = (np.arange(walls) < walls * support[:, None]).astype(np.float32)
    context = np.zeros(len(CONTEXT), np.float32)
    context[CONTEXT.index('log_plan_m2')] = 5.0
    placements = Placements.of([SE2.from_xy_yaw(5.0 * k, 0, 0) for k in range(len(support))])
    seen = Explained(explained, explained, 0.5)
    # Figures against rivals, and of the comparison as a whole, are as of a search.
    return SCORER.weighed(placements, on_one_plan([Evidence(figures, context, seen)]))


def among(drawn, priors=None):
    return SCORER.among_storeys(drawn, priors or [0.0] * len(drawn), [True] * len(drawn))


@settings(max_examples=40, deadline=None)
@given(storeys)
def test_probabilities_add_up(supports):
    told = among([posterior(each) for each in supports])
    placed = sum(float(each.placements.probability.sum()) for each in told)
    for each in told:
        assert placed + each.none + each.foreign == pytest.approx(1.0)
        own = float(each.placements.probability.sum())
        assert own + each.elsewhere == pytest.approx(placed)


@settings(max_examples=40, deadline=None)
@given(storeys, st.randoms(use_true_random=False))
def test_the_order_says_nothing(supports, random):
    order = list(range(len(supports)))
    random.shuffle(order)
    drawn = [posterior(each) for each in supports]
    straight, shuffled = among(drawn), among([drawn[k] for k in order])
    for k, each in zip(order, shuffled, strict=True):
        assert each.best == pytest.approx(straight[k].best, rel=1e-3, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(storeys, st.floats(0.1, 3.0))
def test_more_prior_makes_a_storey_more_probable(supports, nats):
    drawn = [posterior(each) for each in supports]
    even = among(drawn)[0].best
    assert among(drawn, [nats] + [0.0] * (len(drawn) - 1))[0].best >= even


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.sets(st.integers(0, 4), min_size=2, max_size=5), max_size=4),
    st.integers(0, 4),
    st.one_of(st.none(), st.floats(-10.0, 10.0)),
)
def test_weights_after_leaving_are_of_all_storeys_and_positive(links, left, rise_m):
    storeys = tuple(Storey(f'L{k}', None, level=k, elevation_m=3.0 * k) for k in range(5))
    joined = tuple(
        Link(f'lift {n}', LinkKind.LIFT, {f'L{k}': np.array([float(k), n]) for k in stops})
        for n, stops in enumerate(links)
    )
    site = Site('s', storeys, joined)
    weights = weights_after_leaving(site, f'L{left}', np.zeros(2), rise_m)
    assert set(weights) == set(site.names)
    assert all(0.0 < weight < np.inf for weight in weights.values())
