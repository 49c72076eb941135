# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node that gives another localizer its pose, and says when that one is elsewhere."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
import re
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
import numpy as np
from rclpy.clock import Clock, ClockType
from std_srvs.srv import Trigger

from fpnet_core.errors import ConfigError, FpnetError, OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.geometry.frame_tree import FrameTree, plain_frame
from fpnet_core.geometry.pose_track import PoseTrack
from fpnet_core.io.topic_names import TF_STATIC_TOPIC, TF_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_ros.health import DIAGNOSTICS_PERIOD_S
from fpnet_ros.logs import NodeLog
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.runtime import (
    NO_TF,
    ODOMETRY_QUEUE,
    STATUS,
    STREAM,
    TF,
    TF_STATIC,
    TFMessage,
    run_node,
    sensor_data,
)
from fpnet_ros.seeding import Advice, SeedingState, Situation, advise, is_restart, refused
from fpnet_ros.settings import SeederParameters
from msg_adapters.diagnostics import (
    OK,
    WARN,
    diagnostics_to_msg,
    named_status_to_msg,
    report_from_msg,
)
from msg_adapters.poses import (
    StampedPose,
    UncertainPose,
    pose_from_msg,
    uncertain_pose_from_msg,
)
from msg_adapters.transforms import transforms_from_msg

_LISTENERS = re.compile(
    r'_|rosbag2'
)  # given: nodes of ros2cli and recorders, which do not localize
_MEMORY_NS = 10 * NS_PER_S  # chosen: our poses wait so long for the other localizer's
_KINDS: dict[str, type] = {
    'pose_with_covariance': PoseWithCovarianceStamped,
    'pose': PoseStamped,
    'odometry': Odometry,
}


