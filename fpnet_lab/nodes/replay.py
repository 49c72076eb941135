# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node that plays a ROS 2 bag into live topics, in raw bytes as recorded."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.publisher import Publisher
from rich.progress import track
from rosgraph_msgs.msg import Clock as ClockMsg

from fpnet_core.errors import BagFormatError, ConfigError
from fpnet_core.io.bags import BagReader
from fpnet_core.io.message_types import SCANS
from fpnet_core.io.topic_names import CLOCK_TOPIC, KISS_ODOMETRY
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.runtime import STATUS, STREAM, TF_STATIC, run_node
from fpnet_ros.settings import ReplayParameters
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.stamps import stamp_to_msg

_CLOCK_PERIOD_S = 1 / 40  # given: as `ros2 bag play --clock`; every node receives each message
# Chosen, not measured:
_SILENCE_S = 10.0
_DISCOVERY_POLL_S = 0.05
# Discovery is mutual: a best-effort subscriber may discover this publisher a moment later.
_DISCOVERY_SETTLE_S = 0.5
# A recorder gets latched messages when it subscribes, one topic after the other.
_LATCHED_FIRST_NS = NS_PER_S
# Reliable subscribers acknowledge the last messages within milliseconds; dead ones never do.
_LAST_ACKNOWLEDGEMENT_S = 2.0


