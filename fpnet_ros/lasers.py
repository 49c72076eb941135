# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""LaserScans of one or more planar scanners, merged into sweeps in the base frame."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
import time
from typing import Any

from pydantic import Field
from sensor_msgs.msg import LaserScan, MultiEchoLaserScan

from fpnet_core.config import Section
from fpnet_core.errors import FpnetError, OdometryError
from fpnet_core.geometry.frame_tree import FrameTree, plain_frame
from fpnet_core.io.laser_sweeps import SAME_SWEEP_NS, LaserSweep, SweepMerger, mounted
from fpnet_ros.runtime import Once
from fpnet_ros.work import Numbering
from msg_adapters.lasers import laser_from_msg
from msg_adapters.stamps import stamp_from_msg

Subscribe = Callable[[type, str, Callable[[Any, dict[str, Any]], None]], Any]
"""Creates a sensor-data subscription from message class, topic and callback."""


class LaserParameters(Section):
    """Topics of planar scanners."""

    scan_topics: tuple[str, ...] = Field(
        (), description='LaserScan topics to merge and use instead of clouds; empty: clouds.'
    )
    multi_echo_topics: tuple[str, ...] = Field(
        (), description='The same for MultiEchoLaserScan; the nearest echo is used.'
    )

    @property
    def topics(self) -> dict[str, type]:
        """Message class of each topic; empty names, as from launch files, are ignored."""
        kinds = {topic: LaserScan for topic in self.scan_topics if topic}
        return kinds | {topic: MultiEchoLaserScan for topic in self.multi_echo_topics if topic}


class LaserInput:
    """
    Passes on merged sweeps of all scanners, in the executor's thread.

    Decoding a scan here takes a fraction of a millisecond. A scan waits while the mount of its
    scanner is unknown, so that none is lost before ``/tf_static`` arrives.

    Parameters
    ----------
    subscribe
        Creates the subscriptions.
    topics
        Message class by topic.
    tree
        Transforms with the mounts of the scanners.
    base_frame
        Returns the base frame; empty: the scanner's frame, if there is only one.
    on_sweep
        Called with each sweep and its frame.
    report
        Called with the error of an unusable message.
    limit
        Number of scans of each scanner that may wait for its mount; the oldest are dropped.
    """

    def __init__(
        self,
        subscribe: Subscribe,
        topics: dict[str, type],
        tree: FrameTree,
        base_frame: Callable[[], str],
        on_sweep: Callable[[LaserSweep, str], None],
        report: Callable[[FpnetError], None],
        limit: int,
    ) -> None:
        self._tree, self._base_frame = tree, base_frame
        self._on_sweep, self._report = on_sweep, report
        self._limit = limit
        self._waiting: deque[tuple[str, Any]] = deque()
        self._newest_ns = 0  # newest stamp that was passed on
        self._mount_log = Once(report)
        self.heard_s = time.monotonic()
        """Monotonic time of the last received scan, usable or not [s]."""
        self.dropped = 0
        """Scans for which the mount of their scanner did not arrive in time."""
        self.refused = 0
        """Inconsistent scans, and scans of tilted scanners."""
        self._merger = SweepMerger(len(topics))
        self._is_alone = len(topics) == 1
        self._numbering = {topic: Numbering() for topic in topics}
        for topic, kind in topics.items():
            subscribe(kind, topic, partial(self._on_scan, topic))

    @property
    def lost(self) -> int:
        """Scans that were sent but did not arrive."""
        return sum(numbering.lost for numbering in self._numbering.values())

    @property
    def earlier(self) -> int:
        """Scans that were sent before the first received one of each scanner."""
        return sum(numbering.earlier for numbering in self._numbering.values())

    def _on_scan(self, topic: str, msg: Any, info: dict[str, Any]) -> None:
        self.heard_s = time.monotonic()
        self._numbering[topic].follow(info)
        self._waiting.append((topic, msg))
        held, self._waiting = self._waiting, deque()
        while held:  # in the order of arrival
            self._use(*held.popleft(), is_late=bool(held))
        self._drop(topic)

    def _use(self, topic: str, msg: Any, is_late: bool) -> None:
        """Pass a scan on, or let it wait for the mount of its scanner."""
        frame = plain_frame(msg.header.frame_id)
        base = self._base_frame() or (frame if self._is_alone else '')
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
            self._mount_log.clear(topic)
        elif len(own) > self._limit:
            self._waiting.remove(own[0])
            self.dropped += 1
            frame = plain_frame(own[0][1].header.frame_id)
            why = self._unknown(frame, self._base_frame())
            self._mount_log.tell(OdometryError(f'{why}; the scan was dropped'), topic)

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
            self._report(error)
            return
        for complete in self._merger.add(topic, sweep):
            self._on_sweep(complete, base)
