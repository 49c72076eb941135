# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What happens on a robot, to real KISS-ICP and the localizer: each ends localized, nothing lost.

The test plays the lidar from a recording, cloud by cloud as odometry answers, and no faster than a
lidar would: ticks keep their own time. The graph of these nodes is also what layouts and
documentation are held to.
"""

import json
import os
from pathlib import Path
import re
import signal
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2
import yaml

from fpnet.accuracy import pose_errors
from fpnet_core.io.bags import BagReader
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Status
from fpnet_ros.runtime import STATUS, STREAM
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.poses import pose_from_msg
from msg_adapters.stamps import stamp_from_msg

pytestmark = [pytest.mark.ros, pytest.mark.slow]

ROOT = Path(__file__).parents[2]
NODES = ('localizer', 'odometry', 'floorplan_server')
PATIENCE_S = 300.0
SWEEP_S = 0.1
SETTLED_POSES = 15  # of each claim, compared with the truth


class Drive:
    """The recording's clouds, and what the nodes make of them."""

    def __init__(self, bench, excerpt) -> None:
        self.bench, self.excerpt = bench, excerpt
        with BagReader(excerpt.folder / 'bag') as bag:
            self._clouds = [data for *_, data in bag.raw_messages(['/points'])]
        self._publisher = bench.node.create_publisher(PointCloud2, 'points', STREAM)
        self.odometry_stamps = []
        bench.node.create_subscription(Odometry, 'kiss/odometry', self._on_odometry, STREAM)
        self.statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
        self.diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
        self.poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
        reliable = 'qos_overrides./kiss/{}.subscription.reliability'
        bench.start('floorplan_server', {'floorplan': str(excerpt.floorplan)})
        self.localizer = bench.start(
            'localizer',
            {
                'max_pending_scans': 60,
                'stale_input_s': 1.0,
                'localizer.update_period_s': 0.3,
                reliable.format('frame'): 'reliable',
                reliable.format('odometry'): 'reliable',
            },
        )
        self.odometry = self.start_odometry('odometry')
        self.index = -1

    def start_odometry(self, log_name: str):
        return self.bench.start_as(
            log_name,
            'odometry',
            {'qos_overrides./points.subscription.reliability': 'reliable'},
            {'pointcloud_topic': 'points'},
        )

    def is_ready(self) -> bool:
        return (
            'received the floorplan' in self.localizer.log.read_text()
            and self._publisher.get_subscription_count() > 0
            and self.bench.node.count_subscribers('kiss/frame') > 0
        )

    def step(self) -> None:
        """One cloud further; on to the next when odometry has answered, or will not."""
        self.index += 1
        answered, due_s = len(self.odometry_stamps), time.monotonic() + SWEEP_S
        self._publisher.publish(self._clouds[self.index])
        self.bench.wait_for(lambda: len(self.odometry_stamps) > answered, 2.0)
        self.bench.wait_for(lambda: time.monotonic() >= due_s, SWEEP_S)

    def step_until(self, condition) -> bool:
        while self.index + 1 < len(self._clouds):
            if condition():
                return True
            self.step()
        return self.bench.wait_for(condition, PATIENCE_S)

    def localize(self) -> None:
        """Go on until there is a claim with poses; it must be right."""
        self.poses.clear()
        claimed = lambda: self.is_localized() and len(self.poses) >= SETTLED_POSES  # noqa: E731
        assert self.step_until(claimed), (self.index, self.localizer.log_tail())
        poses = [pose_from_msg(msg) for msg in self.poses]
        published = PlanarTrajectory(
            np.array([pose.stamp_ns for pose in poses]),
            np.array([pose.T_frame_body.translation for pose in poses]),
            np.array([pose.T_frame_body.yaw for pose in poses]),
        )
        A_building_plan = self.excerpt.A_plan_building.inv()
        position_m, yaw_rad = pose_errors(published.mapped(A_building_plan), self.excerpt.truth)
        assert np.median(position_m) < 0.5
        assert np.median(yaw_rad) < np.deg2rad(4.0)

    def is_localized(self) -> bool:
        return bool(self.statuses) and (
            report_from_msg(self.statuses[-1]).status is Status.LOCALIZED
        )

    def hears_odometry(self) -> bool:
        """A killed process stays in the graph for a while; only a living one reports."""
        names = {status.name for msg in self.diagnostics for status in msg.status}
        return '/odometry: registration' in names

    def warnings(self) -> list[str]:
        """What the localizer's diagnostics warned of, oldest first."""
        statuses = [s for msg in self.diagnostics for s in msg.status if 'localizer' in s.name]
        return [status.message for status in statuses if status.level != DiagnosticStatus.OK]

    def _on_odometry(self, msg: Odometry) -> None:
        self.odometry_stamps.append(stamp_from_msg(msg.header.stamp))


@pytest.fixture(scope='module')
def drive(shared_bench, excerpt):
    drive = Drive(shared_bench, excerpt)
    assert shared_bench.wait_for(drive.is_ready, PATIENCE_S), drive.localizer.log_tail()
    drive.localize()
    return drive


