# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The doctor inside a running node: checks of what passes through it anyway."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
import math
from threading import Lock
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.topic_endpoint_info import TopicEndpointInfo

from fpnet_core.doctor import Finding, Observed, Offer, Topic, Transform
from fpnet_core.doctor.clocks import check_clocks
from fpnet_core.doctor.frames import check_tree
from fpnet_core.doctor.observed import SeenScan, heard_transforms
from fpnet_core.doctor.sensor import check_mount, check_point_times, check_returns, check_unit
from fpnet_core.doctor.topics import check_published, check_qos, check_time
from fpnet_core.io.message_types import CLOCK, GRID, TRANSFORMS
from fpnet_core.io.topic_names import CLOCK_TOPIC, TF_STATIC_TOPIC, TF_TOPIC
from fpnet_core.printable import printable
from fpnet_ros.inputs import LocatedScan
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.optional_messages import TFMessage
from fpnet_ros.runtime import STALE_INPUT_S, TF_STATIC, sensor_data
from msg_adapters.diagnostics import OK, WARN, named_status_to_msg

DOCTOR = 'fpnet_doctor'
"""Name of the node that only listens."""

# Chosen, not measured:
_DISCOVERY_S = 5.0  # until publishers that are there are known
_SWEEPS = 5  # that tell how the scanner is mounted
_POINTS = 2000  # of each
_STAMPS = 10
_TF_QUEUE = 100  # messages of TF that may wait
_TF_PERIOD_S, _TF_MEMORY_S = 0.017, 10.0  # between two that are looked at; of what was heard
_BASE, _SENSOR = 'base', 'sensor'
_EMPTY = SeenScan(_SENSOR, 0, np.zeros((0, 3), dtype=np.float32), None)


class SweepCheckup:
    """
    Looks at the first cloud that odometry registers: it alone sees times of points.

    For the diagnostics: in the log whoever stamps the sweeps says what it assumes without times.

    Parameters
    ----------
    topic
        Of the clouds.
    """

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self.findings: list[Finding] | None = None  # until a cloud was seen

    def look(self, points: NDArray[np.float32], time_s: NDArray[np.float64] | None) -> None:
        """Take a cloud ``(P, 3)`` [m] and its times ``(P,)``."""
        if self.findings is None and len(points):
            sweep = SeenScan(_SENSOR, 0, points, time_s)
            seen = Observed(0.0, (), self._topic, sweeps=(sweep,))
            self.findings = list(check_point_times(seen))


