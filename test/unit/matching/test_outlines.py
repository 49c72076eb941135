# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What was seen of rooms against what the plan draws of them."""

import numpy as np
import pytest

from fpnet_core.matching.outlines import EXPLAINED, explained, painted, seen, walls_apart

LEFT = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 5.0], [0.0, 5.0]])
CUT = np.array([[6.2, 0.0], [12.0, 0.0], [12.0, 3.0], [9.0, 3.0], [9.0, 5.0], [6.2, 5.0]])
DOOR = np.array([[6.0, 2.0], [6.2, 2.0], [6.2, 3.0], [6.0, 3.0]])
PLAN = (LEFT, CUT, DOOR)
IS_DOOR = np.array([False, False, True])
BOX = np.array(
    [[3.0, 2.5, 3.0, 2.5, 0.0], [9.1, 2.5, 2.9, 2.5, 0.0], [6.1, 2.5, 0.5, 0.1, np.pi / 2]]
)
STAY = (1.0, 0.0, 0.0, 0.0)


def told(similarity, outlines=PLAN, unseen=(0.0, 0.0, 0.0)):
    """Return what the plan explains of ``outlines``, by name."""
    rows = np.array([similarity])
    points = seen(outlines, IS_DOOR, BOX, np.array(unseen))
    found = explained(rows, painted(PLAN, IS_DOOR), points)
    assert walls_apart(rows, painted(PLAN, IS_DOOR), points) == pytest.approx(found[:, 0])
    return dict(zip(EXPLAINED, found[0].tolist(), strict=True))


def test_a_plan_explains_itself():
    own = told(STAY)

    assert own['walls_apart'] < 0.25
    assert own['walls_met'] > 0.98
    assert own['floor_outside'] < 0.08
    assert own['rooms_mixed'] < 0.05


@pytest.mark.parametrize('yaw', [0.4, np.pi / 2, 3.0])
def test_what_is_explained_does_not_depend_on_the_frame(yaw):
    a, b = 0.8 * np.cos(yaw), 0.8 * np.sin(yaw)
    back = np.array([[a, b], [-b, a]]) / 0.64  # of the points that this similarity took away
    away = tuple((ring - [2.0, -1.0]) @ back.T for ring in PLAN)
    middle = np.array([ring.mean(axis=0) for ring in away])
    box = np.column_stack([middle, BOX[:, 2:4] / 0.8, BOX[:, 4] - yaw])
    points = seen(away, IS_DOOR, box, np.zeros(3))
    found = explained(np.array([(a, b, 2.0, -1.0)]), painted(PLAN, IS_DOOR), points)[0]
    assert found == pytest.approx(list(told(STAY).values()), abs=0.05, rel=0.2)


def test_a_shift_is_told_by_walls_and_by_floors():
    own, off = told(STAY), told((1.0, 0.0, 3.0, 0.0))

    assert off['walls_apart'] > own['walls_apart'] + 0.5
    assert off['total_walls_apart'] > own['total_walls_apart'] + 10.0
    assert off['walls_met'] < 0.75
    assert off['floor_outside'] > 0.2
    assert off['rooms_mixed'] > 0.3


def test_a_drawing_far_larger_than_its_doors_does_not_fill_memory():
    huge = (LEFT * 1e4, CUT * 1e4, DOOR * 1e4)

    assert painted(huge, IS_DOOR).depth.size < 3_000_000
    assert len(seen(huge, IS_DOOR, BOX * 1e4, np.zeros(3)).floor) < 2_000
