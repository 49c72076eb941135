# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Partners are looked for nearby only, and are those that a look at all regions finds."""

from graph_pairs import toy_pair
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from fpnet_core.matching import kernels
from fpnet_core.matching.geometry import graph_geometry


def fitted(similarity, weight, plan, sub):
    partner = np.empty((len(similarity), len(sub)), dtype=np.int64)
    fit = np.empty(partner.shape)
    sides = (plan.point, plan.box, plan.is_door, sub.point, sub.box, sub.is_door)
    kernels.fit_regions(similarity, weight, *sides, partner, fit)
    return partner, fit


def alone(similarity, weight, plan, sub):
    """Return the partners of one plan region after the other, each without all the others."""
    best = np.zeros((len(similarity), len(sub)))
    partner, fit = np.full(best.shape, -1), np.zeros(best.shape)
    for i in range(len(plan)):
        one = slice(i, i + 1)
        sides = (plan.point[one], plan.box[one], plan.is_door[one])
        found, value = np.empty(best.shape, dtype=np.int64), np.empty(best.shape)
        kernels.fit_regions(
            similarity, weight[one], *sides, sub.point, sub.box, sub.is_door, found, value
        )
        is_better = (found == 0) & (value * weight[i] > best)
        best = np.where(is_better, value * weight[i], best)
        partner, fit = np.where(is_better, i, partner), np.where(is_better, value, fit)
    return partner, fit


@given(seed=st.integers(0, 10_000), spread=st.floats(0.0, 60.0), rooms=st.integers(2, 14))
@settings(max_examples=25, deadline=None)
def test_tiles_miss_no_partner(seed, spread, rooms):
    rng = np.random.default_rng(seed)
    plan, sub, _ = toy_pair(rng, rooms=rooms, seen=rooms // 2 + 1)
    plan, sub = graph_geometry(plan), graph_geometry(sub)
    yaw, size = rng.uniform(-np.pi, np.pi, 8), rng.uniform(0.6, 1.6, 8)
    shift = rng.normal(scale=spread, size=(8, 2))
    similarity = np.column_stack([size * np.cos(yaw), size * np.sin(yaw), shift])
    similarity[0] = (1.0, 0.0, 0.0, 0.0)
    weight = rng.uniform(0.3, 1.3, (len(plan), len(sub)))
    found, expected = (call(similarity, weight, plan, sub) for call in (fitted, alone))
    assert found[0].tolist() == expected[0].tolist()
    assert found[1] == pytest.approx(expected[1])


def test_what_lies_far_from_all_regions_has_no_partner():
    plan, sub, _ = toy_pair(np.random.default_rng(1), rooms=6, seen=3)
    plan, sub = graph_geometry(plan), graph_geometry(sub)
    away = np.array([[1.0, 0.0, 1e7, -1e7], [1.0, 0.0, -1e7, 1e7]])
    partner, fit = fitted(away, np.ones((len(plan), len(sub))), plan, sub)
    assert (partner == -1).all()
    assert (fit == 0.0).all()
