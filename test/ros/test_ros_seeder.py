# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A seeder beside a particle filter that behaves as AMCL does, over DDS.

The test drives through the planted building and is the clock, our localizer and the filter.
"""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import drive, recorded
import pytest
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from fpnet_core.geometry import SE2, angle_between
from fpnet_core.pose import map_evidence
from fpnet_core.types import Status
from fpnet_lab.baselines.amcl import Amcl
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF
from msg_adapters.diagnostics import WARN, LocalizerReport, report_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.poses import pose_to_msg, uncertain_pose_from_msg, uncertain_pose_to_msg
from msg_adapters.stamps import stamp_to_msg
from msg_adapters.transforms import transform_to_msg

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = [pytest.mark.ros, pytest.mark.slow]

START_NS, STEP_NS = 1_700_000_000_000_000_000, 200_000_000
PATIENCE_S = 120.0  # for busy machines
SIGMAS = 0.1, 0.1, 0.03  # of our localizer
KIDNAPS = (30, 45, 38, 52, 33, 47, 41, 36, 50, 43)  # steps of the drive that are skipped


class Robot:
    """The planted drive to and fro, with perfect odometry, and our localizer's outputs."""

    def __init__(self, bench, parameters=None) -> None:
        self.bench, node = bench, bench.node
        self._rng = np.random.default_rng(4)
        self._clock = node.create_publisher(Clock, '/clock', 10)
        self._statuses = node.create_publisher(DiagnosticStatus, 'localizer/status', STATUS)
        self._poses = node.create_publisher(
            PoseWithCovarianceStamped, 'floorplan_pose_with_covariance', STATUS
        )
        self.seeds = bench.collect(PoseWithCovarianceStamped, 'initialpose', STREAM)
        self.diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
        self.index = self._offset = 0
        self.status = Status.SEARCHING
        self._T_odom_building = self._drawn(0).inv()
        self._T_map_odom = SE2.identity()
        self.true: dict[int, SE2] = {}  # pose on the plan by stamp
        self.child = bench.start('seeder', {'use_sim_time': True, **(parameters or {})})
        publishers = self._clock, self._statuses, self._poses
        heard = lambda: all(p.get_subscription_count() for p in publishers)  # noqa: E731
        assert bench.wait_for(heard, PATIENCE_S), self.child.log_tail()

    @property
    def now_ns(self) -> int:
        return START_NS + self.index * STEP_NS

    @property
    def place(self) -> int:
        """Index into the drive."""
        last = len(drive()) - 1
        return last - abs(last - (self.index + self._offset) % (2 * last))

    def _drawn(self, place: int) -> SE2:
        x, y, yaw = drive()[place]
        A_plan_building = A_BUILDING_PLAN.inv()
        return SE2.from_xy_yaw(*A_plan_building.apply((x, y)), A_plan_building.apply_yaw(yaw))

    @property
    def truth(self) -> SE2:
        return self._drawn(self.place)

    @property
    def T_odom_base(self) -> SE2:
        return self._T_odom_building @ self.truth

    def carry_off(self, steps: int) -> float:
        """Set the robot down elsewhere, unnoticed by the odometry; return how far away [m]."""
        before, T_odom_base = self.truth, self.T_odom_base
        self._offset += steps
        self._T_odom_building = T_odom_base @ self.truth.inv()
        return float(np.linalg.norm(before.translation - self.truth.translation))

    def localize(self) -> None:
        self.status, self._T_map_odom = Status.LOCALIZED, self.truth @ self.T_odom_base.inv()

    def step(self) -> None:
        """One scan further, with our localizer's status and, while it has one, its pose."""
        self.index += 1
        self.true[self.now_ns] = self.truth
        self._clock.publish(Clock(clock=stamp_to_msg(self.now_ns)))
        if self.status is Status.LOCALIZED:
            at = self._T_map_odom @ self.T_odom_base
            dx, dy, dyaw = self._rng.normal(0.0, SIGMAS)
            said = SE2.from_xy_yaw(at.x + dx, at.y + dy, at.yaw + dyaw)
            cov = np.diag(np.square(SIGMAS))
            self._poses.publish(uncertain_pose_to_msg(said, cov, self.now_ns, 'map'))
        report = LocalizerReport(self.status, 0.99, self.now_ns, reason='planted')
        self._statuses.publish(report_to_msg(report, 'localizer'))

    def steps(self, count: int, condition=lambda: False) -> bool:
        """Go some steps, at a pace that the nodes keep up with, until the condition holds."""
        for _ in range(count):
            self.step()
            self.bench.wait_for(condition, 0.03)
            if condition():
                return True
        return False

    def logs(self, text: str) -> bool:
        return self.bench.wait_for(lambda: text in self.child.log.read_text(), PATIENCE_S)

    def is_near(self, pose: SE2, stamp_ns: int) -> bool:
        truth = self.true[stamp_ns]
        off_m = np.linalg.norm(pose.translation - truth.translation)
        return off_m < 1.0 and angle_between(pose.yaw, truth.yaw) < np.deg2rad(10.0)


