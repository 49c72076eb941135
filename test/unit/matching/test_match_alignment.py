# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Placements settled on the outlines of what they match."""

import numpy as np
import pytest

from fpnet_core.matching.alignment import aligned
from fpnet_core.matching.geometry import GraphGeometry


def geometry(boxes, is_door, observed=None):
    boxes = np.asarray(boxes, dtype=float)
    count = len(boxes)
    return GraphGeometry(
        point=boxes[:, :2],
        box=boxes,
        is_door=np.asarray(is_door),
        observed=np.ones(count) if observed is None else np.asarray(observed),
        linked=np.zeros((count, count), dtype=np.bool_),
        unit=1.0,
        origin=np.zeros(2),
        outlines=(),
        unseen=np.zeros(count),
    )


def moved(boxes, similarity):
    """Return the boxes under the similarity (a, b, x, y)."""
    a, b, x, y = similarity
    boxes = np.asarray(boxes, dtype=float)
    scale, yaw = np.hypot(a, b), np.arctan2(b, a)
    centre = boxes[:, :2] @ np.array([[a, b], [-b, a]]) + [x, y]
    return np.column_stack([centre, boxes[:, 2:4] * scale, boxes[:, 4] + yaw])


def settle(similarity, partner, plan, sub, fit=None):
    """Return the placement and how far each outline is apart."""
    partner = np.asarray(partner)[None]
    fit = np.ones(partner.shape) if fit is None else np.asarray(fit, dtype=float)[None]
    settled, apart = aligned(np.asarray(similarity, dtype=float)[None], partner, fit, plan, sub)
    return settled[0], apart[0]


TRUE = (0.9, 0.5, 4.0, -2.0)
ROOM = [0.0, 0.0, 3.0, 2.0, 0.1]
DOOR = [3.1, 0.2, 0.5, 0.1, np.pi / 2]
OTHER = [7.0, 1.0, 2.5, 2.4, 0.0]


@pytest.mark.parametrize(
    ('boxes', 'is_door'), [([ROOM, DOOR], [False, True]), ([ROOM], [False]), ([DOOR], [True])]
)
def test_a_rough_placement_is_settled(boxes, is_door):
    plan, sub = geometry(moved(boxes, TRUE), is_door), geometry(boxes, is_door)
    rough = np.add(TRUE, [0.03, -0.06, 0.3, -0.2])

    settled, apart = settle(rough, np.arange(len(boxes)), plan, sub)

    assert settled == pytest.approx(TRUE, abs=0.02)
    assert apart == pytest.approx(0.0, abs=0.01)


def test_one_wrong_partner_does_not_pull():
    boxes, is_door = [ROOM, DOOR, OTHER], [False, True, False]
    target = moved(boxes, TRUE)
    target[2, :2] += [1.5, -1.0]

    settled, apart = settle(TRUE, [0, 1, 2], geometry(target, is_door), geometry(boxes, is_door))

    assert settled == pytest.approx(TRUE, abs=0.05)
    assert apart[2] > 10.0 * apart[:2].max()


@pytest.mark.parametrize('yaw', [0.0, 0.7, np.pi / 2])
def test_outlines_are_apart_by_their_gaps(yaw):
    turn = (np.cos(yaw), np.sin(yaw), 3.0, 1.0)
    boxes = [ROOM, DOOR, OTHER, [0.0, 9.0, 3.0, 2.0, 0.0], [0.0, 18.0, 2.0, 2.0, 0.0]]
    is_door, seen = [False, True, False, False, False], [1.0, 1.0, 1.0, 0.2, 0.2]
    sub = np.array(boxes)
    sub[2, 2] += 0.5  # both ends of a room that was seen well, by half a unit each
    sub[3, 2] += 0.5  # of one that was not, by as much beyond its partner
    sub[4, 2:4] -= 0.5  # within its partner
    plan = geometry(moved(boxes, turn), is_door)

    _, apart = settle(turn, range(5), plan, geometry(sub, is_door, seen))

    beyond = np.log1p((0.5 / 0.25) ** 2)
    # Settling on them shrinks them a little, too.
    assert apart == pytest.approx([0.0, 0.0, 0.5 * beyond, beyond, 0.0], abs=0.2)
