# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans with sensor poses from an odometry topic, from TF, or from both."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
import re
import time
from typing import Any, Literal, NamedTuple

from nav_msgs.msg import Odometry
import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2

from fpnet_core.config import ScanStamp
from fpnet_core.errors import CloudFormatError, ConfigError, FpnetError, OdometryError
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.geometry.pose_lookup import PoseLookup, SensorPose
from fpnet_core.io.laser_sweeps import LaserSweep
from fpnet_core.io.message_types import LASER_SCAN, ODOMETRY, POINT_CLOUD
from fpnet_core.io.pointcloud2 import CloudArrays
from fpnet_core.io.scans import Scan
from fpnet_core.io.sweep_stamps import SweepStamps, in_silence
from fpnet_core.io.topic_names import (
    KISS_FRAME,
    KISS_ODOMETRY,
    TF_STATIC_TOPIC,
    TF_TOPIC,
    is_registered,
)
from fpnet_ros.lasers import LaserInput, LaserParameters
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.odometry_run import OdometryRun
from fpnet_ros.optional_messages import NO_TF, TFMessage
from fpnet_ros.runtime import ODOMETRY_QUEUE, TF, TF_STATIC, Once, sensor_data
from fpnet_ros.work import Numbering
from msg_adapters.clouds import carries_times, cloud_from_msg
from msg_adapters.odometry import odometry_from_msg
from msg_adapters.stamps import stamp_from_msg
from msg_adapters.transforms import transforms_from_msg

Array = NDArray[np.float64]


