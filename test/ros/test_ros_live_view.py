# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet view --nodes`` beside a running localizer, over DDS: its page follows the node."""

from http.client import HTTPConnection
import json
import re
import subprocess
import sys
from threading import Thread
import time

from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import SCAN_NS, drive, recorded
import pytest
from sensor_msgs.msg import PointCloud2

from fpnet_ros.runtime import LATCHED, STREAM
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.odometry import odometry_to_msg

pytestmark = [pytest.mark.ros, pytest.mark.slow]

COMMAND = [sys.executable, '-c', 'from fpnet.cli import main; main()', 'view', '--nodes']
START_NS = 1_700_000_000_000_000_000
PATIENCE_S = 240.0  # for busy machines; a quiet one needs seconds


class Viewer:
    """The command in a process of its own, and a page that is open."""

    def __init__(self, *options: str) -> None:
        words = [*COMMAND, '--port', '0', '--end', *options]
        self.process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        self.lines: list[str] = []
        self.events: list[dict] = []
        Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in self.process.stderr:
            self.lines.append(line)
            if found := re.search(r'http://(127\.0\.0\.1:\d+)/', line):
                Thread(target=self._follow, args=(found[1],), daemon=True).start()

    def _follow(self, host: str) -> None:
        connection = HTTPConnection(host, timeout=PATIENCE_S)
        connection.request('GET', '/events')
        response = connection.getresponse()
        while line := response.readline():
            if line.startswith(b'data: '):
                self.events.append(json.loads(line.removeprefix(b'data: ')))

    @property
    def updates(self) -> list[dict]:
        return [event['moment'] for event in list(self.events) if event['kind'] == 'update']

    def has(self, status: str) -> bool:
        return any(update['status'] == status for update in self.updates)


def test_a_page_follows_a_running_localizer_to_its_end(bench):
    reliable = 'qos_overrides./kiss/{}.subscription.reliability'
    node = bench.start(
        'localizer',
        {
            'localizer.update_period_s': 0.3,
            'max_pending_scans': 100,
            reliable.format('frame'): 'reliable',
            reliable.format('odometry'): 'reliable',
        },
    )
    floorplans = bench.node.create_publisher(OccupancyGrid, 'floorplan', LATCHED)
    frames = bench.node.create_publisher(PointCloud2, 'kiss/frame', STREAM)
    odometry = bench.node.create_publisher(Odometry, 'kiss/odometry', STREAM)
    floorplans.publish(grid_to_msg(plan_grid(), START_NS, 'drawing'))
    ready = (frames, odometry)
    heard = lambda: all(each.get_subscription_count() for each in ready)  # noqa: E731
    assert bench.wait_for(heard, PATIENCE_S), node.log_tail()

    viewer = Viewer()
    assert bench.wait_for(lambda: any('listening to /localizer' in x for x in viewer.lines), 60.0)
    for points, T, stamp_ns in recorded():
        if viewer.has('localized'):
            break
        frames.publish(cloud_to_msg(points, START_NS + stamp_ns, 'lidar'))
        odometry.publish(odometry_to_msg(T, START_NS + stamp_ns, 'odom', 'lidar'))
        bench.wait_for(lambda: False, SCAN_NS * 1e-9)
    assert bench.wait_for(lambda: viewer.has('localized'), PATIENCE_S), viewer.lines

    update = next(update for update in viewer.updates if update['status'] == 'localized')
    A, path = np.array(update['placements'][0]['A_plan_submap']), np.array(update['path'])[:, -1]
    here = A_BUILDING_PLAN.apply(A[:, :2] @ path + A[:, 2])
    assert np.linalg.norm(np.array(drive())[:, :2] - here, axis=1).min() < 1.0
    assert update['rooms'] > 0
    assert update['picture']
    assert update['heading'] is not None
    assert update['matches']
    assert 'wall' in update['reason']

    bench.group.stop()
    deadline = time.monotonic() + 60.0
    while viewer.process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.1)
    assert viewer.process.returncode == 0, viewer.lines
    assert viewer.events[-1]['kind'] == 'end'
    assert 'the localizer has stopped' in viewer.events[-1]['said']
    assert 'Traceback' not in node.log.read_text() + ''.join(viewer.lines)


def test_nobody_there_is_said_and_ctrl_c_ends_it(bench):
    viewer = Viewer()
    assert bench.wait_for(lambda: any('no localizer node found' in x for x in viewer.lines), 90)
    viewer.process.send_signal(2)
    assert viewer.process.wait(timeout=60) == 130
    assert 'Traceback' not in ''.join(viewer.lines)
