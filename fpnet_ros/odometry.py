# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node for lidar odometry by KISS-ICP, with the topics and frames of KISS-ICP's own node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.serialization import deserialize_message
from rclpy.utilities import get_rmw_implementation_identifier
from sensor_msgs.msg import PointCloud2

from fpnet_core.config import OdometryConfig, ScansConfig
from fpnet_core.errors import ConfigError, FpnetError, OdometryError
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.io.laser_sweeps import LaserSweep
from fpnet_core.io.scans import Scan
from fpnet_core.io.sweep_stamps import SweepStamps
from fpnet_core.io.topic_names import TF_STATIC_TOPIC
from fpnet_core.odometry import Consistency, GuidedOdometry
from fpnet_ros.checkup import SweepCheckup, findings_to_msg
from fpnet_ros.health import DIAGNOSTICS_PERIOD_S, LOST
from fpnet_ros.imu import GyroInput
from fpnet_ros.large_clouds import LARGE_CLOUDS, said_of_transport
from fpnet_ros.lasers import LaserInput
from fpnet_ros.odometry_outputs import OdometryOutputs, OdometryParameters
from fpnet_ros.optional_messages import TFMessage
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.robot_odometry import RobotOdometry
from fpnet_ros.runtime import (
    STALE_INPUT_S,
    STREAM,
    TF_STATIC,
    LossLog,
    Once,
    SilenceLog,
    error_reporter,
    one_line,
    run_node,
    sensor_data,
)
from fpnet_ros.work import DroppingWorker, Numbering
from msg_adapters.clouds import cloud_from_msg
from msg_adapters.diagnostics import diagnostics_to_msg, health_to_msg
from msg_adapters.stamps import stamp_from_msg
from msg_adapters.transforms import transforms_from_msg

# Chosen, not measured:
_MOUNT_WAIT_S = 1.0  # a cloud waits this long for the mount of its sensor

_SLOW = 'clouds are dropped: they arrive faster than they can be registered'
_UNMOUNTED = 'clouds are dropped: the mount of their sensor is unknown, see the log'
_UNGUIDED = "KISS-ICP went on alone: the robot's odometry did not arrive in time"
_REMEDIES = {
    _UNGUIDED: 'stamp it with the clock of the clouds, and publish it no later than the clouds',
    _SLOW: 'use a larger odometry.voxel_size or smaller clouds; for a slow robot every second '
    'cloud suffices',
    LOST: LARGE_CLOUDS,
}

_CONSISTENCY = {
    Consistency.ROBOT_BROKEN: "the robot's odometry does not fit the scans",
    Consistency.KISS_BROKEN: 'KISS-ICP lost track and was restarted',
    Consistency.UNCLEAR: "KISS-ICP and the robot's odometry disagree",
}


@dataclass(frozen=True, eq=False)
class _Sweep:
    """A sweep to register, and its frame."""

    scan: Scan
    frame_id: str
    heard_s: float  # by the monotonic clock


def _sweep_of_cloud(data: bytes, stamps: SweepStamps, heard_s: float) -> _Sweep:
    msg = deserialize_message(data, PointCloud2)
    cloud = cloud_from_msg(msg)
    stamp_ns = stamps.pose_ns(cloud, stamp_from_msg(msg.header.stamp))
    scan = Scan(stamp_ns, cloud.points, cloud.time_s, viewpoints=cloud.viewpoints)
    return _Sweep(scan, plain_frame(msg.header.frame_id), heard_s)


