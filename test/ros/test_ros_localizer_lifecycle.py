# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localizer's own steps of the lifecycle: nothing waits for a tick, no defect is silent."""

import threading
import time

from nav_msgs.msg import OccupancyGrid
import numpy as np
from planted import plan_grid
import pytest
import rclpy

from fpnet_core.errors import ConfigError
from fpnet_core.localizer import Localizer
from fpnet_lab.nodes.processes import free_domain_id
from fpnet_ros import localizer as module
from fpnet_ros.floorplans import ServedPlan
from fpnet_ros.localizer import LocalizerNode
from fpnet_ros.runtime import LATCHED
from fpnet_ros.state_file import StateFile
from msg_adapters.scales import GridScale

pytestmark = [pytest.mark.ros, pytest.mark.slow]


@pytest.fixture
def node(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.setattr(module, 'warm_up', lambda _: None)
    given = ['autostart:=false', f'state_file:={tmp_path}/state.npz']
    arguments = [word for each in given for word in ('-p', each)]
    rclpy.init(args=['--ros-args', *arguments], domain_id=free_domain_id())
    node = LocalizerNode()
    yield node
    node.destroy_node()
    rclpy.shutdown()


def state(node) -> str:
    return node._state_machine.current_state[1]


def errors(capfd) -> list[str]:
    return [line for line in capfd.readouterr().err.splitlines() if '[ERROR]' in line]


def test_deactivating_does_not_wait_for_a_tick_whose_end_stays_unheard(node, monkeypatch):
    begun, may_end, published = threading.Event(), threading.Event(), []

    def slow_tick(self, now_ns):
        begun.set()
        may_end.wait(20.0)
        return self.output

    monkeypatch.setattr(Localizer, 'update', slow_tick)
    node.trigger_configure()
    node.trigger_activate()
    node._on_floorplan(ServedPlan(plan_grid(), 'drawing', GridScale(1)))
    node._start_update()
    assert begun.wait(20.0)
    monkeypatch.setattr(node._out, 'publish_pose', published.append)
    started_s = time.monotonic()
    node.trigger_deactivate()
    assert time.monotonic() - started_s < 0.5
    assert not may_end.is_set()
    assert state(node) == 'inactive'
    may_end.set()
    node.trigger_cleanup()
    assert published == []
    assert state(node) == 'unconfigured'


def test_a_floorplan_that_comes_before_activation_is_published_on_activation(node):
    received = []
    listener = rclpy.create_node('listener')
    topic = f'{node.get_name()}/floorplan_scaled'
    listener.create_subscription(OccupancyGrid, topic, received.append, LATCHED)
    node.trigger_configure()
    node._on_floorplan(ServedPlan(plan_grid(), 'drawing', GridScale(1)))
    end_s = time.monotonic() + 20.0
    while node._frame is None and time.monotonic() < end_s:
        time.sleep(0.05)
    rclpy.spin_once(listener, timeout_sec=0.5)
    assert received == []
    node.trigger_activate()
    end_s = time.monotonic() + 20.0
    while not received and time.monotonic() < end_s:
        rclpy.spin_once(listener, timeout_sec=0.2)
    listener.destroy_node()
    assert received[0].header.frame_id == 'map'


def test_a_defect_while_configuring_is_told_once_and_configuring_again_works(
    node, monkeypatch, capfd
):
    create = module.create_localizer

    def broken(config):
        raise ZeroDivisionError('planted')

    monkeypatch.setattr(module, 'create_localizer', broken)
    node.trigger_configure()
    assert state(node) == 'unconfigured'
    (line,) = errors(capfd)
    assert 'configure failed: internal error, please report it: ZeroDivisionError' in line
    monkeypatch.setattr(module, 'create_localizer', create)
    node.trigger_configure()
    assert state(node) == 'inactive'


PARTS = (
    'RunFolder',
    'LocalizerOutputs',
    'StoreyTopics',
    'ScanInput',
    'StateFile',
    'Checkup',
    'FloorplanInput',
    'InitialPoses',
    'offer_services',
    'Clock',
)


@pytest.mark.parametrize('error', [ConfigError, ZeroDivisionError])
def test_whatever_part_fails_is_told_once_and_leaves_nothing_behind(
    node, monkeypatch, capfd, error
):
    """What the parts are made of, and in which order, is not what giving them up rests on."""
    before = threading.active_count()
    for part in PARTS:

        def broken(*_, part=part, **__):
            raise error(f'planted in {part}')

        with monkeypatch.context() as planted:
            planted.setattr(module, part, broken)
            node.trigger_configure()
        (line,) = errors(capfd)
        assert f'planted in {part}' in line
        assert state(node) == 'unconfigured'
        assert threading.active_count() == before, part
    node.trigger_configure()
    assert state(node) == 'inactive'


def test_a_defect_while_saving_ends_every_thread_all_the_same(node, monkeypatch, capfd):
    before = threading.active_count()
    node.trigger_configure()
    node._newest = object()

    def broken(self):
        raise np.linalg.LinAlgError('planted')

    monkeypatch.setattr(StateFile, 'save', broken)
    node._updates.submit(lambda: None)
    node.trigger_cleanup()
    (line,) = errors(capfd)
    assert 'cleanup failed: internal error, please report it: LinAlgError: planted' in line
    assert state(node) == 'unconfigured'
    assert threading.active_count() == before