def test_odometry_that_is_killed_and_restarted_costs_the_submap_only(drive):
    drive.diagnostics.clear()
    os.kill(drive.odometry.process.pid, signal.SIGKILL)
    drive.odometry.process.wait(timeout=30)
    silent = lambda: any('no odometry for' in text for text in drive.warnings())  # noqa: E731
    assert drive.bench.wait_for(silent, 60.0), drive.warnings()
    drive.diagnostics.clear()
    drive.odometry = drive.start_odometry('odometry_again')
    assert drive.bench.wait_for(drive.hears_odometry, PATIENCE_S), drive.odometry.log_tail()
    noticed = lambda: 'another process publishes' in drive.localizer.log.read_text()  # noqa: E731
    # The localizer may find the new publisher later than this process does: go on until then.
    assert drive.step_until(noticed), drive.localizer.log_tail()
    drive.localize()


def test_a_recording_that_loops_starts_odometry_and_localizer_anew(drive):
    drive.index = -1
    went_back = lambda child: 'the clock went back' in child.log.read_text()  # noqa: E731
    assert drive.step_until(lambda: went_back(drive.odometry)), drive.odometry.log_tail()
    assert drive.step_until(lambda: went_back(drive.localizer)), drive.localizer.log_tail()
    drive.localize()
    for child in (drive.localizer, drive.odometry):
        assert child.process.poll() is None
        assert 'Traceback' not in child.log.read_text()


@pytest.fixture(scope='module')
def graph(drive):
    """Types of all topics by direction, and the services, that these nodes have."""
    node = drive.bench.node
    found = {'publisher': {}, 'subscriber': {}, 'service': {}}
    for name in NODES:
        for kind, entries in found.items():
            listing = getattr(node, f'get_{kind}_names_and_types_by_node')(name, '/')
            entries.update({topic: types[0] for topic, types in listing})
    return found


def _own(names) -> set[str]:
    """Without what every ROS node has; an action by its own name."""
    common = re.compile(
        r'/(rosout|parameter_events|clock)$|/(describe|get|list|set)_parameter|/get_type_desc'
        r'|/(change_state|get_state|get_available_\w+|get_transition_graph|transition_event)$'
    )
    own = {name for name in names if not common.search(name)}
    return {name.partition('/_action/')[0] for name in own}


DISPLAYS = {
    'Map': 'nav_msgs/msg/OccupancyGrid',
    'PointCloud2': 'sensor_msgs/msg/PointCloud2',
    'MarkerArray': 'visualization_msgs/msg/MarkerArray',
    'PoseWithCovariance': 'geometry_msgs/msg/PoseWithCovarianceStamped',
    'Pose': 'geometry_msgs/msg/PoseStamped',
    'Path': 'nav_msgs/msg/Path',
}


def _displays(displays):
    for display in displays:
        if display['Class'] == 'rviz_common/Group':
            yield from _displays(display['Displays'])
        elif 'Topic' in display:
            yield display


def test_rviz_shows_what_is_published_by_its_type(graph):
    config = yaml.safe_load((ROOT / 'config' / 'fpnet.rviz').read_text())
    manager = config['Visualization Manager']
    shown = list(_displays(manager['Displays']))
    assert len(shown) >= 8
    for display in shown:
        kind = display['Class'].removeprefix('rviz_default_plugins/')
        assert graph['publisher'][display['Topic']['Value']] == DISPLAYS[kind], display['Name']
    for tool in manager['Tools']:
        if 'Topic' in tool:
            kind = 'geometry_msgs/msg/PoseWithCovarianceStamped'
            assert graph['subscriber'][tool['Topic']['Value']] == kind
    drawn = {'OccupancyGrid', 'MarkerArray', 'PoseStamped', 'PoseWithCovarianceStamped', 'Path'}
    drawable = {
        topic for topic, kind in graph['publisher'].items() if kind.rsplit('/')[-1] in drawn
    }
    assert drawable <= {display['Topic']['Value'] for display in shown}


def test_foxglove_shows_what_is_published(graph):
    layout = json.loads((ROOT / 'config' / 'foxglove.json').read_text())
    panels = layout['configById']

    def leaves(tree):
        if isinstance(tree, str):
            return {tree}
        assert tree['direction'] in ('row', 'column')
        return leaves(tree['first']) | leaves(tree['second'])

    assert leaves(layout['layout']) == set(panels)
    published = set(graph['publisher'])
    for name, panel in panels.items():
        topics = set(panel.get('topics', ()))
        topics |= {panel[key] for key in ('topicToRender', 'topicPath') if key in panel}
        assert topics <= published, name
        if 'publish' in panel:
            assert panel['publish']['poseEstimateTopic'] in graph['subscriber']
        if 'serviceName' in panel:
            assert panel['serviceName'] in graph['service']


def test_every_topic_and_service_is_documented(graph):
    page = (ROOT / 'docs' / 'ros.md').read_text()
    for name in _own({*graph['publisher'], *graph['subscriber'], *graph['service']}):
        node, _, leaf = name[1:].rpartition('/')
        spellings = {name, name[1:], f'~/{leaf}'} if node in NODES else {name, name[1:]}
        assert any(f'`{spelling}`' in page for spelling in spellings), name
