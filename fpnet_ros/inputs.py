# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localizer's scans, with sensor poses from an odometry topic, from TF, or from both."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2

from fpnet_core.config import ScanStamp
from fpnet_core.errors import CloudFormatError, OdometryError
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.geometry.pose_lookup import SensorPose
from fpnet_core.io.laser_sweeps import LaserSweep
from fpnet_core.io.message_types import ODOMETRY
from fpnet_core.io.pointcloud2 import CloudArrays
from fpnet_core.io.scans import Scan
from fpnet_core.io.sweep_stamps import SweepStamps, in_silence
from fpnet_core.io.topic_names import KISS_FRAME, KISS_ODOMETRY, is_registered
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.logs import NodeLog
from fpnet_ros.robot_odometry import OdometryRun, PoseInput
from fpnet_ros.settings import InputParameters
from fpnet_ros.sweeps import SweepInput
from msg_adapters.clouds import carries_times, cloud_from_msg
from msg_adapters.stamps import stamp_from_msg

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LocatedScan:
    """
    A scan with the pose of its sensor.

    ``unpack`` decodes the points, which is slow: call it in another thread.
    """

    unpack: Callable[[], CloudArrays]
    stamp_ns: int
    sensor_pose: SensorPose

    @property
    def T_odom_sensor(self) -> Array:
        """Pose of the frame of the points, (4, 4)."""
        return self.sensor_pose.T_odom_sensor

    @property
    def T_odom_base(self) -> Array:
        """Pose of the robot, (4, 4)."""
        return self.sensor_pose.T_odom_base


class _Waiting(NamedTuple):
    """A scan that waits for its pose; ``unpack`` takes the motion during the sweep (4, 4)."""

    frame_id: str
    first_ns: int
    unpack: Callable[[Array], CloudArrays]


