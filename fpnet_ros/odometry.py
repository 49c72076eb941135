# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node for lidar odometry by KISS-ICP, with the topics and frames of KISS-ICP's own node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
import time
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.serialization import deserialize_message
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
from fpnet_ros.logs import NodeLog, one_line
from fpnet_ros.odometry_outputs import OdometryOutputs
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.robot_odometry import GyroInput, PoseInput
from fpnet_ros.runtime import STREAM, run_node
from fpnet_ros.settings import STALE_INPUT_S, OdometryParameters
from fpnet_ros.sweeps import SweepInput
from fpnet_ros.wiring import LARGE_CLOUDS
from fpnet_ros.work import DroppingWorker
from msg_adapters.clouds import cloud_from_msg
from msg_adapters.diagnostics import diagnostics_to_msg, health_to_msg
from msg_adapters.stamps import stamp_from_msg

_MOUNT_WAIT_S = 1.0  # chosen: a cloud waits this long for the mount of its sensor

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


class _Sweep(NamedTuple):
    """A sweep to register, and its frame."""

    scan: Scan
    frame_id: str
    heard_s: float  # by the monotonic clock


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
        logger = self.get_logger()
        self._log = NodeLog(logger, self.context.ok)
        self._settings = settings = ParameterTree(self, OdometryParameters).value
        config = ParameterTree(self, OdometryConfig, 'odometry.').value
        scans = ParameterTree(self, ScansConfig, 'scans.').value
        self._stamps = SweepStamps(scans.stamp, logger.warning)
        self._kiss = GuidedOdometry(config, self._on_clock_back, logger.warning)
        source = settings.robot_odometry
        odom_frame = settings.odom_frame if source == 'tf' else ''
        self._robot = PoseInput(self, source, 'robot_odometry', 'odom', self._log, odom_frame)
        self._tree = self._robot.where.tree
        self._gyro = GyroInput(self, self._tree, self._log) if settings.use_imu else None
        self._out = OdometryOutputs(self, settings)
        self._diagnostics = self.add_publisher(DiagnosticArray, '/diagnostics', STREAM)
        self._static_topic = self.resolve_topic_name(TF_STATIC_TOPIC)
        self._unmounted = 0
        self._refused = ''  # why the last sweep was refused; empty: it was not
        self._scans: DroppingWorker[Callable[[], _Sweep]] = DroppingWorker(
            self._try_to_register, settings.max_pending_scans, self._log.report, 'registration'
        )
        base = settings.base_frame
        hooks = (lambda: base), self._on_cloud, self._on_sweep
        self._sweeps = SweepInput(
            self, settings, 'pointcloud_topic', self._tree, *hooks, self._log
        )
        topics = self._sweeps.topics
        if len(topics) > 1 and not base:
            raise ConfigError(
                f'parameter base_frame is empty; set it to merge {len(topics)} scanners'
            )
        self._checkup = SweepCheckup(self.resolve_topic_name('pointcloud_topic'))
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # simulated time may stand still
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics, clock=steady)

    def destroy_node(self) -> None:
        """End the worker first."""
        self._scans.close()
        super().destroy_node()

    def _on_cloud(self, data: bytes) -> None:
        self._scans.put(partial(self._unpacked, data, time.monotonic()))

    def _unpacked(self, data: bytes, heard_s: float) -> _Sweep:
        msg = deserialize_message(data, PointCloud2)
        cloud = cloud_from_msg(msg)
        stamp_ns = self._stamps.pose_ns(cloud, stamp_from_msg(msg.header.stamp))
        scan = Scan(stamp_ns, cloud.points, cloud.time_s, viewpoints=cloud.viewpoints)
        return _Sweep(scan, plain_frame(msg.header.frame_id), heard_s)

    def _on_sweep(self, sweep: LaserSweep, base: str) -> None:
        scan = Scan(sweep.stamp_ns, sweep.points, sweep.time_s, viewpoints=sweep.viewpoints)
        self._scans.put(partial(_Sweep, scan, base, time.monotonic()))

    def _try_to_register(self, unpack: Callable[[], _Sweep]) -> None:
        try:
            self._refused = self._register(unpack())
        except FpnetError as error:
            self._refused = one_line(error)
            raise

    def _register(self, sweep: _Sweep) -> str:
        """Register a sweep and publish its pose; return why it was dropped, empty if not."""
        scan, sensor, tree = sweep.scan, sweep.frame_id, self._tree
        if not self._sweeps.is_laser:
            self._checkup.look(scan.points, scan.time_s)
        if why := self._mount_problem(sensor, sweep.heard_s + _MOUNT_WAIT_S):
            return why
        # A mounted sensor has a TF parent already: the pose is that of its root frame.
        moving = self._settings.base_frame or tree.body(sensor)
        T_base_sensor = tree.mount(moving, sensor)
        # As in KISS-ICP's node, odom is the pose of the base, not the sensor, at the first cloud.
        scan = replace(
            scan,
            T_odom_sensor=self._robot.awaited(sensor, scan.stamp_ns),
            T_base_sensor=T_base_sensor,
            R_gyro_sensor=self._gyro and self._gyro.orientation(sensor, scan.stamp_ns),
        )
        found = self._kiss.register_scan(scan)
        self._out.publish(found, scan.stamp_ns, sensor, moving, T_base_sensor)
        return ''

    def _mount_problem(self, sensor: str, deadline_s: float) -> str:
        """Wait for the mount of a sensor; return why the sweep must be dropped, empty if not."""
        tree, base = self._tree, self._settings.base_frame
        if not base:  # if no mount arrives in time, the pose is the sensor's
            if not self._out.moving and self.count_publishers(self._static_topic):
                self._robot.wait_until(lambda: tree.parent(sensor) is not None, deadline_s)
            return ''
        if self._robot.wait_until(lambda: tree.lookup(base, sensor, 0) is not None, deadline_s):
            self._log.succeed('find mounts')
            return ''
        self._unmounted += 1
        why = tree.reason(base, sensor, 0)
        self._log.fail('find mounts', OdometryError(f'{why}; the cloud was dropped'))
        return why

    def _on_clock_back(self, back_s: float) -> None:
        self._out.begin_anew()
        self.get_logger().warning(f'the clock went back by {back_s:.3f} s; starting anew')

    def _publish_diagnostics(self) -> None:
        sweeps, scans, robot = self._sweeps, self._scans, self._robot
        silences = {', '.join(sweeps.topics): sweeps.silence_s}
        if self._settings.robot_odometry != 'none':
            silences[robot.topic] = robot.silence_s
        if self._gyro is not None:
            silences[self.resolve_topic_name('imu')] = time.monotonic() - self._gyro.heard_s
        self._log.silences(silences, STALE_INPUT_S)
        unmounted = self._unmounted + sweeps.dropped
        counts = {
            _SLOW: scans.dropped,
            LOST: sweeps.lost,
            _UNMOUNTED: unmounted,
            _UNGUIDED: robot.missed,
        }
        news = self._log.losses(counts, _REMEDIES)
        warning = self._refused or ', '.join(news) or _CONSISTENCY.get(self._kiss.consistency, '')
        values = {
            'scans': float(scans.done - self._unmounted),
            'dropped_scans': float(scans.dropped + unmounted),
            'refused_scans': float(scans.refused + sweeps.refused),
            'lost_scans': float(sweeps.lost),
            'earlier_scans': float(sweeps.earlier),
            'register_ms': scans.work_ms,
        }
        name = self.get_fully_qualified_name()
        status = health_to_msg(f'{name}: registration', warning, values)
        wiring = findings_to_msg(name, self._checkup.findings or ())
        now_ns = self.get_clock().now().nanoseconds
        self._diagnostics.publish(diagnostics_to_msg([status, wiring], now_ns))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_node(OdometryNode, arguments)