class Checkup:
    """
    Looks at topics, clocks, TF and the scanner of one localizer, and says each fault once.

    Parameters
    ----------
    node
        Whose topics these are; its publishers and QoS are looked up.
    inputs
        Topics and message types of scans and poses, as resolved; the first is the scans'.
    """

    def __init__(self, node: ManagedNode, inputs: dict[str, str]) -> None:
        self._node = node
        self._topics = {**inputs, node.resolve_topic_name('floorplan'): GRID}
        self._scans = next(iter(inputs))
        self._heard = {CLOCK_TOPIC: CLOCK}  # beside the inputs; nothing is amiss without them
        self._begun_s = time.monotonic()
        self._published: set[str] = set()  # topics that somebody has published
        self._told: set[tuple[str, str]] = set()
        self._lock = Lock()  # scans come in another thread
        self._sweeps: list[SeenScan] = []
        self._mount: NDArray[np.float64] | None = None
        self._of_scanner: list[Finding] | None = None
        self._stamps: deque[tuple[int, int]] = deque(maxlen=_STAMPS)
        self._transforms: dict[tuple[str, str], tuple[Transform, float]] = {}
        self._looked_s = -math.inf
        self._is_blind = False
        self._returned_s: float | None = None  # when a scan had a return, or the first one came
        if TFMessage is not None:
            self._heard |= {
                node.resolve_topic_name(name): TRANSFORMS for name in (TF_TOPIC, TF_STATIC_TOPIC)
            }
            add = partial(node.add_subscription, TFMessage, raw=True)
            add(TF_TOPIC, self._on_tf, sensor_data(_TF_QUEUE))
            add(TF_STATIC_TOPIC, self._on_static, TF_STATIC)

    def hear(self, stamp_ns: int) -> None:
        """Take a scan's stamp when it comes: how long it waits to be added is no clock's fault."""
        now_ns = self._node.get_clock().now().nanoseconds
        if now_ns:  # else nobody has published /clock yet
            self._stamps.append((stamp_ns, now_ns))

    def look(self, scan: LocatedScan, points: NDArray[np.float32]) -> None:
        """Take whether scans have returns; of the first ones the points and the sensor's place."""
        with self._lock:
            if len(points) or self._returned_s is None:
                self._returned_s = time.monotonic()
            self._is_blind = time.monotonic() - self._returned_s > STALE_INPUT_S
            if len(self._sweeps) < _SWEEPS and len(points):
                step = max(1, len(points) // _POINTS)
                is_planar = float(np.ptp(points[:, 2])) == 0.0
                kept = points[::step].copy()
                self._sweeps.append(
                    SeenScan(_SENSOR, scan.stamp_ns, kept, None, is_planar=is_planar)
                )
                self._mount = np.linalg.inv(scan.T_odom_base) @ scan.T_odom_sensor

    def findings(self) -> list[Finding]:
        """Return what is wrong by now; what is new is logged with what to do."""
        seen = self._observed()
        checks = (check_qos, check_tree, check_clocks)
        found = [finding for check in checks for finding in check(seen)]
        found += self._found_of_scanner(seen)
        if self._is_blind:
            found += check_returns(replace(seen, sweeps=(_EMPTY,)))
        if self._is_settled:
            found += check_time(seen)
        found += self._unpublished(seen)
        for finding in found:
            if (key := (finding.problem, finding.where)) not in self._told:
                self._told.add(key)
                said = printable(f'{finding.said}; next: {finding.next}')
                self._node.get_logger().warning(said)
        return found

    def _found_of_scanner(self, seen: Observed) -> list[Finding]:
        """Return what is wrong with the scanner and its mount: they are looked at once."""
        if self._of_scanner is None:
            if len(seen.sweeps) < _SWEEPS:
                return []
            self._of_scanner = [*check_unit(seen), *check_mount(seen)]
        return self._of_scanner

    @property
    def _is_settled(self) -> bool:
        """Whether publishers that are there are known."""
        return time.monotonic() - self._begun_s >= _DISCOVERY_S

    def _unpublished(self, seen: Observed) -> list[Finding]:
        """Return the inputs that nobody publishes, each with what there is of its kind."""
        self._published |= {topic.name for topic in seen.topics if topic.offers}
        missing = [
            topic
            for topic in seen.topics
            if topic.name in self._topics
            if not topic.offers and (self._is_settled or topic.name in self._published)
        ]
        if not missing:
            return []
        node, none = self._node, np.zeros(0, dtype=np.int64)
        kinds = {name: kind for name, (kind, *_) in node.get_topic_names_and_types()}
        others = [
            Topic(name, kind, none, none)
            for name, kind in kinds.items()
            if name not in self._topics and not name.startswith(node.get_fully_qualified_name())
            if node.count_publishers(name)
        ]
        everything = replace(seen, topics=(*seen.topics, *others))
        return list(check_published(everything, [topic.name for topic in missing]))

    def _observed(self) -> Observed:
        with self._lock:
            sweeps, mount = list(self._sweeps), self._mount
        times = np.array(self._stamps, dtype=np.int64).reshape(-1, 2)
        kinds = {**self._topics, **self._heard}
        topics = [self._topic(name, kind, times) for name, kind in kinds.items()]
        transforms = self._heard_transforms()
        if mount is not None and not np.array_equal(mount, np.eye(4)):
            transforms.append(Transform(_BASE, _SENSOR, mount, is_static=True))
        return Observed(
            0.0,
            tuple(topics),
            self._scans,
            transforms=tuple(transforms),
            sweeps=tuple(sweeps),
            is_live=True,
        )

    def _topic(self, name: str, kind: str, times: NDArray[np.int64]) -> Topic:
        node, is_scans = self._node, name == self._scans
        own = [s for s in node.get_subscriptions_info_by_topic(name) if self._is_own(s)]
        return Topic(
            name,
            kind,
            times[:, 0] if is_scans else np.zeros(0, dtype=np.int64),
            times[:, 1] if is_scans else np.zeros(0, dtype=np.int64),
            offers=offers_of(node.get_publishers_info_by_topic(name)),
            requests=offers_of(own),
        )

    def _is_own(self, endpoint: Any) -> bool:
        node = self._node
        whose = endpoint.node_namespace, endpoint.node_name
        return whose == (node.get_namespace(), node.get_name())

    def _on_static(self, data: bytes) -> None:
        self._take_transforms(data, is_static=True)

    def _on_tf(self, data: bytes) -> None:
        # Some of many: whoever overwrites a frame does so again and again.
        now_s = time.monotonic()
        if now_s - self._looked_s >= _TF_PERIOD_S:
            self._looked_s = now_s
            self._take_transforms(data, is_static=False)

    def _take_transforms(self, data: bytes, is_static: bool) -> None:
        try:
            for each in heard_transforms(deserialize_message(data, TFMessage), is_static):
                self._transforms[each.parent, each.child] = each, time.monotonic()
        except ValueError:
            return  # whoever looks it up says so

    def _heard_transforms(self) -> list[Transform]:
        """Return those that are static, or came lately."""
        oldest_s = time.monotonic() - _TF_MEMORY_S
        return [
            each
            for each, heard_s in list(self._transforms.values())
            if each.is_static or heard_s > oldest_s
        ]


def offers_of(endpoints: Iterable[TopicEndpointInfo]) -> tuple[Offer, ...]:
    """Return the QoS of publishers or subscribers, each with the name of its node."""
    return tuple(_offer(each) for each in endpoints if each.node_name != DOCTOR)


def _offer(endpoint: TopicEndpointInfo) -> Offer:
    qos: QoSProfile = endpoint.qos_profile
    is_latched = qos.durability is QoSDurabilityPolicy.TRANSIENT_LOCAL
    is_reliable = qos.reliability is not QoSReliabilityPolicy.BEST_EFFORT
    return Offer(endpoint.node_name, is_reliable, is_latched)


def findings_to_msg(name: str, findings: Sequence[Finding]) -> Any:
    """Return the DiagnosticStatus of a node's doctor: what is wrong, each with what to do."""
    return named_status_to_msg(
        WARN if findings else OK,
        f'{name}: doctor',
        '; '.join(finding.said for finding in findings) or 'nothing is wrong',
        {finding.said: finding.next for finding in findings},
    )