class ScanInput:
    """
    Passes on every scan once its pose is known, in the executor's thread.

    Clouds without point times are decoded later, in another thread, because decoding is slow.
    Clouds with times are decoded here, because the times determine the stamp of the pose;
    ``scan_stamp`` is the instant of the sweep that a cloud's own stamp gives.

    ``on_scan`` gets each located scan, ``on_stamp`` the stamp of every received one.
    ``on_restart`` is called when a new process has begun to publish the odometry.

    ``past`` counts scans no newer than the last one while odometry goes on; ``waits_for`` is what
    the newest scan lacked on arrival, empty once a located scan was passed on.
    """

    def __init__(
        self,
        node: ManagedNode,
        parameters: InputParameters,
        on_scan: Callable[[LocatedScan], None],
        on_restart: Callable[[], None],
        log: NodeLog,
        scan_stamp: ScanStamp = 'auto',
        on_stamp: Callable[[int], None] = lambda _: None,
    ) -> None:
        self._limit, self._log = parameters.max_pending_scans, log
        self._on_scan, self._on_restart, self._on_stamp = on_scan, on_restart, on_stamp
        self._waiting: OrderedDict[int, _Waiting] = OrderedDict()
        self._unlocated = self._unreadable = self.past = 0
        self._passed_ns = 0  # stamp of the last scan that was passed on
        self.waits_for = ''
        # KISS-ICP's clouds are registered: no point times, and the stamp is that of the pose.
        is_silent = is_registered(node.resolve_topic_name(KISS_FRAME))
        say = in_silence if is_silent else node.get_logger().warning
        self._stamps = SweepStamps(scan_stamp, say)
        source, hooks = parameters.odometry_source, (self._pass_on, self._restart)
        frames = parameters.odom_frame, parameters.base_frame
        self._poses = PoseInput(
            node, source, 'odometry_source', KISS_ODOMETRY, log, *frames, *hooks
        )
        where = self._where = self._poses.where
        base = lambda: where.base_frame  # noqa: E731
        self._sweeps = SweepInput(
            node, parameters, KISS_FRAME, where.tree, base, self._on_cloud, self._on_sweep, log
        )
        self.topics = dict(self._sweeps.topics)
        """Message type of each topic of scans and poses, scans first."""
        if parameters.odometry_source == 'topic':
            self.topics[node.resolve_topic_name(KISS_ODOMETRY)] = ODOMETRY

    @property
    def ages_s(self) -> dict[str, float]:
        """Time since the last message of each input, or since the start [s]."""
        cloud_s, odometry_s = self._sweeps.silence_s, self._poses.silence_s
        return {'cloud_age_s': cloud_s, 'odometry_age_s': odometry_s}

    @property
    def silence_s(self) -> dict[str, float]:
        """Time since the last message of each input, or since the start [s], by its topics."""
        scans = ', '.join(self._sweeps.topics)
        return {scans: self._sweeps.silence_s, self._poses.topic: self._poses.silence_s}

    def odometry_run(self) -> OdometryRun:
        """Return the current run of the odometry; with TF it is unknown."""
        return self._poses.run()

    @property
    def unlocated(self) -> int:
        """Scans whose pose did not arrive in time."""
        return self._unlocated + self._sweeps.dropped

    @property
    def refused(self) -> int:
        """Scans whose messages are inconsistent, of those that are decoded here."""
        return self._unreadable + self._sweeps.refused

    @property
    def lost(self) -> int:
        """Scans that were sent but did not arrive."""
        return self._sweeps.lost

    @property
    def earlier(self) -> int:
        """Scans that were sent before the first received one."""
        return self._sweeps.earlier

    def _restart(self) -> None:
        self._waiting.clear()
        self._on_restart()

    def _on_cloud(self, data: bytes) -> None:
        msg = deserialize_message(data, PointCloud2)
        stamp_ns, frame_id = stamp_from_msg(msg.header.stamp), plain_frame(msg.header.frame_id)
        if not carries_times(msg):
            no_times = CloudArrays(np.zeros((0, 3), dtype=np.float32), None)
            stamp_ns = self._stamps.pose_ns(no_times, stamp_ns)
            self._wait(stamp_ns, _Waiting(frame_id, stamp_ns, lambda _: cloud_from_msg(msg)))
            return
        try:
            cloud = cloud_from_msg(msg)
        except CloudFormatError as error:
            self._unreadable += 1
            self._log.report(error)
            return
        stamp_ns = self._stamps.pose_ns(cloud, stamp_ns)
        scan = Scan(stamp_ns, cloud.points, cloud.time_s, viewpoints=cloud.viewpoints)
        self._wait(stamp_ns, _Waiting(frame_id, scan.first_ns, partial(_unmoved, scan)))

    def _on_sweep(self, sweep: LaserSweep, base: str) -> None:
        self._wait(sweep.stamp_ns, _Waiting(base, sweep.first_ns, partial(_unmoved, sweep)))

    def _wait(self, stamp_ns: int, scan: _Waiting) -> None:
        """Queue a scan until its pose is known; it replaces one with the same (or no) stamp."""
        self._on_stamp(stamp_ns)
        self.past += self._waiting.pop(stamp_ns, None) is not None
        self._waiting[stamp_ns] = scan
        self.waits_for = self._where.reason(scan.frame_id, stamp_ns)
        self._pass_on()

    def _pass_on(self) -> None:
        for stamp_ns in list(self._waiting):
            waiting = self._waiting[stamp_ns]
            scan = self._located(stamp_ns, waiting)
            if scan is None:
                continue
            del self._waiting[stamp_ns]
            self._log.succeed('locate scans')
            self.waits_for = ''
            if self._is_past(stamp_ns, waiting.frame_id):
                self.past += 1
            else:
                self._passed_ns = stamp_ns
                self._on_scan(scan)
        while len(self._waiting) > self._limit:
            stamp_ns, waiting = self._waiting.popitem(last=False)
            self._unlocated += 1
            why = self._where.reason(waiting.frame_id, stamp_ns)
            error = OdometryError(f'{why}; the scan was dropped')
            self._log.fail('locate scans', error, re.sub(r'\d+', '', why))

    def _is_past(self, stamp_ns: int, frame_id: str) -> bool:
        """
        Return whether a scan is no newer than the last one while odometry goes on.

        If odometry went back too, as in a looping recording, the pose of the last scan is no
        longer known.
        """
        passed_ns = self._passed_ns
        return stamp_ns <= passed_ns and self._where.pose(frame_id, passed_ns) is not None

    def _located(self, stamp_ns: int, waiting: _Waiting) -> LocatedScan | None:
        sensor_pose = self._where.sensor_pose(waiting.frame_id, stamp_ns)
        if sensor_pose is None:
            return None
        T_first_last = self._where.motion(waiting.frame_id, waiting.first_ns, stamp_ns)
        if T_first_last is None:
            return None
        return LocatedScan(partial(waiting.unpack, T_first_last), stamp_ns, sensor_pose)


def _unmoved(sweep: Scan | LaserSweep, T_first_last: Array) -> CloudArrays:
    """Return the points of a sweep, deskewed to its stamp."""
    still = sweep.without_motion(T_first_last)
    return CloudArrays(still.points, None, viewpoints=still.viewpoints)
