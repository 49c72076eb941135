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
from rclpy.qos import QoSDurabilityPolicy, QoSReliabilityPolicy
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
from fpnet_ros.runtime import TF_STATIC, TFMessage, sensor_data
from fpnet_ros.settings import STALE_INPUT_S
from msg_adapters.diagnostics import OK, WARN, named_status_to_msg

DOCTOR = 'fpnet_doctor'
"""Given: name of the node of ``fpnet doctor``, which only subscribes."""

# Chosen, not measured:
_DISCOVERY_S = 5.0  # until existing publishers are discovered
_SWEEPS, _POINTS = 5, 2000  # checked for the mount of the scanner; points of each
_STAMPS = 10  # of scans, compared with the clock
_TF_QUEUE = 100  # TF messages that may wait
_TF_PERIOD_S, _TF_MEMORY_S = 0.017, 10.0  # between two checked messages; of received transforms

_BASE, _SENSOR = 'base', 'sensor'
_EMPTY = SeenScan(_SENSOR, 0, np.zeros((0, 3), dtype=np.float32), None)  # numerical
_NO_STAMPS = np.zeros(0, dtype=np.int64)


class SweepCheckup:
    """
    Checks the first cloud of the odometry node, which alone reads the times of points.

    The findings go to the diagnostics only: ``SweepStamps`` logs its assumptions without times.
    ``findings`` is None before the first cloud on ``topic``.
    """

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self.findings: list[Finding] | None = None

    def look(self, points: NDArray[np.float32], time_s: NDArray[np.float64] | None) -> None:
        """Check the first non-empty cloud: points ``(P, 3)`` [m], times ``(P,)`` [s]."""
        if self.findings is None and len(points):
            sweep = SeenScan(_SENSOR, 0, points, time_s)
            seen = Observed(0.0, (), self._topic, sweeps=(sweep,))
            self.findings = list(check_point_times(seen))


class Checkup:
    """
    Checks topics, clocks, TF and the scanner of one localizer, and logs each fault once.

    ``inputs`` maps resolved topics of scans and poses to message types, the topic of scans first.
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
            tf, static = map(node.resolve_topic_name, (TF_TOPIC, TF_STATIC_TOPIC))
            self._heard |= {tf: TRANSFORMS, static: TRANSFORMS}
            add = partial(node.add_subscription, TFMessage, raw=True)
            add(TF_TOPIC, self._on_tf, sensor_data(_TF_QUEUE))
            add(TF_STATIC_TOPIC, partial(self._take_transforms, is_static=True), TF_STATIC)

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
                is_planar = float(np.ptp(points[:, 2])) == 0.0
                kept = points[:: max(1, len(points) // _POINTS)].copy()
                sweep = SeenScan(_SENSOR, scan.stamp_ns, kept, None, is_planar=is_planar)
                self._sweeps.append(sweep)
                self._mount = np.linalg.inv(scan.T_odom_base) @ scan.T_odom_sensor

    def findings(self) -> list[Finding]:
        """Return all current findings; log new ones with their remedies."""
        seen = self._observed()
        found = [*check_qos(seen), *check_tree(seen), *check_clocks(seen)]
        if self._scanner_found is None and len(seen.sweeps) >= _SWEEPS:
            self._scanner_found = [*check_unit(seen), *check_mount(seen)]
        found += self._scanner_found or ()
        if self._is_blind:
            found += check_returns(replace(seen, sweeps=(_EMPTY,)))
        is_settled = time.monotonic() - self._begun_s >= _DISCOVERY_S
        if is_settled:
            found += check_time(seen)
        found += self._unpublished(seen, is_settled)
        for finding in found:
            if (key := (finding.problem, finding.where)) not in self._logged:
                self._logged.add(key)
                said = printable(f'{finding.said}; next: {finding.next}')
                self._node.get_logger().warning(said)
        return found

    def _unpublished(self, seen: Observed, is_settled: bool) -> list[Finding]:
        """Return a finding for each unpublished input; it names topics of the same type."""
        self._published |= {topic.name for topic in seen.topics if topic.offers}
        missing = [
            topic.name
            for topic in seen.topics
            if topic.name in self._topics
            if not topic.offers and (is_settled or topic.name in self._published)
        ]
        if not missing:
            return []
        node = self._node
        others = [
            Topic(name, kind, _NO_STAMPS, _NO_STAMPS)
            for name, (kind, *_) in node.get_topic_names_and_types()
            if name not in self._topics and not name.startswith(node.get_fully_qualified_name())
            if node.count_publishers(name)
        ]
        return list(check_published(replace(seen, topics=(*seen.topics, *others)), missing))

    def _observed(self) -> Observed:
        with self._lock:
            sweeps, mount = tuple(self._sweeps), self._mount
        # Static transforms, and those received a short time ago.
        oldest_s, heard = time.monotonic() - _TF_MEMORY_S, list(self._transforms.values())
        transforms = [each for each, at_s in heard if each.is_static or at_s > oldest_s]
        if mount is not None and not np.array_equal(mount, np.eye(4)):
            transforms.append(Transform(_BASE, _SENSOR, mount, is_static=True))
        topics = tuple(self._topic(*each) for each in {**self._topics, **self._heard}.items())
        return Observed(
            0.0, topics, self._scans, transforms=tuple(transforms), sweeps=sweeps, is_live=True
        )

    def _topic(self, name: str, kind: str) -> Topic:
        node, stamps_ns = self._node, np.array(self._stamps, dtype=np.int64).reshape(-1, 2)
        own = [
            each
            for each in node.get_subscriptions_info_by_topic(name)
            if (each.node_namespace, each.node_name) == (node.get_namespace(), node.get_name())
        ]
        return Topic(
            name,
            kind,
            *(stamps_ns.T if name == self._scans else (_NO_STAMPS, _NO_STAMPS)),
            offers=offers_of(node.get_publishers_info_by_topic(name)),
            requests=offers_of(own),
        )

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


def offers_of(endpoints: Iterable[TopicEndpointInfo]) -> tuple[Offer, ...]:
    """Return QoS and node name of publishers or subscribers, without ``fpnet doctor``'s own."""
    return tuple(
        Offer(
            each.node_name,
            each.qos_profile.reliability is not QoSReliabilityPolicy.BEST_EFFORT,
            each.qos_profile.durability is QoSDurabilityPolicy.TRANSIENT_LOCAL,
        )
        for each in endpoints
        if each.node_name != DOCTOR
    )


def findings_to_msg(name: str, findings: Sequence[Finding]) -> Any:
    """Return a DiagnosticStatus with a node's findings and their remedies."""
    return named_status_to_msg(
        WARN if findings else OK,
        f'{name}: doctor',
        '; '.join(finding.said for finding in findings) or 'nothing is wrong',
        {finding.said: finding.next for finding in findings},
    )
