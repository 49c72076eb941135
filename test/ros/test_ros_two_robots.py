# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Two localizers side by side, on robots that are wired differently.

``alpha`` shares ``/tf`` with everyone and prefixes its frames; its odometry is in TF. ``beta`` has
TF in its namespace, as Nav2 runs several robots; its odometry comes from wheels, on a topic and
not at the clouds' times. Both mount the lidar askew on ``base_link``.
"""

import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import drive, recorded
import pytest
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from stopwatch import Stopwatch

from fpnet_core.geometry import SE2, angle_between
from fpnet_core.types import GridMap, Status
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF, TF_STATIC
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.poses import pose_from_msg
from msg_adapters.transforms import transform_from_msg, transform_to_msg

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = [pytest.mark.ros, pytest.mark.slow]

START_NS = 1_700_000_000_000_000_000
STEP_NS = 200_000_000
AROUND_NS = 20_000_000  # beta's wheels report this long before and after a cloud
T_BASE_LIDAR = SE2.from_xy_yaw(0.3, -0.1, np.deg2rad(40.0))
PATIENCE_S = 300.0


class Robot:
    """One robot's drivers and odometry, played by the test, and its localizer."""

    def __init__(self, bench, name, frames, tf, parameters, remappings, T_frame_plan) -> None:
        self.bench, self.name, self._frames, self._T_frame_plan = bench, name, frames, T_frame_plan
        node = bench.node
        self._clouds = node.create_publisher(PointCloud2, f'/{name}/points', STREAM)
        self._floorplans = node.create_publisher(OccupancyGrid, f'/{name}/floorplan', LATCHED)
        self._static = node.create_publisher(tf2_msgs.TFMessage, f'{tf}_static', TF_STATIC)
        self.tfs = bench.collect(tf2_msgs.TFMessage, tf, TF)
        self.statuses = bench.collect(DiagnosticStatus, f'/{name}/localizer/status', STATUS)
        self.poses = bench.collect(PoseStamped, f'/{name}/floorplan_pose', STREAM)
        reliable = f'qos_overrides./{name}/points.subscription.reliability'
        self.child = bench.start_as(
            name,
            'localizer',
            {
                'base_frame': frames['base'],
                'max_pending_scans': 50,
                'localizer.update_period_s': 0.4,
                reliable: 'reliable',
                **parameters,
            },
            {'__ns': f'/{name}', 'kiss/frame': 'points', **remappings},
        )
        mounted = transform_to_msg(
            T_BASE_LIDAR.as_matrix4(0.5), 0, frames['base'], frames['lidar']
        )
        self._static.publish(tf2_msgs.TFMessage(transforms=[mounted]))
        grid = plan_grid()
        moved = GridMap(grid.cells, grid.resolution, T_frame_plan @ grid.T_frame_grid)
        self._floorplans.publish(grid_to_msg(moved, START_NS, frames['floorplan']))

    def is_ready(self) -> bool:
        return (
            'received the floorplan' in self.child.log.read_text()
            and self._clouds.get_subscription_count() > 0
        )

    def send(self, position: int, stamp_ns: int) -> None:
        points, T_odom_lidar, _ = recorded()[position]
        T_odom_base = T_odom_lidar @ np.linalg.inv(T_BASE_LIDAR.as_matrix4(0.5))
        self._clouds.publish(cloud_to_msg(points, stamp_ns, self._frames['lidar']))
        self.send_odometry(T_odom_base, stamp_ns)

    def truth(self, position: int) -> SE2:
        """Pose of the base on this robot's drawing."""
        x, y, yaw = drive()[position]
        T_plan_building = A_BUILDING_PLAN.inv()
        lidar = SE2.from_xy_yaw(*T_plan_building.apply((x, y)), T_plan_building.apply_yaw(yaw))
        return self._T_frame_plan @ lidar @ T_BASE_LIDAR.inv()

    @property
    def status(self) -> Status | None:
        return report_from_msg(self.statuses[-1]).status if self.statuses else None

    def broadcasts(self) -> set[tuple[str, str]]:
        """Edges that were published on this robot's TF."""
        transforms = [transform_from_msg(t) for msg in self.tfs for t in msg.transforms]
        return {(t.parent, t.child) for t in transforms}


class Alpha(Robot):
    """Odometry in TF, frames prefixed."""

    def __init__(self, bench) -> None:
        self._tf = bench.node.create_publisher(tf2_msgs.TFMessage, '/tf', TF)
        frames = {name: f'alpha/{name}' for name in ('base', 'lidar', 'floorplan')}
        parameters = {
            'odometry_source': 'tf',
            'odom_frame': 'alpha/odom',
            'map_frame': 'alpha/map',
        }
        super().__init__(bench, 'alpha', frames, '/tf', parameters, {}, SE2.from_xy_yaw(0, 0, 0))

    def send_odometry(self, T_odom_base, stamp_ns) -> None:
        transform = transform_to_msg(T_odom_base, stamp_ns, 'alpha/odom', 'alpha/base')
        self._tf.publish(tf2_msgs.TFMessage(transforms=[transform]))