class OdometryNode(OwnValues):
    """
    Registers every cloud on ``pointcloud_topic``, in a thread of its own.

    Publishes ``kiss/odometry`` and the deskewed cloud, ``kiss/frame``. Both have the stamp of the
    pose, the end of the sweep. With ``base_frame`` the pose is that frame's, by the sensor's mount
    in ``/tf_static``. With ``robot_odometry`` the robot's own odometry is the initial guess and is
    checked.

    With ``scan_topics`` it registers LaserScans of one or more planar scanners instead:
    ``kiss/frame`` is then in the base frame, stamped with the last return.
    """

    def __init__(self) -> None:
        super().__init__('odometry')
        self._report = error_reporter(self)
        self._settings = ParameterTree(self, OdometryParameters).value
        config = ParameterTree(self, OdometryConfig, 'odometry.').value
        scans = ParameterTree(self, ScansConfig, 'scans.').value
        logger = self.get_logger()
        self._stamps = SweepStamps(scans.stamp, logger.warning)
        self._kiss = GuidedOdometry(config, self._on_clock_back, logger.warning)
        self._robot = RobotOdometry(self.add_subscription, self._settings, self._report)
        self._gyro: GyroInput | None = None
        if self._settings.use_imu:
            tree = self._robot.where.tree
            self._gyro = GyroInput(self.add_subscription, tree, self._report)
        self._out = OdometryOutputs(
            self.add_publisher, self.add_subscription, self._settings, logger.warning
        )
        self._diagnostics = self.add_publisher(DiagnosticArray, '/diagnostics', STREAM)
        self._static_topic = self.resolve_topic_name(TF_STATIC_TOPIC)
        if TFMessage is not None:
            self.create_subscription(TFMessage, TF_STATIC_TOPIC, self._on_tf_static, TF_STATIC)
        self._clouds = Numbering()
        self._unmounted = 0
        self._losses = LossLog(logger.warning)
        self._mount_log = Once(self._report)
        self._refused = ''  # why the last sweep was refused; empty: it was not
        self._heard_s = time.monotonic()
        self._silence = SilenceLog(logger.info, logger.warning)
        self._scans: DroppingWorker[Callable[[], _Sweep]] = DroppingWorker(
            self._try_to_register, self._settings.max_pending_scans, self._report, 'registration'
        )
        self._lasers: LaserInput | None = None
        clouds = self.resolve_topic_name('pointcloud_topic')
        self._checkup = SweepCheckup(clouds)
        if self._settings.topics:
            self._listen_to_lasers(self._settings.topics)
        else:
            # Raw, because decoding is slow: the worker does it.
            self._subscribe(PointCloud2, 'pointcloud_topic', self._on_cloud, raw=True)
            if said := said_of_transport(get_rmw_implementation_identifier()):
                logger.info(said)
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # simulated time may stand still
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics, clock=steady)

    def destroy_node(self) -> None:
        """End the worker first."""
        self._scans.close()
        super().destroy_node()

    def _subscribe(
        self, kind: type, topic: str, callback: Callable[..., None], raw: bool = False
    ) -> None:
        clouds = sensor_data(self._settings.max_pending_scans)
        self.add_subscription(kind, topic, callback, clouds, raw)

    def _listen_to_lasers(self, topics: dict[str, type]) -> None:
        base = self._settings.base_frame
        if len(topics) > 1 and not base:
            raise ConfigError(
                f'parameter base_frame is empty; set it to merge {len(topics)} scanners'
            )
        self._lasers = LaserInput(
            self._subscribe,
            topics,
            self._robot.where.tree,
            lambda: base,
            self._on_sweep,
            self._report,
            self._settings.max_pending_scans,
        )

    def _on_tf_static(self, msg: Any) -> None:
        for transform in transforms_from_msg(msg, self._report):
            self._robot.add_fixed(transform.parent, transform.child, transform.T_parent_child)

    def _on_cloud(self, data: bytes, info: dict[str, Any]) -> None:
        self._clouds.follow(info)
        self._heard_s = time.monotonic()
        self._scans.put(partial(_sweep_of_cloud, data, self._stamps, self._heard_s))

    def _on_sweep(self, sweep: LaserSweep, base: str) -> None:
        heard_s = time.monotonic()
        scan = Scan(sweep.stamp_ns, sweep.points, sweep.time_s, viewpoints=sweep.viewpoints)
        self._scans.put(lambda: _Sweep(scan, base, heard_s))

    def _try_to_register(self, unpack: Callable[[], _Sweep]) -> None:
        try:
            self._refused = self._register(unpack())
        except FpnetError as error:
            self._refused = one_line(error)
            raise

    def _register(self, sweep: _Sweep) -> str:
        """Register a sweep and publish its pose; return why it was dropped, empty if not."""
        scan, sensor = sweep.scan, sweep.frame_id
        if self._lasers is None:
            self._checkup.look(scan.points, scan.time_s)
        if why := self._mount_problem(sensor, sweep.heard_s + _MOUNT_WAIT_S):
            return why
        # A mounted sensor has a TF parent already: the pose is that of its root frame.
        tree = self._robot.where.tree
        moving = self._settings.base_frame or tree.body(sensor)
        T_base_sensor = tree.mount(moving, sensor)
        guess = self._robot.pose(sensor, scan.stamp_ns)
        # As in KISS-ICP's node, odom is the pose of the base, not the sensor, at the first cloud.
        turned = None if self._gyro is None else self._gyro.orientation(sensor, scan.stamp_ns)
        scan = replace(
            scan, T_odom_sensor=guess, T_base_sensor=T_base_sensor, R_gyro_sensor=turned
        )
        found = self._kiss.register_scan(scan)
        self._out.publish(found, scan.stamp_ns, sensor, moving, T_base_sensor)
        return ''

    def _mount_problem(self, sensor: str, deadline_s: float) -> str:
        """Wait for the mount of a sensor; return why the sweep must be dropped, empty if not."""
        tree, base = self._robot.where.tree, self._settings.base_frame
        if not base:  # if no mount arrives in time, the pose is the sensor's
            if not self._out.moving and self.count_publishers(self._static_topic):
                self._robot.wait_until(lambda: tree.parent(sensor) is not None, deadline_s)
            return ''
        if self._robot.wait_until(lambda: tree.lookup(base, sensor, 0) is not None, deadline_s):
            self._mount_log.clear()
            return ''
        self._unmounted += 1
        why = tree.reason(base, sensor, 0)
        self._mount_log.tell(OdometryError(f'{why}; the cloud was dropped'))
        return why

    def _on_clock_back(self, back_s: float) -> None:
        self._out.begin_anew()
        self.get_logger().warning(f'the clock went back by {back_s:.3f} s; starting anew')

    def _publish_diagnostics(self) -> None:
        scans = ', '.join(self._settings.topics) or self.resolve_topic_name('pointcloud_topic')
        heard_s = self._heard_s if self._lasers is None else self._lasers.heard_s
        silences = {scans: time.monotonic() - heard_s}
        if self._robot.is_used:
            silences[self._robot.topic(self)] = self._robot.silence_s
        if self._gyro is not None:
            silences[self.resolve_topic_name('imu')] = time.monotonic() - self._gyro.heard_s
        self._silence.follow(silences, STALE_INPUT_S)
        lasers, unmounted = self._lasers, self._unmounted
        lost, earlier, refused = self._clouds.lost, self._clouds.earlier, self._scans.refused
        if lasers is not None:
            lost, earlier = lost + lasers.lost, earlier + lasers.earlier
            unmounted, refused = unmounted + lasers.dropped, refused + lasers.refused
        counts = {
            _SLOW: self._scans.dropped,
            LOST: lost,
            _UNMOUNTED: unmounted,
            _UNGUIDED: self._robot.missed,
        }
        news = self._losses.follow(counts, _REMEDIES)
        warning = self._refused or ', '.join(news) or _CONSISTENCY.get(self._kiss.consistency, '')
        values = {
            'scans': float(self._scans.done - self._unmounted),
            'dropped_scans': float(self._scans.dropped + unmounted),
            'refused_scans': float(refused),
            'lost_scans': float(lost),
            'earlier_scans': float(earlier),
            'register_ms': self._scans.work_ms,
        }
        name = f'{self.get_fully_qualified_name()}: registration'
        status = health_to_msg(name, warning, values)
        now_ns = self.get_clock().now().nanoseconds
        wiring = findings_to_msg(self.get_fully_qualified_name(), self._checkup.findings or ())
        self._diagnostics.publish(diagnostics_to_msg([status, wiring], now_ns))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_node(OdometryNode, arguments)
