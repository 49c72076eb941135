# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A floorplan and what is known of its scale come on two topics, in whatever order."""

from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid
from planted import plan_grid
import pytest

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.types import GridMap
from fpnet_ros.floorplans import FloorplanInput
from msg_adapters.grids import grid_to_msg
from msg_adapters.scales import GridScale, scale_to_msg

pytestmark = pytest.mark.ros

SCALE = GridScale(7, 0.8, 1.2, 'about 0.05 m per pixel')


class _Node:
    """Hands messages to who has subscribed."""

    def __init__(self):
        self.callbacks = {}

    def add_subscription(self, kind, topic, callback, qos):
        self.callbacks[kind] = callback

    def send(self, msg):
        self.callbacks[type(msg)](msg)


class _Localizer:
    def __init__(self):
        self.told = []

    def set_plan(self, grid, scale=None, policy=None):
        self.told.append((scale and (scale.low, scale.high), policy))


@pytest.fixture
def heard():
    node, plans, errors = _Node(), [], []
    FloorplanInput(node, plans.append, errors.append)
    return node, plans, errors


def test_a_slash_before_the_frame_is_not_part_of_its_name(heard):
    """The scale of a map in '/map' is as trusted as of one in 'map'."""
    node, plans, _ = heard
    node.send(grid_to_msg(plan_grid(), 7, '/map'))
    assert plans[-1].frame_id == 'map'


def test_a_grid_that_is_refused_says_so_and_what_stays(heard):
    node, plans, errors = heard
    node.send(grid_to_msg(plan_grid(), 7, '/'))
    assert str(errors[-1]).startswith('the floorplan was refused: its header has no frame_id')
    node.send(grid_to_msg(plan_grid(), 7, 'map'))
    broken = grid_to_msg(plan_grid(), 8, 'map')
    broken.info.resolution = 0.0
    node.send(broken)
    assert 'the floorplan was refused: grid resolution must be' in str(errors[-1])
    assert str(errors[-1]).endswith('; the previous floorplan stays')
    assert len(plans) == 1


@pytest.mark.parametrize('order', [(0, 1), (1, 0)])
def test_an_estimated_scale_ends_with_its_grid_whichever_comes_first(heard, order):
    node, plans, _ = heard
    messages = grid_to_msg(plan_grid(), 7, 'drawing'), scale_to_msg(SCALE)
    for index in order:
        node.send(messages[index])
    assert plans[-1].scale == SCALE
    assert plans[-1].frame_id == 'drawing'
    assert 'about 0.05' in plans[-1].said_of_scale
    localizer = _Localizer()
    plans[-1].give_to(localizer, 'approximate')
    plans[-1].give_to(localizer, 'trusted')
    assert localizer.told == [((0.8, 1.2), 'unknown'), (None, None)]


def test_a_grid_that_no_scale_goes_with_is_stated(heard):
    node, plans, _ = heard
    node.send(scale_to_msg(SCALE))
    node.send(grid_to_msg(plan_grid(), 8, 'map'))
    assert plans[-1].scale.is_stated
    assert plans[-1].said_of_scale == ''
    localizer = _Localizer()
    plans[-1].give_to(localizer, 'approximate')
    assert localizer.told == [(None, None)]


def test_a_stated_scale_that_comes_late_changes_nothing(heard):
    node, plans, _ = heard
    node.send(grid_to_msg(plan_grid(), 7, 'map'))
    node.send(scale_to_msg(GridScale(7, said='stated by plan.yaml')))
    assert len(plans) == 1


@pytest.mark.parametrize('scale', [None, SCALE], ids=['stated', 'estimated'])
def test_a_grid_that_is_published_again_and_again_is_taken_once(heard, scale):
    node, plans, _ = heard
    for stamp_ns in (7, 8, 9):
        node.send(grid_to_msg(plan_grid(), stamp_ns, 'map'))
        if scale is not None:
            node.send(scale_to_msg(replace(scale, stamp_ns=stamp_ns)))
    assert len(plans) == (1 if scale is None else 2), 'the scale is heard after its grid'


def test_a_grid_that_differs_in_anything_is_another_one(heard):
    node, plans, _ = heard
    grid = plan_grid()
    cells = grid.cells.copy()
    cells[:2, :2] = 100
    moved = GridMap(
        grid.cells, grid.resolution, SE2.from_xy_yaw(1.0, 0.0, 0.0) @ grid.T_frame_grid
    )
    finer = GridMap(grid.cells, 0.9 * grid.resolution, grid.T_frame_grid)
    drawn = GridMap(cells, grid.resolution, grid.T_frame_grid)
    others = [(grid, 'other'), (moved, 'map'), (finer, 'map'), (drawn, 'map'), (grid, 'map')]
    for stamp_ns, (other, frame_id) in enumerate([(grid, 'map'), *others], 7):
        node.send(grid_to_msg(other, stamp_ns, frame_id))
    assert len(plans) == 1 + len(others)


def test_the_same_grid_with_another_scale_is_taken_again(heard):
    node, plans, _ = heard
    node.send(scale_to_msg(SCALE))
    node.send(grid_to_msg(plan_grid(), 7, 'map'))
    node.send(grid_to_msg(plan_grid(), 8, 'map'))
    assert len(plans) == 1
    assert plans[-1].scale == SCALE
    node.send(scale_to_msg(GridScale(8, said='stated meanwhile')))
    assert len(plans) == 2
    assert plans[-1].scale.is_stated


def test_bad_messages_are_told_and_the_floorplan_stays(heard):
    node, plans, errors = heard
    node.send(DiagnosticArray())
    node.send(OccupancyGrid())
    assert plans == []
    assert [isinstance(error, FpnetError) for error in errors] == [True, True]
