# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Placements settled on the outlines of what they match."""

import numpy as np
import pytest

from fpnet_core.matching.alignment import aligned, corners
from fpnet_core.matching.consensus import EVIDENCE, Assignments
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
    )


def moved(boxes, similarity):
    """Return the boxes under the similarity (a, b, x, y)."""
    a, b, x, y = similarity
    boxes = np.asarray(boxes, dtype=float)
    scale, yaw = np.hypot(a, b), np.arctan2(b, a)
    centre = boxes[:, :2] @ np.array([[a, b], [-b, a]]) + [x, y]
    return np.column_stack([centre, boxes[:, 2:4] * scale, boxes[:, 4] + yaw])


def assignments(similarity, partner, fit=None):
    partner = np.asarray(partner)[None]
    fit = np.ones(partner.shape) if fit is None else np.asarray(fit, dtype=float)[None]
    evidence = np.zeros((1, len(EVIDENCE)))
    return Assignments(np.asarray(similarity, dtype=float)[None], partner, fit, evidence)


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

    settled = aligned(assignments(rough, np.arange(len(boxes))), plan, sub)

    assert settled[0] == pytest.approx(TRUE, abs=0.02)


def test_one_wrong_partner_does_not_pull():
    boxes, is_door = [ROOM, DOOR, OTHER], [False, True, False]
    target = moved(boxes, TRUE)
    target[2, :2] += [1.5, -1.0]

    settled = aligned(
        assignments(TRUE, [0, 1, 2]), geometry(target, is_door), geometry(boxes, is_door)
    )

    assert settled[0] == pytest.approx(TRUE, abs=0.05)


def test_a_room_that_was_glimpsed_counts_little():
    boxes, is_door = [ROOM, OTHER], [False, False]
    target = moved(boxes, TRUE)
    target[1, 2:4] *= 1.3

    settled = aligned(
        assignments(TRUE, [0, 1]),
        geometry(target, is_door),
        geometry(boxes, is_door, observed=[1.0, 0.3]),
    )

    assert settled[0] == pytest.approx(TRUE, abs=0.02)


def test_a_placement_without_partners_stays():
    side = geometry([ROOM], [False])

    settled = aligned(assignments(TRUE, [-1], [0.0]), side, side)

    assert settled[0] == pytest.approx(TRUE)


def test_corners_are_those_of_the_boxes():
    ends = corners(geometry([[1.0, 2.0, 3.0, 0.5, 0.0]], [True]))[0]
    room = corners(geometry([[1.0, 2.0, 3.0, 0.5, 0.0]], [False]))[0]

    assert {tuple(p) for p in ends.round(9).tolist()} == {(4.0, 2.0), (-2.0, 2.0)}
    assert {tuple(p) for p in room.round(9).tolist()} == {
        (4.0, 2.5),
        (-2.0, 2.5),
        (-2.0, 1.5),
        (4.0, 1.5),
    }