class AmclRobot(Robot):
    """The same with AMCL's topics: ``initialpose`` in, a latched ``amcl_pose`` after motion."""

    def __init__(self, bench) -> None:
        node = bench.node
        self.filter = Amcl(map_evidence(plan_grid()), np.random.default_rng(7))
        self._published = node.create_publisher(PoseWithCovarianceStamped, 'amcl_pose', LATCHED)
        node.create_subscription(
            PoseWithCovarianceStamped, 'initialpose', self._on_initial_pose, STREAM
        )
        self.knows = False  # the last pose is right
        super().__init__(bench)

    def _on_initial_pose(self, msg) -> None:
        given = uncertain_pose_from_msg(msg)
        if given.pose.frame_id == 'map':
            pose = given.pose
            self.filter.take_initial_pose(pose.T_frame_body, given.cov, pose.stamp_ns)

    def step(self) -> None:
        super().step()
        points, T_odom_base = recorded()[self.place][0], self.T_odom_base
        mean = self.filter.add_scan(points, T_odom_base.as_matrix4(), self.now_ns)
        if mean is not None:
            self.knows = self.is_near(mean.T_plan_base, self.now_ns)
            msg = uncertain_pose_to_msg(mean.T_plan_base, mean.cov, self.now_ns, 'map')
            self._published.publish(msg)


def test_a_robot_carried_off_ten_times_is_told_its_place_ten_times(bench):
    robot = AmclRobot(bench)
    robot.steps(20)
    assert robot.seeds == [], 'ours is still searching'
    robot.localize()
    assert robot.steps(60, lambda: robot.knows), robot.child.log_tail()
    robot.steps(60)
    assert len(robot.seeds) == robot.filter.starts == 1, robot.child.log_tail()
    for number, skipped in enumerate(KIDNAPS, start=2):
        assert robot.carry_off(skipped) > 3.0
        robot.steps(4)  # nobody has noticed
        robot.status = Status.LOST
        robot.steps(10)
        assert not robot.knows
        assert len(robot.seeds) == number - 1, 'ours is lost'
        robot.localize()
        told = lambda: robot.filter.starts == number and robot.knows  # noqa: B023, E731
        assert robot.steps(80, told), robot.child.log_tail()
        robot.steps(10)
    assert len(robot.seeds) == robot.filter.starts == 1 + len(KIDNAPS)
    for msg in robot.seeds:
        seed = uncertain_pose_from_msg(msg)
        assert robot.is_near(seed.pose.T_frame_body, seed.pose.stamp_ns)
        np.testing.assert_allclose(seed.cov, np.diag(np.square(SIGMAS)), atol=1e-12)
    log = robot.child.log.read_text()
    assert log.count('published the pose') == len(robot.seeds), 'one line for each'
    assert 'Traceback' not in log


def _amcl(node):
    publisher = node.create_publisher(PoseWithCovarianceStamped, 'amcl_pose', LATCHED)
    cov = 0.01 * np.eye(3)
    return publisher, lambda pose, ns: publisher.publish(
        uncertain_pose_to_msg(pose, cov, ns, 'map')
    )


def _odometry(node):
    publisher = node.create_publisher(Odometry, 'amcl_pose', STREAM)
    return publisher, lambda pose, ns: publisher.publish(
        odometry_to_msg(pose.as_matrix4(), ns, 'map', 'base_link')
    )


def _pose(node):
    publisher = node.create_publisher(PoseStamped, 'amcl_pose', STREAM)
    return publisher, lambda pose, ns: publisher.publish(pose_to_msg(pose, ns, '/map'))


def _tf(node):
    publisher = node.create_publisher(tf2_msgs.TFMessage, '/tf', TF)

    def publish(pose, stamp_ns):
        T_map_odom = pose @ SE2.from_xy_yaw(1.0, 2.0, 0.5)
        T_odom_base = SE2.from_xy_yaw(1.0, 2.0, 0.5).inv()
        chain = ('map', 'odom', T_map_odom), ('odom', 'base_link', T_odom_base)
        for parent, child, T in chain:
            transform = transform_to_msg(T.as_matrix4(), stamp_ns, parent, child)
            publisher.publish(tf2_msgs.TFMessage(transforms=[transform]))

    return publisher, publish


SOURCES = {'pose_with_covariance': _amcl, 'odometry': _odometry, 'pose': _pose, 'tf': _tf}


@pytest.mark.parametrize('source', SOURCES)
def test_it_says_where_another_localizer_is(bench, source):
    """The robot's own localizer publishes from the start: it is watched, and told on request."""
    publisher, publish = SOURCES[source](bench.node)
    robot = Robot(bench, {'other_source': source, 'reseed': False})
    assert bench.wait_for(publisher.get_subscription_count, PATIENCE_S)
    apart = SE2.from_xy_yaw(4.0, 3.0, 0.0)

    def steps(count, off, condition=lambda: False):
        for _ in range(count):
            publish(
                SE2.from_xy_yaw(robot.truth.x + off.x, robot.truth.y + off.y, robot.truth.yaw),
                robot.now_ns,
            )
            if robot.steps(1, condition):
                return True
        return False

    steps(10, SE2.identity())
    refused = bench.call(Trigger, 'seeder/seed')
    assert not refused.success
    assert refused.message == 'our localizer is searching'
    robot.localize()
    agrees = lambda: 'the other localizer agrees' in robot.child.log.read_text()  # noqa: E731
    assert steps(100, SE2.identity(), agrees), robot.child.log_tail()
    line = 'the other localizer is elsewhere, off by '
    says = lambda: line in robot.child.log.read_text()  # noqa: E731
    assert steps(100, apart, says), robot.child.log_tail()
    steps(20, apart)
    assert robot.child.log.read_text().count(line) == 1
    levels = lambda: [  # noqa: E731
        status.level
        for msg in robot.diagnostics
        for status in msg.status
        if status.name == '/seeder: seeder' and line in status.message
    ]
    assert bench.wait_for(levels, PATIENCE_S)
    assert set(levels()) == {WARN}
    assert robot.seeds == []
    robot.step()
    assert bench.call(Trigger, 'seeder/seed').success
    assert bench.wait_for(lambda: robot.seeds, PATIENCE_S)
