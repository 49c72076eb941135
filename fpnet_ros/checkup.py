# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of ``fpnet doctor`` on the messages that a running node receives anyway."""

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
"""Name of the node of ``fpnet doctor``, which only subscribes."""

# Chosen, not measured:
_DISCOVERY_S = 5.0  # until existing publishers are discovered
_SWEEPS = 5  # checked for the mount of the scanner
_POINTS = 2000  # of each sweep
_STAMPS = 10  # of scans, compared with the clock
_TF_QUEUE = 100  # TF messages that may wait
_TF_PERIOD_S, _TF_MEMORY_S = 0.017, 10.0  # between two checked messages; of received transforms
_BASE, _SENSOR = 'base', 'sensor'
_EMPTY = SeenScan(_SENSOR, 0, np.zeros((0, 3), dtype=np.float32), None)


class SweepCheckup:
    """
    Checks the first cloud of the odometry node, which alone reads the times of points.

    The findings go to the diagnostics only: ``SweepStamps`` logs its assumptions without times.

    Parameters
    ----------
    topic
        Topic of the clouds.
    """

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self.findings: list[Finding] | None = None  # None before the first cloud

    def look(self, points: NDArray[np.float32], time_s: NDArray[np.float64] | None) -> None:
        """Check the first non-empty cloud: points ``(P, 3)`` [m], times ``(P,)`` [s]."""
        if self.findings is None and len(points):
            sweep = SeenScan(_SENSOR, 0, points, time_s)
            seen = Observed(0.0, (), self._topic, sweeps=(sweep,))
            self.findings = list(check_point_times(seen))


class Checkup:
    """
    Checks topics, clocks, TF and the scanner of one localizer, and logs each fault once.

    Parameters
    ----------
    node
        The localizer's node, whose topics are checked for publishers and QoS.
    inputs
        Message type by resolved topic of scans and poses; the topic of scans comes first.
    """

    def __init__(self, node: ManagedNode, inputs: dict[str, str]) -> None:
        self._node = node
        self._topics = {**inputs, node.resolve_topic_name('floorplan'): GRID}
        self._scans = next(iter(inputs))
        self._heard = {CLOCK_TOPIC: CLOCK}  # optional: no fault if they are missing
        self._begun_s = time.monotonic()
        self._published: set[str] = set()  # topics that have had a publisher
        self._logged: set[tuple[str, str]] = set()
        self._lock = Lock()  # look() runs in the thread that adds scans
        self._sweeps: list[SeenScan] = []
        self._mount: NDArray[np.float64] | None = None
        self._scanner_found: list[Finding] | None = None
        self._stamps: deque[tuple[int, int]] = deque(maxlen=_STAMPS)
        self._transforms: dict[tuple[str, str], tuple[Transform, float]] = {}
        self._looked_s = -math.inf
        self._is_blind = False
        self._returned_s: float | None = None  # of the last scan with a return, or the first
        if TFMessage is not None:
            self._heard |= {
                node.resolve_topic_name(name): TRANSFORMS for name in (TF_TOPIC, TF_STATIC_TOPIC)
            }
            add = partial(node.add_subscription, TFMessage, raw=True)
            add(TF_TOPIC, self._on_tf, sensor_data(_TF_QUEUE))
            add(TF_STATIC_TOPIC, self._on_static, TF_STATIC)

    def hear(self, stamp_ns: int) -> None:
        """Note a scan's stamp on arrival, before it waits: the wait is not a clock offset."""
        now_ns = self._node.get_clock().now().nanoseconds
        if now_ns:  # 0 before the first /clock
            self._stamps.append((stamp_ns, now_ns))

    def look(self, scan: LocatedScan, points: NDArray[np.float32]) -> None:
        """Note whether a scan has returns; keep the first sweeps and the sensor's mount."""
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
        """Return all current findings; log new ones with their remedies."""
        seen = self._observed()
        checks = (check_qos, check_tree, check_clocks)
        found = [finding for check in checks for finding in check(seen)]
        found += self._scanner_findings(seen)
        if self._is_blind:
            found += check_returns(replace(seen, sweeps=(_EMPTY,)))
        if self._is_settled:
            found += check_time(seen)
        found += self._unpublished(seen)
        for finding in found:
            if (key := (finding.problem, finding.where)) not in self._logged:
                self._logged.add(key)
                said = printable(f'{finding.said}; next: {finding.next}')
                self._node.get_logger().warning(said)
        return found

    def _scanner_findings(self, seen: Observed) -> list[Finding]:
        """Return the findings about the scanner and its mount, which are checked once."""
        if self._scanner_found is None:
            if len(seen.sweeps) < _SWEEPS:
                return []
            self._scanner_found = [*check_unit(seen), *check_mount(seen)]
        return self._scanner_found

    @property
    def _is_settled(self) -> bool:
        """Whether existing publishers have been discovered."""
        return time.monotonic() - self._begun_s >= _DISCOVERY_S

    def _unpublished(self, seen: Observed) -> list[Finding]:
        """Return a finding for each unpublished input; it names topics of the same type."""
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
        # A sample suffices: a node that overwrites a frame does so repeatedly.
        now_s = time.monotonic()
        if now_s - self._looked_s >= _TF_PERIOD_S:
            self._looked_s = now_s
            self._take_transforms(data, is_static=False)

    def _take_transforms(self, data: bytes, is_static: bool) -> None:
        try:
            for each in heard_transforms(deserialize_message(data, TFMessage), is_static):
                self._transforms[each.parent, each.child] = each, time.monotonic()
        except ValueError:
            return  # the lookup of the transform reports it

    def _heard_transforms(self) -> list[Transform]:
        """Return static transforms and those received within ``_TF_MEMORY_S``."""
        oldest_s = time.monotonic() - _TF_MEMORY_S
        return [
            each
            for each, heard_s in list(self._transforms.values())
            if each.is_static or heard_s > oldest_s
        ]


def offers_of(endpoints: Iterable[TopicEndpointInfo]) -> tuple[Offer, ...]:
    """Return QoS and node name of publishers or subscribers, without ``fpnet doctor``'s own."""
    return tuple(_offer(each) for each in endpoints if each.node_name != DOCTOR)


def _offer(endpoint: TopicEndpointInfo) -> Offer:
    qos: QoSProfile = endpoint.qos_profile
    is_latched = qos.durability is QoSDurabilityPolicy.TRANSIENT_LOCAL
    is_reliable = qos.reliability is not QoSReliabilityPolicy.BEST_EFFORT
    return Offer(endpoint.node_name, is_reliable, is_latched)


def findings_to_msg(name: str, findings: Sequence[Finding]) -> Any:
    """Return a DiagnosticStatus with a node's findings and their remedies."""
    return named_status_to_msg(
        WARN if findings else OK,
        f'{name}: doctor',
        '; '.join(finding.said for finding in findings) or 'nothing is wrong',
        {finding.said: finding.next for finding in findings},
    )
