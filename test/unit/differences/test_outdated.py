# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The drawing is out of date here: where, how much, and not while nobody knows where here is."""

import numpy as np
from planted import plan_grid
import pytest

from fpnet_core.differences import Difference, DifferenceKind, Differences, outdated
from fpnet_core.differences.outdated import DrawingWatch, outdated_at
from fpnet_core.geometry import Affine2D
from fpnet_core.types import FREE, GridMap, LocalizerOutput, Status, Submap

HERE = np.array([5.0, 5.0])
FIGURES = np.zeros(1)


def wall(kind, length_m, at=HERE, confidence=0.9):
    half = np.array([0.5 * length_m, 0.0])
    return Difference(kind, np.stack([at - half, at + half]), length_m, confidence, FIGURES)


def found(*pieces):
    grid = plan_grid()
    none = np.zeros(grid.shape)
    return Differences(grid, pieces, none.astype(np.int32), none > 0)


def output(status=Status.LOCALIZED, walls_m=20.0, storey='', side=100):
    cell_m = 0.1
    grid = GridMap(np.full((side, side), FREE, np.int8), cell_m)
    along = np.arange(round(walls_m / cell_m)) * cell_m + 0.5 * cell_m
    seen = np.stack([along, np.full_like(along, 0.05)], axis=-1)
    submap = Submap(grid, grid.cells != FREE, HERE[None], recent_xy=seen)
    A = Affine2D.identity() if status is Status.LOCALIZED else None
    return LocalizerOutput(1, status, A, submap=submap, storey=storey)


def test_walls_that_are_new_and_gone_are_told_apart():
    said = outdated_at(
        found(wall(DifferenceKind.WALL, 4.0), wall(DifferenceKind.MISSING, 2.0)), HERE, 20.0
    )
    assert (said.new_m, said.missing_m) == (4.0, 2.0)
    assert said.share == pytest.approx(0.3)
    assert said.said == (
        'the drawing is out of date here: 4 m of observed wall not drawn, 2 m of drawn wall '
        'missing, 30 % of the walls within 10 m of (5.0, 5.0)'
    )
    assert said.as_json()['xy'] == [5.0, 5.0]


@pytest.mark.parametrize(
    'pieces',
    [
        (),
        (wall(DifferenceKind.WALL, 2.0),),  # a tenth
        (wall(DifferenceKind.WALL, 9.0, HERE + 30.0),),  # elsewhere
        (wall(DifferenceKind.WALL, 9.0, confidence=0.3),),
        (wall(DifferenceKind.FURNITURE, 9.0), wall(DifferenceKind.SHUT, 9.0)),
    ],
)
def test_little_elsewhere_and_what_is_no_wall_do_not_count(pieces):
    assert outdated_at(found(*pieces), HERE, 20.0) is None


def test_it_takes_less_to_stay_than_to_become():
    between = found(wall(DifferenceKind.WALL, 2.4))
    assert outdated_at(between, HERE, 20.0) is None
    assert outdated_at(between, HERE, 20.0, was_outdated=True) is not None


def test_a_watch_looks_now_and_then_and_forgets_with_the_claim(monkeypatch):
    looks = []
    differs = found(wall(DifferenceKind.WALL, 6.0))
    monkeypatch.setattr(outdated, 'differences_of', lambda *_: looks.append(1) or differs)
    watch, plan = DrawingWatch(), object()
    assert watch.follow(output(), plan) is differs
    assert watch.outdated.share == pytest.approx(0.3)
    assert [watch.follow(output(), plan) for _ in range(9)] == [None] * 9
    assert watch.follow(output(), plan) is None  # nothing new was seen
    for _ in range(10):
        watch.follow(output(side=150), plan)
    assert len(looks) == 2
    assert watch.outdated is not None
    watch.follow(output(Status.LOST), plan)
    assert watch.outdated is None
    watch.follow(output(storey='high'), plan)
    assert len(looks) == 3