class SeederNode(OwnValues):
    """
    Publishes our localizer's pose on ``initialpose`` whenever another localizer needs it.

    Every pose on ``initialpose`` scatters AMCL's particles, so it is repeated only while the other
    localizer is elsewhere or unsure. :mod:`fpnet_ros.seeding` decides.
    """

    def __init__(self) -> None:
        super().__init__('seeder')
        self._settings = ParameterTree(self, SeederParameters).value
        self._log = NodeLog(self.get_logger(), self.context.ok)
        self._state, self._advice = SeedingState(), Advice(False, '', 'starting')
        self._status: Status | None = None
        self._msg: PoseWithCovarianceStamped | None = None
        self._ours: UncertainPose | None = None
        self._others: deque[UncertainPose] = deque(maxlen=ODOMETRY_QUEUE)
        self._stamps_ns: deque[int] = deque(maxlen=ODOMETRY_QUEUE)  # of ours, for TF
        self._tree = FrameTree()
        self._heard: set[bytes] = set()
        self._was_heard = False
        self._forget()
        self._seeds = self.add_publisher(PoseWithCovarianceStamped, 'initialpose', STREAM)
        self._diagnostics = self.add_publisher(DiagnosticArray, '/diagnostics', STREAM)
        self.add_subscription(DiagnosticStatus, 'localizer/status', self._on_status, STATUS)
        self.add_subscription(
            PoseWithCovarianceStamped, 'floorplan_pose_with_covariance', self._on_ours, STREAM
        )
        self._watch(self._settings.other_source)
        self.create_service(Trigger, '~/seed', self._on_request)
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # simulated time may stand still
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._on_timer, clock=steady)

    def _watch(self, source: str) -> None:
        """Subscribe to the pose of the other localizer."""
        if source != 'tf':
            # Best effort and volatile, which match every publisher; old poses would mislead.
            qos = sensor_data(ODOMETRY_QUEUE)
            self.add_subscription(_KINDS[source], 'amcl_pose', self._on_other, qos)
            return
        if TFMessage is None:
            raise ConfigError(NO_TF)
        self.create_subscription(TFMessage, TF_TOPIC, self._on_tf, TF)
        self.create_subscription(TFMessage, TF_STATIC_TOPIC, self._on_tf_static, TF_STATIC)

    # ---- our localizer

    def _on_status(self, msg: DiagnosticStatus) -> None:
        try:
            self._status = report_from_msg(msg).status
        except ValueError as error:
            self._log.report(ConfigError(f'localizer/status: {error}; remap it to our localizer'))
            return
        if self._status is not Status.LOCALIZED:
            self._forget()
        self._step()

    def _on_ours(self, msg: PoseWithCovarianceStamped) -> None:
        try:
            ours = self._in_map(uncertain_pose_from_msg(msg), 'floorplan_pose_with_covariance')
        except FpnetError as error:
            self._log.report(error)
            return
        stamp_ns = ours.pose.stamp_ns
        if self._ours is not None and stamp_ns < self._ours.pose.stamp_ns:  # a recording repeats
            self._forget()
            self._state = self._state.has_restarted().has_heard()
        self._msg, self._ours = msg, ours
        self._track.add(stamp_ns, ours.pose.T_frame_body.as_matrix4())
        self._stamps_ns.append(stamp_ns)
        if self._settings.other_source == 'tf':
            self._look_up()
        self._step()

    def _forget(self) -> None:
        """Forget our poses: the place is no longer accepted."""
        self._msg = self._ours = None
        self._track = PoseTrack(horizon_ns=_MEMORY_NS)
        self._stamps_ns.clear()
        self._others.clear()

    # ---- the other localizer

    def _on_other(self, msg: Any) -> None:
        try:
            if isinstance(msg, PoseStamped):
                other = UncertainPose(pose_from_msg(msg), np.zeros((3, 3)))
            else:
                other = uncertain_pose_from_msg(msg)
            self._hear(self._in_map(other, 'amcl_pose'))
        except FpnetError as error:
            self._log.report(error)

    def _on_tf(self, msg: Any) -> None:
        frame, base = self._settings.map_frame, self._settings.base_frame
        for t in transforms_from_msg(msg, self._log.report):
            self._tree.add(t.parent, t.child, t.T_parent_child, t.stamp_ns)
            if self._state.is_new and self._tree.lookup(frame, base, t.stamp_ns) is not None:
                self._state = self._state.has_heard()

    def _on_tf_static(self, msg: Any) -> None:
        for t in transforms_from_msg(msg, self._log.report):
            self._tree.add_fixed(t.parent, t.child, t.T_parent_child)

    def _look_up(self) -> None:
        """Hear the pose in TF at the newest stamp of ours at which it is known."""
        frame, base = self._settings.map_frame, self._settings.base_frame
        for stamp_ns in reversed(self._stamps_ns):
            T_map_base = self._tree.lookup(frame, base, stamp_ns)
            if T_map_base is not None:
                pose = StampedPose(stamp_ns, frame, SE2.from_matrix4(T_map_base))
                self._hear(UncertainPose(pose, np.zeros((3, 3))))
                while self._stamps_ns and self._stamps_ns[0] <= stamp_ns:
                    self._stamps_ns.popleft()
                return

    def _hear(self, other: UncertainPose) -> None:
        self._state = self._state.has_heard()
        self._others.append(other)

    def _in_map(self, given: UncertainPose, topic: str) -> UncertainPose:
        """Return a pose with a covariance that is one; raise OdometryError in another frame."""
        frame = self._settings.map_frame
        if plain_frame(given.pose.frame_id) != frame:
            raise OdometryError(
                f'{topic}: its frame is {given.pose.frame_id!r}, expected {frame!r}; both '
                'localizers must use the same map'
            )
        # Unknown covariances are zeros, or have negative variances.
        values, axes = np.linalg.eigh(given.cov)
        return UncertainPose(given.pose, (axes * np.maximum(values, 0.0)) @ axes.T)

    # ---- decisions

    def _on_request(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        """Publish a seed on request; refuse it with the reason."""
        response.message = refused(self._situation(), self._settings)
        if not response.message and self._msg is not None and self._ours is not None:
            self._state = self._state.has_seeded(self._ours)
            self._seeds.publish(self._msg)
            response.success, response.message = True, 'published the pose on initialpose'
        return response

    def _on_timer(self) -> None:
        found = self.get_subscriptions_info_by_topic(self._seeds.topic_name)
        heard = {
            bytes(each.endpoint_gid) for each in found if not _LISTENERS.match(each.node_name)
        }
        if is_restart(self._heard, heard, self._state.is_new):
            self._state = self._state.has_restarted()
        # Discovery is mutual: a new subscriber discovers this publisher a moment later.
        self._was_heard = bool(heard & self._heard)
        self._heard = heard
        self._step()
        advice, state = self._advice, self._state
        values = {
            'agreement': state.agreement.value,
            'seeds': str(state.seeds),
            'apart_m': f'{state.apart[0]:.2f}',
            'apart_rad': f'{state.apart[1]:.3f}',
        }
        name = f'{self.get_fully_qualified_name()}: seeder'
        status = named_status_to_msg(WARN if advice.is_trouble else OK, name, advice.said, values)
        now_ns = self.get_clock().now().nanoseconds
        self._diagnostics.publish(diagnostics_to_msg([status], now_ns))

    def _situation(self, pair: tuple[UncertainPose, UncertainPose] | None = None) -> Situation:
        now_ns = self.get_clock().now().nanoseconds
        return Situation(now_ns, self._status, self._ours, pair, self._was_heard)

    def _step(self) -> None:
        """Compare the poses that have ours at the same time; publish and log what follows."""
        for pair in [*self._pairs(), None]:
            self._state, advice = advise(self._state, self._situation(pair), self._settings)
            if advice.seed:
                self._seeds.publish(self._msg)
            self._log.change('advice', advice.kind, advice.said, advice.is_trouble)
            self._advice = advice

    def _pairs(self) -> list[tuple[UncertainPose, UncertainPose]]:
        """Take the other localizer's poses that are not newer than ours, each with ours."""
        pairs: list[tuple[UncertainPose, UncertainPose]] = []
        ours = self._ours
        while ours and self._others and self._others[0].pose.stamp_ns <= ours.pose.stamp_ns:
            other = self._others.popleft()
            T_map_base = self._track.at(other.pose.stamp_ns)
            if T_map_base is not None:
                there = SE2.from_matrix4(T_map_base)
                at = StampedPose(other.pose.stamp_ns, other.pose.frame_id, there)
                pairs.append((UncertainPose(at, ours.cov), other))
        return pairs


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_node(SeederNode, arguments)
