# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans and where their sensor was: from an odometry topic, from TF, or from both."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
import time
from typing import Any, Literal, NamedTuple

from nav_msgs.msg import Odometry
import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from fpnet_core.errors import ConfigError, FpnetError, OdometryError
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.io.laser_sweeps import LaserSweep
from fpnet_core.io.message_types import LASER_SCAN, ODOMETRY, POINT_CLOUD
from fpnet_core.io.pointcloud2 import CloudArrays
from fpnet_ros.lasers import LaserInput, LaserParameters
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.odometry_run import OdometryRun
from fpnet_ros.runtime import ODOMETRY_QUEUE, TF, TF_STATIC, sensor_data
from fpnet_ros.work import Numbering
from msg_adapters.clouds import cloud_from_msg
from msg_adapters.odometry import odometry_from_msg
from msg_adapters.stamps import stamp_from_msg
from msg_adapters.transforms import transform_from_msg

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # no wheel has it; see docs/install.md
    TFMessage = None

NO_TF = 'tf2_msgs is not installed; install ROS 2, or run make setup with a C++ compiler'


class InputParameters(LaserParameters):
    """Where scans and their poses come from."""

    odometry_source: Literal['topic', 'tf'] = Field(
        'topic', description='Take poses from kiss/odometry, or from odom_frame in TF.'
    )
    odom_frame: str = Field(
        '', description='Child of the published TF; empty: the frame of the odometry messages.'
    )
    base_frame: str = Field(
        '', description='Frame whose pose is published; empty: the child of the odometry.'
    )
    max_pending_scans: int = Field(
        10, ge=1, le=1000, description='Scans that may wait; then the oldest are dropped.'
    )


@dataclass(frozen=True, eq=False)
class LocatedScan:
    """
    A scan and its poses (4, 4) at its stamp.

    ``unpack`` gives its points and takes a while: it is for another thread. ``T_odom_...`` are in
    the odometry's frame; ``T_tf_odom`` leads from there to the frame that TF is published for,
    and is the identity where that is the same.
    """

    unpack: Callable[[], CloudArrays]
    stamp_ns: int
    odom_frame: str
    T_odom_sensor: NDArray[np.float64]
    T_odom_base: NDArray[np.float64]
    tf_frame: str
    T_tf_odom: NDArray[np.float64]


class _Waiting(NamedTuple):
    """A scan without a pose; ``sweep`` is that of planar scanners, ``data`` a serialized cloud."""

    frame_id: str
    data: bytes = b''
    sweep: LaserSweep | None = None


