# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Placements that single regions propose."""

from graph_pairs import toy_pair
import numpy as np
import pytest

from fpnet_core.matching.anchors import anchored
from fpnet_core.matching.geometry import graph_geometry

WINDOW = 0.7


def moved(side, similarity):
    """Return the geometry of ``side`` under the similarity (a, b, x, y)."""
    a, b, x, y = similarity
    linear, scale = np.array([[a, -b], [b, a]]), np.hypot(a, b)
    box = side.box.copy()
    box[:, :2] = box[:, :2] @ linear.T + [x, y]
    box[:, 2:4] *= scale
    box[:, 4] += np.arctan2(b, a)
    return type(side)(
        side.point @ linear.T + [x, y],
        box,
        side.is_door,
        side.observed,
        side.linked,
        1.0,
        np.zeros(2),
        tuple(ring @ linear.T + [x, y] for ring in side.outlines),
        side.unseen,
    )


@pytest.mark.parametrize('scale', [1.0, 1.25])
@pytest.mark.parametrize('is_door', [True, False])
def test_a_door_or_a_room_alone_proposes_where_it_is(scale, is_door):
    plan, _, _ = toy_pair(np.random.default_rng(3), rooms=5, seen=4)
    side = graph_geometry(plan)
    true = (scale * np.cos(2.0), scale * np.sin(2.0), 4.0, -7.0)
    one = int(np.flatnonzero(side.is_door == is_door)[1])
    alone = type(side)(
        side.point[[one]],
        side.box[[one]],
        side.is_door[[one]],
        side.observed[[one]],
        side.linked[:1, :1],
        1.0,
        np.zeros(2),
        (side.outlines[one],),
        side.unseen[[one]],
    )

    found = anchored(moved(side, true), alone, np.array([[one, -1]]), WINDOW)

    assert np.abs(found - true).max(axis=1).min() < 1e-6
    assert np.abs(np.log(np.hypot(found[:, 0], found[:, 1]))).max() <= WINDOW
