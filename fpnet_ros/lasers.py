# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar scanners of a robot: their LaserScans as sweeps in the frame of its base."""

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
"""Makes a subscription for sensor data of a message class and topic."""


class LaserParameters(Section):
    """Planar scanners in place of clouds."""

    scan_topics: tuple[str, ...] = Field(
        (), description='Topics of LaserScan, merged, in place of clouds; empty: clouds.'
    )
    multi_echo_topics: tuple[str, ...] = Field(
        (), description='The same for MultiEchoLaserScan; the nearest echo counts.'
    )

    @property
    def topics(self) -> dict[str, type]:
        """Message class of each topic; a name that a launch file left empty is none."""
        kinds = {topic: LaserScan for topic in self.scan_topics if topic}
        return kinds | {topic: MultiEchoLaserScan for topic in self.multi_echo_topics if topic}


class LaserInput:
    """
    Hands on one sweep of all scanners at a time, in the executor's thread.

    A scan is small: to unpack it here takes a fraction of a millisecond. One whose scanner has no
    place on the robot yet waits, so that none is lost while ``/tf_static`` is on its way.

    Parameters
    ----------
    subscribe
        Makes the subscriptions.
    topics
        Message class by topic.
    tree
        Knows where scanners are on the robot.
    base_frame
        Returns the robot's frame; empty: that of the scanner, if there is one only.
    on_sweep
        Takes a sweep and the frame that it is in.
    report
        Takes what is wrong with a message.
    limit
        Scans of each scanner that may wait for its place; then the oldest are dropped.
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
        self._newest_ns = 0  # of all that were handed on
        self._unplaced = Once(report)
        self.heard_s = time.monotonic()
        """When any scan came last, of use or not, by the monotonic clock."""
        self.dropped = 0
        """Scans whose scanner had no place on the robot in time."""
        self.refused = 0
        """Scans that contradict themselves, or whose scanner is tilted."""
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
        """Scans that were sent before the first that was heard of each scanner."""
        return sum(numbering.earlier for numbering in self._numbering.values())

    def _on_scan(self, topic: str, msg: Any, info: dict[str, Any]) -> None:
        self.heard_s = time.monotonic()
        self._numbering[topic].follow(info)
        self._waiting.append((topic, msg))
        held, self._waiting = self._waiting, deque()
        while held:  # in the order in which they came
            self._use(*held.popleft(), is_late=bool(held))
        self._drop(topic)

    def _use(self, topic: str, msg: Any, is_late: bool) -> None:
        """Hand a scan on, or let it wait."""
        frame = plain_frame(msg.header.frame_id)
        base = self._base_frame() or (frame if self._is_alone else '')
        if self._unknown(frame, base):
            self._waiting.append((topic, msg))
        elif is_late and self._newest_ns - stamp_from_msg(msg.header.stamp) > SAME_SWEEP_NS:
            self.dropped += 1  # other scanners have gone on without it
        else:
            self._hand_on(topic, msg, frame, base)

    def _drop(self, topic: str) -> None:
        """Drop the oldest scan of a scanner that has too many waiting."""
        own = [each for each in self._waiting if each[0] == topic]
        if not own:
            self._unplaced.clear(topic)
        elif len(own) > self._limit:
            self._waiting.remove(own[0])
            self.dropped += 1
            frame = plain_frame(own[0][1].header.frame_id)
            why = self._unknown(frame, self._base_frame())
            self._unplaced.tell(OdometryError(f'{why}; the scan was dropped'), topic)

    def _unknown(self, frame: str, base: str) -> str:
        """Return why nobody knows the scanner's place yet; empty: it is known."""
        if not base:
            return (
                f'scans in {frame!r} wait for the frame to merge them in; set base_frame, or '
                'publish odometry'
            )
        is_known = self._tree.lookup(base, frame, 0) is not None
        return '' if is_known else self._tree.reason(base, frame, 0)

    def _hand_on(self, topic: str, msg: Any, frame: str, base: str) -> None:
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