class InputParameters(LaserParameters):
    """Sources of scans and their poses."""

    odometry_source: Literal['topic', 'tf'] = Field(
        'topic', description='Source of poses: the topic kiss/odometry, or odom_frame in TF.'
    )
    odom_frame: str = Field(
        '',
        description='Child of the published transform, if the robot has its own TF tree; empty: '
        'the frame of the odometry messages.',
    )
    base_frame: str = Field(
        '', description='Frame to localize; empty: the child frame of the odometry.'
    )
    max_pending_scans: int = Field(
        10, ge=1, le=1000, description='Number of scans that may wait; the oldest are dropped.'
    )


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
    Clouds with times are decoded here, because the times determine the stamp of the pose.

    Parameters
    ----------
    on_scan
        Called with each located scan.
    on_restart
        Called when a new process has begun to publish the odometry.
    report
        Called with the error of an unusable message.
    scan_stamp
        Instant of the sweep that the stamp of a cloud gives.
    on_stamp
        Called with the stamp of every received scan, located or not.

    ``past`` counts scans no newer than the last one while odometry goes on; ``waits_for`` is what
    the newest scan lacked on arrival, empty once a located scan was passed on.
    """

    def __init__(
        self,
        node: ManagedNode,
        parameters: InputParameters,
        on_scan: Callable[[LocatedScan], None],
        on_restart: Callable[[], None],
        report: Callable[[FpnetError], None],
        scan_stamp: ScanStamp = 'auto',
        on_stamp: Callable[[int], None] = lambda _: None,
    ) -> None:
        self._settings = parameters
        self._on_scan, self._on_restart, self._report = on_scan, on_restart, report
        self._on_stamp = on_stamp
        self._resolve = node.resolve_topic_name
        self._node = node
        self._from_tf = parameters.odometry_source == 'tf'
        self._where = PoseLookup(
            from_tf=self._from_tf,
            odom_frame=parameters.odom_frame,
            base_frame=parameters.base_frame,
        )
        self._waiting: OrderedDict[int, _Waiting] = OrderedDict()
        self._clouds, self._odometry = Numbering(), Numbering()
        self._heard_s = {'cloud': time.monotonic(), 'odometry': time.monotonic()}
        self._unlocated = self._unreadable = self.past = 0
        self._passed_ns = 0  # stamp of the last scan that was passed on
        self._drop_log = Once(report)
        self.waits_for = ''
        self._lasers: LaserInput | None = None
        self._listen_to_scans(node, scan_stamp)
        if not self._from_tf:
            poses = sensor_data(ODOMETRY_QUEUE)
            node.add_subscription(Odometry, KISS_ODOMETRY, self._on_odometry, poses)
        self._listen_to_tf(node)

    def _listen_to_scans(self, node: ManagedNode, scan_stamp: ScanStamp) -> None:
        clouds = sensor_data(self._settings.max_pending_scans)
        if topics := self._settings.topics:
            self._lasers = LaserInput(
                lambda kind, topic, take: node.add_subscription(kind, topic, take, clouds),
                topics,
                self._where.tree,
                lambda: self._where.base_frame,
                self._on_sweep,
                self._report,
                self._settings.max_pending_scans,
            )
            return
        # KISS-ICP's clouds are registered: no point times, and the stamp is that of the pose.
        is_silent = is_registered(self._resolve(KISS_FRAME))
        say = in_silence if is_silent else node.get_logger().warning
        self._stamps = SweepStamps(scan_stamp, say)
        node.add_subscription(PointCloud2, KISS_FRAME, self._on_cloud, clouds, raw=True)

    @property
    def ages_s(self) -> dict[str, float]:
        """Time since the last message of each input, or since the start [s]."""
        heard_s, now_s = dict(self._heard_s), time.monotonic()
        if self._lasers is not None:
            heard_s['cloud'] = self._lasers.heard_s
        return {f'{name}_age_s': now_s - at_s for name, at_s in heard_s.items()}

    @property
    def silence_s(self) -> dict[str, float]:
        """Time since the last message of each input, or since the start [s], by its topics."""
        lasers = map(self._resolve, self._settings.topics)
        scans = ', '.join(lasers) or self._resolve(KISS_FRAME)
        poses = self._resolve(TF_TOPIC if self._from_tf else KISS_ODOMETRY)
        if self._from_tf:  # /tf has other publishers too
            poses += f' from {self._settings.odom_frame!r}'
        return {scans: self.ages_s['cloud_age_s'], poses: self.ages_s['odometry_age_s']}

    def topics(self) -> dict[str, str]:
        """Return the message type of each topic of scans and poses, scans first."""
        settings = self._settings
        found = dict.fromkeys(map(self._resolve, settings.topics), LASER_SCAN)
        found = found or {self._resolve(KISS_FRAME): POINT_CLOUD}
        if settings.odometry_source == 'topic':
            found[self._resolve(KISS_ODOMETRY)] = ODOMETRY
        return found

    def odometry_run(self) -> OdometryRun:
        """Return the current run of the odometry; with TF it is unknown."""
        if self._settings.odometry_source == 'tf':
            return OdometryRun()
        found = self._node.get_publishers_info_by_topic(KISS_ODOMETRY)
        publishers = frozenset(bytes(each.endpoint_gid).hex() for each in found)
        return OdometryRun(publishers, self._odometry.newest)

    @property
    def unlocated(self) -> int:
        """Scans whose pose did not arrive in time."""
        return self._unlocated + (0 if self._lasers is None else self._lasers.dropped)

    @property
    def refused(self) -> int:
        """Scans whose messages are inconsistent, of those that are decoded here."""
        return self._unreadable + (0 if self._lasers is None else self._lasers.refused)

    @property
    def lost(self) -> int:
        """Scans that were sent but did not arrive."""
        return self._clouds.lost + (0 if self._lasers is None else self._lasers.lost)

    @property
    def earlier(self) -> int:
        """Scans that were sent before the first received one."""
        return self._clouds.earlier + (0 if self._lasers is None else self._lasers.earlier)

    def _listen_to_tf(self, node: ManagedNode) -> None:
        parameters = self._settings
        if self._from_tf and not parameters.odom_frame:
            raise ConfigError(
                'parameter odom_frame is empty; with odometry_source tf set it to the odometry '
                'frame in TF, for example odom'
            )
        if TFMessage is None:
            if self._where.needs_tf:
                raise ConfigError(NO_TF)
            return
        node.add_subscription(TFMessage, TF_STATIC_TOPIC, self._on_tf_static, TF_STATIC)
        if self._where.needs_tf:
            node.add_subscription(TFMessage, TF_TOPIC, self._on_tf, TF)

    def _on_cloud(self, data: bytes, info: dict[str, Any]) -> None:
        self._heard_s['cloud'] = time.monotonic()
        self._clouds.follow(info)
        msg = deserialize_message(data, PointCloud2)
        stamp_ns, frame_id = stamp_from_msg(msg.header.stamp), plain_frame(msg.header.frame_id)
        if carries_times(msg):
            self._take_timed(msg, frame_id, stamp_ns)
        else:
            no_times = CloudArrays(np.zeros((0, 3), dtype=np.float32), None)
            stamp_ns = self._stamps.pose_ns(no_times, stamp_ns)
            self._wait(stamp_ns, _Waiting(frame_id, stamp_ns, lambda _: cloud_from_msg(msg)))
        self._pass_on()

    def _take_timed(self, msg: PointCloud2, frame_id: str, stamp_ns: int) -> None:
        try:
            cloud = cloud_from_msg(msg)
        except CloudFormatError as error:
            self._unreadable += 1
            self._report(error)
            return
        stamp_ns = self._stamps.pose_ns(cloud, stamp_ns)
        scan = Scan(stamp_ns, cloud.points, cloud.time_s, viewpoints=cloud.viewpoints)
        self._wait(stamp_ns, _Waiting(frame_id, scan.first_ns, partial(_unmoved, scan)))

    def _on_sweep(self, sweep: LaserSweep, base: str) -> None:
        self._wait(sweep.stamp_ns, _Waiting(base, sweep.first_ns, partial(_unmoved, sweep)))
        self._pass_on()

    def _on_odometry(self, msg: Odometry, info: dict[str, Any]) -> None:
        self._heard_s['odometry'] = time.monotonic()
        if self._odometry.follow(info):
            self._where.clear()
            self._waiting.clear()
            self._on_restart()
        try:
            odometry = odometry_from_msg(msg)
        except OdometryError as error:
            self._report(error)
            return
        self._where.add_pose(
            odometry.parent, odometry.child, odometry.T_parent_child, odometry.stamp_ns
        )
        self._pass_on()

    def _on_tf_static(self, msg: Any) -> None:
        for transform in transforms_from_msg(msg, self._report):
            self._where.tree.add_fixed(transform.parent, transform.child, transform.T_parent_child)
        self._pass_on()

    def _on_tf(self, msg: Any) -> None:
        for t in transforms_from_msg(msg, self._report):
            self._where.tree.add(t.parent, t.child, t.T_parent_child, t.stamp_ns)
            if self._from_tf and t.parent == self._settings.odom_frame:
                self._heard_s['odometry'] = time.monotonic()
        self._pass_on()

    def _wait(self, stamp_ns: int, scan: _Waiting) -> None:
        """Queue a scan until its pose is known; it replaces one with the same (or no) stamp."""
        self._on_stamp(stamp_ns)
        self.past += self._waiting.pop(stamp_ns, None) is not None
        self._waiting[stamp_ns] = scan
        self.waits_for = self._where.reason(scan.frame_id, stamp_ns)

    def _pass_on(self) -> None:
        for stamp_ns in list(self._waiting):
            waiting = self._waiting[stamp_ns]
            scan = self._located(stamp_ns, waiting)
            if scan is None:
                continue
            del self._waiting[stamp_ns]
            self._drop_log.clear()
            self.waits_for = ''
            if self._is_past(stamp_ns, waiting.frame_id):
                self.past += 1
            else:
                self._passed_ns = stamp_ns
                self._on_scan(scan)
        while len(self._waiting) > self._settings.max_pending_scans:
            stamp_ns, waiting = self._waiting.popitem(last=False)
            self._unlocated += 1
            why = self._where.reason(waiting.frame_id, stamp_ns)
            error = OdometryError(f'{why}; the scan was dropped')
            self._drop_log.tell(error, re.sub(r'\d+', '', why))

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
