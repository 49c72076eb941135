# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What speaks for a placement: planted maps, where the right answer is known."""

from dataclasses import replace
from functools import cache

import numpy as np
from planted import A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2, Placements
from fpnet_core.graphs import build_region_graph
from fpnet_core.localizer.prepared_maps import prepare_plan, prepared_plan
from fpnet_core.matches import MatchResult
from fpnet_core.pose import PreparedMap, map_evidence
from fpnet_core.scoring import FIGURES, gather_evidence
from fpnet_core.segmentation import segment_submap
from fpnet_core.types import OCCUPIED, UNKNOWN

RIGHT = A_PLAN_SUBMAP
SHIFTED = SE2.from_xy_yaw(2.6, 1.9, 0.0) @ A_PLAN_SUBMAP
TURNED = A_PLAN_SUBMAP @ SE2.from_xy_yaw(0.0, 0.0, np.pi / 2)
PLACED = Placements.of([RIGHT, SHIFTED, TURNED])


@cache
def plan():
    return prepare_plan(plan_grid(), FpnetConfig())


def side_of(grid):
    from fpnet_core.submaps import submap_from_grid

    cut = segment_submap(submap_from_grid(grid))
    return PreparedMap(cut, build_region_graph(cut, 'submap'), map_evidence(grid))


@cache
def sub():
    return side_of(submap_grid())


def no_match(plan_map, sub_map):
    shape = len(plan_map.graph), len(sub_map.graph)
    return MatchResult(np.zeros((0, 2)), np.zeros(0), np.zeros(shape, np.float32))


def evidence(plan_map, sub_map, placed):
    return gather_evidence(plan_map, sub_map, placed, no_match(plan_map, sub_map), 0.2)


@cache
def found():
    return evidence(plan(), sub(), PLACED)


@pytest.mark.parametrize(
    'name',
    ['support', 'straight_support', 'straight_aligned', 'bent_support', 'seen', 'rooms_pure',
     'rooms_alike', 'doors_met', 'score', 'bent_score', 'rival_net', 'rival_z', 'contrast_mean'],
)  # fmt: skip
def test_what_speaks_for_a_placement_speaks_for_the_right_one(name):
    right, *wrong = found().of(name)
    assert right > max(wrong) + 0.02


@pytest.mark.parametrize(
    'name', ['residual_75', 'unexplained_m', 'denied', 'denied_m', 'doors_missing']
)
def test_what_speaks_against_a_placement_speaks_against_wrong_ones(name):
    right, *wrong = found().of(name)
    assert right < min(wrong)


def test_the_right_placement_of_a_perfect_map_explains_nearly_all():
    values = {name: float(found().of(name)[0]) for name in FIGURES}
    assert values['support'] > 0.85
    assert values['seen'] > 0.9
    assert values['denied'] < 0.05
    assert values['rooms_pure'] > 0.9
    assert values['bend_m'] < 0.1
    assert values['log_scale'] == pytest.approx(
        0.5 * np.log(np.linalg.det(RIGHT.linear)), abs=1e-5
    )


def test_the_order_of_placements_changes_nothing():
    order = np.array([2, 0, 1])
    other = evidence(plan(), sub(), PLACED.take(order))
    np.testing.assert_allclose(other.figures, found().figures[order], atol=1e-5)
    np.testing.assert_allclose(other.context, found().context, atol=1e-6)


def test_laying_both_maps_elsewhere_changes_nothing():
    moved = SE2.from_xy_yaw(40.0, -25.0, 0.9)
    drawn, seen = plan(), sub()
    plan_there = prepared_plan(
        replace(
            drawn.segmentation,
            grid=_laid(drawn.segmentation.grid, moved),
            regions=tuple(_moved_region(r, moved) for r in drawn.segmentation.regions),
            portals=tuple(
                replace(p, ends=moved.apply(p.ends)) for p in drawn.segmentation.portals
            ),
        )
    )
    other = evidence(plan_there, seen, moved @ PLACED)
    np.testing.assert_allclose(other.figures, found().figures, atol=2e-3)


def _laid(grid, moved):
    return replace(grid, T_frame_grid=moved @ grid.T_frame_grid)


def _moved_region(region, moved):
    return replace(
        region, polygon=moved.apply(region.polygon), centroid=moved.apply(region.centroid)
    )


def test_a_drawing_that_is_locally_off_costs_less_once_it_may_bend():
    grid = plan_grid()
    # The right half of the drawing is drawn half a metre too far to the right.
    cells = np.full_like(grid.cells, UNKNOWN)
    middle, off = grid.shape[1] // 2, round(0.5 / grid.resolution)
    cells[:, :middle] = grid.cells[:, :middle]
    cells[:, middle + off :] = grid.cells[:, middle:-off]
    cells[:, middle : middle + off] = grid.cells[:, [middle]]
    off_plan = prepare_plan(replace(grid, cells=cells), FpnetConfig())
    there = evidence(off_plan, sub(), PLACED)
    assert there.of('bend_gain')[0] > 0.1
    assert there.of('bent_score')[0] > max(there.of('bent_score')[1:]) + 0.2
    assert 0.05 < there.of('bend_m')[0] < 0.6


def test_equal_halves_are_equal_where_they_disagree():
    twins = Placements.of([RIGHT, RIGHT, TURNED])
    same = evidence(plan(), sub(), twins)
    np.testing.assert_allclose(same.figures[0], same.figures[1], atol=1e-6)
    assert same.of('rival_net')[0] == 0.0
    assert same.of('rival_contested')[0] == 0.0


def test_nothing_placed_or_nothing_seen_gives_zeros():
    assert len(evidence(plan(), sub(), Placements.empty())) == 0
    grid = submap_grid()
    bare = side_of(replace(grid, cells=np.where(grid.cells == OCCUPIED, UNKNOWN, grid.cells)))
    nothing = evidence(plan(), bare, PLACED)
    assert nothing.figures.shape == (3, len(FIGURES))
    if not len(bare.evidence.walls):
        assert not nothing.figures.any()