class ReplayNode(OwnValues):
    """Publishes recorded messages on their topics at the recorded pace."""

    def __init__(self) -> None:
        super().__init__('replay')
        self._settings = ParameterTree(self, ReplayParameters).value
        if not self._settings.bag:
            raise ConfigError('parameter bag is empty; set it to the recording to play')
        self._now_ns: int | None = None  # recorded time, None before the first message
        self._clock_publisher: Publisher[Any] | None = None
        if self._settings.clock:
            self._clock_publisher = self.create_publisher(ClockMsg, CLOCK_TOPIC, 10)
        self._confirmed = 0
        if self._settings.max_ahead:
            self.create_subscription(Odometry, KISS_ODOMETRY, self._confirm, STREAM)
        self._status: Status | None = None  # of the localizer
        if self._settings.wait_for_localizer:
            self.create_subscription(DiagnosticStatus, 'localizer/status', self._on_status, STATUS)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)
        self._outputs: dict[str, Publisher[Any]] = {}
        self._latched_topics: frozenset[str] = frozenset()

    def play(self) -> None:
        """Play the recording, once unless it loops; return when it is delivered."""
        with BagReader(Path(self._settings.bag)) as bag:
            types = self._chosen_topics(bag)
            self._latched_topics = frozenset(topic for topic in types if bag.is_latched(topic))
            self._outputs = {
                topic: self.create_publisher(
                    _message_class(kind),
                    topic,
                    TF_STATIC if topic in self._latched_topics else STREAM,
                )
                for topic, kind in types.items()
            }
            early = self._publish_early(bag)
            self._wait_for_subscriber([t for t, kind in types.items() if kind in SCANS])
            played = self._publish_all(bag, early)
            while self._settings.loop and played:
                self.get_logger().info(f'played {played} messages; starting again')
                played = self._publish_all(bag)
        for publisher in self._outputs.values():
            publisher.wait_for_all_acked(Duration(seconds=_LAST_ACKNOWLEDGEMENT_S))
        self.get_logger().info(f'played {played} messages')

    def _chosen_topics(self, bag: BagReader) -> dict[str, str]:
        chosen = self._settings.topics or tuple(bag.topics)
        if missing := [topic for topic in chosen if topic not in bag.topics]:
            raise BagFormatError(
                f'bag {self._settings.bag} lacks {", ".join(missing)}; it has '
                f'{", ".join(sorted(bag.topics)) or "no topics"}'
            )
        return {topic: bag.topics[topic] for topic in chosen}

    def _wait_for_subscriber(self, scans: list[str]) -> None:
        deadline = time.monotonic() + self._settings.wait_for_subscriber_s
        while not self._is_ready(scans):
            if time.monotonic() > deadline:
                self.get_logger().warning('the subscribers are not ready; playing anyway')
                return
            self._spin_for(_DISCOVERY_POLL_S)
        self._spin_for(_DISCOVERY_SETTLE_S)

    def _is_ready(self, scans: list[str]) -> bool:
        """Return whether the awaited subscribers are ready."""
        is_heard = {t: each.get_subscription_count() > 0 for t, each in self._outputs.items()}
        if not self._settings.wait_for_localizer:
            return any(is_heard.values())
        # A localizer that publishes its status has compiled and subscribed.
        is_ready = self._status not in (None, Status.NO_PLAN)
        return is_ready and all(is_heard[topic] for topic in scans)

    def _on_status(self, msg: DiagnosticStatus) -> None:
        self._status = report_from_msg(msg).status

    def _publish_early(self, bag: BagReader) -> int:
        """
        Publish the latched messages of the recording's first second; return their number.

        The awaited nodes may need them to become ready: a localizer the recorded map, scans the
        mount of their sensor.
        """
        until_ns, count = None, 0
        found = bag.raw_messages(sorted(self._latched_topics)) if self._latched_topics else ()
        for topic, _, stamp_ns, data in found:
            until_ns = stamp_ns + _LATCHED_FIRST_NS if until_ns is None else until_ns
            if stamp_ns > until_ns:
                break
            self._outputs[topic].publish(data)
            count += 1
        return count

    def _publish_all(self, bag: BagReader, early: int = 0) -> int:
        """Publish all but the first ``early`` latched messages; return the number with them."""
        played = scans = self._confirmed = 0
        first_ns: int | None = None
        messages = track(
            bag.raw_messages(list(self._outputs)),
            'replay',
            sum(bag.count(topic) for topic in self._outputs),
            transient=True,
            disable=not sys.stderr.isatty(),
        )
        for topic, kind, stamp_ns, data in messages:
            if first_ns is None:
                first_ns = stamp_ns + round(self._settings.start_offset_s * NS_PER_S)
                started_s = time.monotonic()
            if early and topic in self._latched_topics:
                played, early = played + 1, early - 1
                continue
            if stamp_ns >= first_ns:
                started_s += self._wait_for_odometry(scans)
                self._wait_until(stamp_ns, first_ns, started_s)
            elif topic not in self._latched_topics:  # latched messages are still valid
                continue
            self._outputs[topic].publish(data)
            played, scans = played + 1, scans + (kind in SCANS)
        return played

    def _confirm(self, _: Odometry) -> None:
        self._confirmed += 1

    def _wait_for_odometry(self, scans: int) -> float:
        """
        Pause while odometry is too far behind; return for how long [s].

        A machine too slow for the sensor's rate thus plays slower instead of losing scans. Refused
        scans are never confirmed, so after ``_SILENCE_S`` without odometry all count as confirmed.
        """
        heard_s = started_s = time.monotonic()
        confirmed = self._confirmed
        while self._settings.max_ahead and scans - confirmed >= self._settings.max_ahead:
            self._spin_for(_CLOCK_PERIOD_S)
            if self._confirmed != confirmed:
                heard_s, confirmed = time.monotonic(), self._confirmed
            elif time.monotonic() - heard_s > _SILENCE_S:
                self.get_logger().warning('no odometry is received; playing on')
                self._confirmed = scans
                break
        return time.monotonic() - started_s

    def _wait_until(self, stamp_ns: int, first_ns: int, started_s: float) -> None:
        """Spin until the recorded time ``stamp_ns`` is due, keeping /clock running."""
        rate = self._settings.rate
        while True:
            elapsed_ns = round((time.monotonic() - started_s) * NS_PER_S * rate)
            now_ns = min(first_ns + elapsed_ns, stamp_ns)
            if self._clock_publisher is not None and now_ns != self._now_ns:
                self._now_ns = now_ns
                self._clock_publisher.publish(ClockMsg(clock=stamp_to_msg(now_ns)))
            if now_ns == stamp_ns:
                return
            self._spin_for(min((stamp_ns - now_ns) / NS_PER_S / rate, _CLOCK_PERIOD_S))

    def _spin_for(self, seconds: float) -> None:
        """Answer parameter services for a while; raise ExternalShutdownException on shutdown."""
        deadline = time.monotonic() + seconds
        while (left_s := deadline - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left_s)
        if not self.context.ok():
            raise ExternalShutdownException


def _message_class(msgtype: str) -> Any:
    """Return the class of a type, for example ``sensor_msgs/msg/PointCloud2``."""
    package, _, name = msgtype.split('/')
    try:
        return getattr(import_module(f'{package}.msg'), name)
    except (ImportError, AttributeError):
        raise BagFormatError(
            f'message type {msgtype} is not installed; install {package} or choose other topics'
        ) from None


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_node(ReplayNode, arguments, ReplayNode.play)