class Beta(Robot):
    """Wheels on a topic, TF in the namespace."""

    def __init__(self, bench) -> None:
        self._wheels = bench.node.create_publisher(Odometry, '/beta/wheels', STREAM)
        frames = {'base': 'base_link', 'lidar': 'lidar', 'floorplan': 'drawing'}
        remappings = {'kiss/odometry': 'wheels', '/tf': 'tf', '/tf_static': 'tf_static'}
        parameters = {'qos_overrides./beta/wheels.subscription.reliability': 'reliable'}
        moved = SE2.from_xy_yaw(60.0, -25.0, 1.0)
        super().__init__(bench, 'beta', frames, '/beta/tf', parameters, remappings, moved)

    def send_odometry(self, T_odom_base, stamp_ns) -> None:
        for around_ns in (-AROUND_NS, AROUND_NS):
            self._wheels.publish(
                odometry_to_msg(T_odom_base, stamp_ns + around_ns, 'odom', 'base_link')
            )


class Fleet:
    """Both robots on the same clock, a quarter of the drive apart."""

    def __init__(self, bench) -> None:
        self.bench = bench
        self.robots = self.alpha, self.beta = Alpha(bench), Beta(bench)
        self.diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
        self.index = 0

    def position(self, robot: Robot, index: int) -> int:
        """To and fro, so that odometry never jumps."""
        last = len(drive()) - 1
        ahead = 0 if robot is self.alpha else last // 4
        return last - abs(last - (index + ahead) % (2 * last))

    def step_until(self, condition) -> bool:
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.index += 1
            for robot in self.robots:
                robot.send(self.position(robot, self.index), START_NS + self.index * STEP_NS)
            self.bench.wait_for(condition, 0.15)
        return True


@pytest.fixture(scope='module')
def fleet(shared_bench):
    fleet = Fleet(shared_bench)
    for robot in fleet.robots:
        assert shared_bench.wait_for(robot.is_ready, PATIENCE_S), robot.child.log_tail()
    return fleet


def test_both_find_themselves_on_their_own_drawing(fleet):
    found = lambda: all(  # noqa: E731
        robot.status is Status.LOCALIZED and len(robot.poses) > 2 for robot in fleet.robots
    )
    assert fleet.step_until(found), [
        (robot.name, robot.statuses[-1:], robot.child.log_tail()) for robot in fleet.robots
    ]
    for robot, frame_id in ((fleet.alpha, 'alpha/floorplan'), (fleet.beta, 'drawing')):
        pose = pose_from_msg(robot.poses[-1])
        assert pose.frame_id == frame_id
        truth = robot.truth(fleet.position(robot, (pose.stamp_ns - START_NS) // STEP_NS))
        assert np.linalg.norm(pose.T_frame_body.translation - truth.translation) < 0.5
        assert angle_between(pose.T_frame_body.yaw, truth.yaw) < np.deg2rad(4.0)


def test_each_publishes_its_own_transform_where_it_was_told_to(fleet):
    assert fleet.step_until(lambda: ('map', 'odom') in fleet.beta.broadcasts())
    assert fleet.alpha.broadcasts() == {
        ('alpha/odom', 'alpha/base'),
        ('alpha/map', 'alpha/odom'),
    }
    assert fleet.beta.broadcasts() == {('map', 'odom')}


def test_diagnostics_tell_them_apart(fleet):
    def names():
        return {status.name for msg in fleet.diagnostics for status in msg.status}

    both = {f'/{robot.name}/localizer: localization' for robot in fleet.robots}
    assert fleet.step_until(lambda: both <= names()), names()


def test_what_one_is_told_does_not_concern_the_other(fleet):
    seen = {robot.name: len(robot.statuses) for robot in fleet.robots}
    assert fleet.bench.call(Trigger, '/alpha/localizer/relocalize').success
    assert fleet.step_until(
        lambda: all(len(robot.statuses) > seen[robot.name] + 1 for robot in fleet.robots)
    )
    told = {
        robot.name: [report_from_msg(msg).status for msg in robot.statuses[seen[robot.name] :]]
        for robot in fleet.robots
    }
    assert any(status is not Status.LOCALIZED for status in told['alpha'])
    assert all(status is Status.LOCALIZED for status in told['beta'])


def test_transform_and_claim_end_with_the_scans_and_come_back(fleet):
    """Post-dated by half a second, a transform is fresh for as long after the last one."""
    assert fleet.step_until(lambda: fleet.beta.status is Status.LOCALIZED)
    robot, watch = fleet.beta, Stopwatch()
    starved = lambda: robot.status is Status.WAITING  # noqa: E731
    assert fleet.bench.wait_for(starved), robot.child.log_tail()
    assert watch.elapsed_s < 2.0
    robot.tfs.clear()
    assert not fleet.bench.wait_for(lambda: bool(robot.broadcasts()), 2.0)
    report = report_from_msg(robot.statuses[-1])
    assert 'no message on /beta/' in report.reason
    assert report.warning
    log = robot.child.log.read_text()
    assert log.count('no scan with a pose arrives any more') == 1
    found = lambda: robot.status is Status.LOCALIZED and bool(robot.broadcasts())  # noqa: E731
    assert fleet.step_until(found), robot.child.log_tail()