class ScanInput:
    """
    Hands on every cloud once its pose is known, in the executor's thread.

    Clouds stay serialized here: all that is needed of them at first is their header, and to
    unpack a large one takes longer than the executor's thread has.

    Parameters
    ----------
    on_scan
        Takes the cloud with its poses.
    on_restart
        Called where another process publishes the odometry from now on.
    report
        Takes what is wrong with a message.
    """

    def __init__(
        self,
        node: ManagedNode,
        parameters: InputParameters,
        on_scan: Callable[[LocatedScan], None],
        on_restart: Callable[[], None],
        report: Callable[[FpnetError], None],
    ) -> None:
        self._settings = parameters
        self._on_scan, self._on_restart, self._report = on_scan, on_restart, report
        self._resolve = node.resolve_topic_name
        self._node = node
        self._tree = FrameTree()
        self._waiting: OrderedDict[int, _Waiting] = OrderedDict()
        self._odom_frame = parameters.odom_frame if parameters.odometry_source == 'tf' else ''
        self._base_frame = parameters.base_frame
        self._clouds, self._odometry = Numbering(), Numbering()
        self._heard_s = {'cloud': time.monotonic(), 'odometry': time.monotonic()}
        self.unlocated = 0
        clouds, poses = sensor_data(parameters.max_pending_scans), sensor_data(ODOMETRY_QUEUE)
        self._lasers: LaserInput | None = None
        if topics := parameters.topics:
            self._lasers = LaserInput(
                lambda kind, topic, take: node.add_subscription(kind, topic, take, clouds),
                topics,
                self._tree,
                lambda: self._base_frame,
                self._on_sweep,
                report,
            )
        else:
            node.add_subscription(PointCloud2, 'kiss/frame', self._on_cloud, clouds, raw=True)
        if parameters.odometry_source == 'topic':
            node.add_subscription(Odometry, 'kiss/odometry', self._on_odometry, poses)
        self._listen_to_tf(node)

    @property
    def ages_s(self) -> dict[str, float]:
        """Time since each input was last heard, or since the start."""
        now_s = time.monotonic()
        return {f'{name}_age_s': now_s - heard_s for name, heard_s in self._heard_s.items()}

    @property
    def silence_s(self) -> dict[str, float]:
        """Time since each input was last heard, or since the start, by its topics."""
        settings, ages_s = self._settings, self.ages_s
        poses = '/tf' if settings.odometry_source == 'tf' else self._resolve('kiss/odometry')
        scans = ', '.join(settings.topics) or self._resolve('kiss/frame')
        return {scans: ages_s['cloud_age_s'], poses: ages_s['odometry_age_s']}

    def topics(self) -> dict[str, str]:
        """Return the message type of each topic that scans and poses come on, scans first."""
        settings = self._settings
        found = dict.fromkeys(settings.topics, LASER_SCAN)
        found = found or {self._resolve('kiss/frame'): POINT_CLOUD}
        if settings.odometry_source == 'topic':
            found[self._resolve('kiss/odometry')] = ODOMETRY
        return found

    def odometry_run(self) -> OdometryRun:
        """Return which run of the odometry publishes now; in TF nobody can tell."""
        if self._settings.odometry_source == 'tf':
            return OdometryRun()
        found = self._node.get_publishers_info_by_topic('kiss/odometry')
        publishers = frozenset(bytes(each.endpoint_gid).hex() for each in found)
        return OdometryRun(publishers, self._odometry.newest)

    @property
    def lost(self) -> int:
        """Scans that were sent but did not arrive."""
        return self._clouds.lost + (0 if self._lasers is None else self._lasers.lost)

    def _listen_to_tf(self, node: ManagedNode) -> None:
        parameters = self._settings
        if parameters.odometry_source == 'tf' and not parameters.odom_frame:
            raise ConfigError(
                'parameter odom_frame is empty; with odometry_source tf it names the odometry '
                'frame in TF, as odom'
            )
        if TFMessage is None:
            if parameters.odometry_source == 'tf' or parameters.odom_frame:
                raise ConfigError(NO_TF)
            return
        node.add_subscription(TFMessage, '/tf_static', self._on_tf_static, TF_STATIC)
        if parameters.odometry_source == 'tf' or parameters.odom_frame:
            node.add_subscription(TFMessage, '/tf', self._on_tf, TF)

    def _on_cloud(self, data: bytes, info: dict[str, Any]) -> None:
        self._heard_s['cloud'] = time.monotonic()
        self._clouds.follow(info)
        header = deserialize_message(data, Header)  # the first field of every cloud
        self._waiting[stamp_from_msg(header.stamp)] = _Waiting(header.frame_id.lstrip('/'), data)
        self._hand_on()

    def _on_sweep(self, sweep: LaserSweep, base: str) -> None:
        self._heard_s['cloud'] = time.monotonic()
        self._waiting[sweep.stamp_ns] = _Waiting(base, sweep=sweep)
        self._hand_on()

    def _on_odometry(self, msg: Odometry, info: dict[str, Any]) -> None:
        self._heard_s['odometry'] = time.monotonic()
        if self._odometry.follow(info):
            self._tree.clear()
            self._waiting.clear()
            self._on_restart()
        try:
            odometry = odometry_from_msg(msg)
        except OdometryError as error:
            self._report(error)
            return
        self._odom_frame = odometry.frame_id
        if not self._settings.base_frame:
            self._base_frame = odometry.child_frame_id
        self._tree.add(
            odometry.frame_id,
            odometry.child_frame_id,
            odometry.T_odom_child,
            odometry.stamp_ns,
        )
        self._hand_on()

    def _on_tf_static(self, msg: Any) -> None:
        for transform in self._transforms(msg):
            self._tree.add_fixed(transform.parent, transform.child, transform.T_parent_child)
        self._hand_on()

    def _on_tf(self, msg: Any) -> None:
        if self._settings.odometry_source == 'tf':
            self._heard_s['odometry'] = time.monotonic()
        for t in self._transforms(msg):
            # The odometry's own frame comes from its topic; a second parent would cut it off.
            if self._settings.odometry_source == 'tf' or t.parent != self._odom_frame:
                self._tree.add(t.parent, t.child, t.T_parent_child, t.stamp_ns)
        self._hand_on()

    def _transforms(self, msg: Any) -> list[Any]:
        try:
            return [transform_from_msg(transform) for transform in msg.transforms]
        except OdometryError as error:
            self._report(error)
            return []

    def _hand_on(self) -> None:
        for stamp_ns in list(self._waiting):
            scan = self._located(stamp_ns, self._waiting[stamp_ns])
            if scan is not None:
                del self._waiting[stamp_ns]
                self._on_scan(scan)
        while len(self._waiting) > self._settings.max_pending_scans:
            stamp_ns, waiting = self._waiting.popitem(last=False)
            self.unlocated += 1
            self._report(
                OdometryError(
                    f'{self._why_unlocated(stamp_ns, waiting.frame_id)}; the scan was dropped'
                )
            )

    def _why_unlocated(self, stamp_ns: int, sensor: str) -> str:
        """Return what is missing to know where a scan was taken."""
        if not self._odom_frame:
            return f'no odometry has come for scans in {sensor!r}'
        is_own = self._settings.odometry_source == 'tf' and not self._base_frame
        base = sensor if is_own else self._base_frame
        if not base or self._tree.root(base) != self._tree.root(sensor):
            return self._tree.reason(base, sensor, stamp_ns)
        return self._tree.reason(self._odom_frame, sensor, stamp_ns)

    def _located(self, stamp_ns: int, waiting: _Waiting) -> LocatedScan | None:
        sensor, odom = waiting.frame_id, self._odom_frame
        T_odom_sensor = self._tree.lookup(odom, sensor, stamp_ns) if odom else None
        T_odom_base = self._tree.lookup(odom, self._base_frame or sensor, stamp_ns)
        if T_odom_sensor is None or T_odom_base is None:
            return None
        unpack = self._unpacking(waiting, T_odom_sensor)
        if unpack is None:
            return None
        tf_frame = self._settings.odom_frame or odom
        T_tf_odom = np.eye(4)
        if tf_frame != odom:
            T_tf_base = self._tree.lookup(tf_frame, self._base_frame or sensor, stamp_ns)
            if T_tf_base is None:
                return None
            T_tf_odom = T_tf_base @ np.linalg.inv(T_odom_base)
        return LocatedScan(unpack, stamp_ns, odom, T_odom_sensor, T_odom_base, tf_frame, T_tf_odom)

    def _unpacking(
        self, waiting: _Waiting, T_odom_last: NDArray[np.float64]
    ) -> Callable[[], CloudArrays] | None:
        """Return how to get the points; None while a sweep's first pose is not known."""
        sweep = waiting.sweep
        if sweep is None:
            return partial(_unpacked_cloud, waiting.data)
        T_odom_first = self._tree.lookup(self._odom_frame, waiting.frame_id, sweep.first_ns)
        if T_odom_first is None:
            return None
        return partial(_unpacked_sweep, sweep, np.linalg.inv(T_odom_first) @ T_odom_last)


def _unpacked_cloud(data: bytes) -> CloudArrays:
    return cloud_from_msg(deserialize_message(data, PointCloud2))


def _unpacked_sweep(sweep: LaserSweep, T_first_last: NDArray[np.float64]) -> CloudArrays:
    still = sweep.without_motion(T_first_last)
    return CloudArrays(still.points, None, viewpoints=still.viewpoints)
