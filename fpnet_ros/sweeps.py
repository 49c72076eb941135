# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sweeps of a robot: clouds of one topic, or LaserScans of planar scanners, merged."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
import time
from typing import Any

from rclpy.utilities import get_rmw_implementation_identifier
from sensor_msgs.msg import LaserScan, MultiEchoLaserScan, PointCloud2

from fpnet_core.errors import FpnetError, OdometryError
from fpnet_core.geometry.frame_tree import FrameTree, plain_frame
from fpnet_core.io.laser_sweeps import SAME_SWEEP_NS, LaserSweep, SweepMerger, mounted
from fpnet_core.io.message_types import LASER_SCAN, POINT_CLOUD
from fpnet_ros.logs import NodeLog
from fpnet_ros.params import OwnValues
from fpnet_ros.runtime import sensor_data
from fpnet_ros.settings import InputParameters, OdometryParameters
from fpnet_ros.wiring import said_of_transport
from msg_adapters.lasers import laser_from_msg
from msg_adapters.stamps import stamp_from_msg

_NUMBER, _FIRST, _NO_NUMBER = 'publication_sequence_number', 1, 2**64 - 1  # given
_MOST_LOST = 1000  # a larger gap means that two publishers alternate; chosen


class Numbering:
    """
    Counts lost messages by the sequence numbers of their publisher.

    ``lost`` counts messages that did not arrive: queues overflowed, or fragments went missing.
    ``earlier`` counts messages that were sent before the first received one: none after complete
    discovery, thousands if a driver has been running. ``newest`` is the number of the newest
    message, 0 if the middleware does not number them.
    """

    def __init__(self) -> None:
        self.newest = self.lost = self.earlier = 0

    def follow(self, info: Mapping[str, Any]) -> bool:
        """Count a message by its information; return whether a new publisher took over."""
        number = int(info.get(_NUMBER, _NO_NUMBER))
        if number == _NO_NUMBER:  # the middleware does not number messages
            return False
        last, self.newest = self.newest, number
        if not last:
            self.earlier = max(0, number - _FIRST)
            return False
        missing = number - last - 1
        if 0 < missing < _MOST_LOST:
            self.lost += missing
        return number < last


class SweepInput:
    """
    Passes on clouds as they come, or merged sweeps of all scanners, in the executor's thread.

    The parameters name the scanners; without any, ``on_cloud`` gets the bytes of each message on
    ``cloud_topic``. A LaserScan is decoded here, which takes a fraction of a millisecond. It waits
    while the mount of its scanner in ``base_frame()`` is unknown in ``tree``, so that none is lost
    before ``/tf_static`` arrives; of more than ``max_pending_scans`` the oldest is dropped. An
    empty base frame stands for the scanner's, if there is only one. ``on_sweep`` gets merged
    sweeps and their frame, ``log`` the errors of unusable messages.

    ``topics`` maps resolved topics to message types. ``dropped`` counts scans for which the mount
    did not arrive in time, ``refused`` inconsistent ones and those of tilted scanners.
    """

    def __init__(
        self,
        node: OwnValues,
        parameters: InputParameters | OdometryParameters,
        cloud_topic: str,
        tree: FrameTree,
        base_frame: Callable[[], str],
        on_cloud: Callable[[bytes], None],
        on_sweep: Callable[[LaserSweep, str], None],
        log: NodeLog,
    ) -> None:
        self._tree, self._base_frame, self._log = tree, base_frame, log
        self._on_cloud, self._on_sweep = on_cloud, on_sweep
        self._limit = parameters.max_pending_scans
        self._heard_s = time.monotonic()
        self.dropped = self.refused = 0
        self._waiting: deque[tuple[str, Any]] = deque()
        self._newest_ns = 0  # newest stamp that was passed on
        # Empty names, as from launch files, are ignored.
        kinds: dict[str, type] = {topic: LaserScan for topic in parameters.scan_topics if topic}
        kinds |= {topic: MultiEchoLaserScan for topic in parameters.multi_echo_topics if topic}
        self._count, self._merger = len(kinds), SweepMerger(len(kinds))
        self._numbering = {topic: Numbering() for topic in kinds or (cloud_topic,)}
        kind = LASER_SCAN if kinds else POINT_CLOUD
        self.topics = {node.resolve_topic_name(topic): kind for topic in self._numbering}
        qos = sensor_data(self._limit)
        for topic, message in kinds.items():
            node.add_subscription(message, topic, partial(self._on_scan, topic), qos)
        if not kinds:  # raw, because decoding is slow
            if said := said_of_transport(get_rmw_implementation_identifier()):
                node.get_logger().info(said)
            take = partial(self._take_cloud, cloud_topic)
            node.add_subscription(PointCloud2, cloud_topic, take, qos, raw=True)

    @property
    def is_laser(self) -> bool:
        """Whether the sweeps come from planar scanners."""
        return self._count > 0

    @property
    def silence_s(self) -> float:
        """Time since the last message, usable or not, or since the start [s]."""
        return time.monotonic() - self._heard_s

    @property
    def lost(self) -> int:
        """Messages that were sent but did not arrive."""
        return sum(numbering.lost for numbering in self._numbering.values())

    @property
    def earlier(self) -> int:
        """Messages that were sent before the first received one of each publisher."""
        return sum(numbering.earlier for numbering in self._numbering.values())

    def _hear(self, topic: str, info: dict[str, Any]) -> None:
        self._heard_s = time.monotonic()
        self._numbering[topic].follow(info)

    def _take_cloud(self, topic: str, data: bytes, info: dict[str, Any]) -> None:
        self._hear(topic, info)
        self._on_cloud(data)

    def _on_scan(self, topic: str, msg: Any, info: dict[str, Any]) -> None:
        self._hear(topic, info)
        self._waiting.append((topic, msg))
        held, self._waiting = self._waiting, deque()
        while held:  # in the order of arrival
            self._use(*held.popleft(), is_late=bool(held))
        self._drop(topic)

    def _use(self, topic: str, msg: Any, is_late: bool) -> None:
        """Pass a scan on, or let it wait for the mount of its scanner."""
        frame = plain_frame(msg.header.frame_id)
        base = self._base_frame() or (frame if self._count == 1 else '')
        if self._unknown(frame, base):
            self._waiting.append((topic, msg))
        elif is_late and self._newest_ns - stamp_from_msg(msg.header.stamp) > SAME_SWEEP_NS:
            self.dropped += 1  # too late to merge with the other scanners
        else:
            self._pass_on(topic, msg, frame, base)

    def _drop(self, topic: str) -> None:
        """Drop the oldest scan of a scanner if too many wait."""
        own = [each for each in self._waiting if each[0] == topic]
        if not own:
            self._log.succeed(f'mount of {topic}')
        elif len(own) > self._limit:
            self._waiting.remove(own[0])
            self.dropped += 1
            why = self._unknown(plain_frame(own[0][1].header.frame_id), self._base_frame())
            self._log.fail(f'mount of {topic}', OdometryError(f'{why}; the scan was dropped'))

    def _unknown(self, frame: str, base: str) -> str:
        """Return why the mount of the scanner is unknown; empty if it is known."""
        if not base:
            return (
                f'scans in {frame!r} wait for a base frame to merge them in; set base_frame, or '
                'publish odometry'
            )
        is_known = self._tree.lookup(base, frame, 0) is not None
        return '' if is_known else self._tree.reason(base, frame, 0)

    def _pass_on(self, topic: str, msg: Any, frame: str, base: str) -> None:
        try:
            T_base_laser = self._tree.mount(base, frame)
            stamp_ns = stamp_from_msg(msg.header.stamp)
            self._newest_ns = max(stamp_ns, self._newest_ns)
            sweep = mounted(laser_from_msg(msg), stamp_ns, T_base_laser, frame)
        except FpnetError as error:
            self.refused += 1
            self._log.report(error)
            return
        for complete in self._merger.add(topic, sweep):
            self._on_sweep(complete, base)
