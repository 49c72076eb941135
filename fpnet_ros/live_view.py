# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publisher and subscriber of ``fpnet view --nodes``."""

from __future__ import annotations

from array import array
from collections import deque
from collections.abc import Iterator
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import UInt8MultiArray

from fpnet_core.errors import ConfigError, FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.io.serialization import ShownPlan, ShownTick, packed, unpacked
from fpnet_core.localizer.localizer import Snapshot
from fpnet_core.localizer.map_frame import Located
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput, Segmentation
from fpnet_ros.inputs import LocatedScan
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.runtime import LATCHED, STATUS, STREAM
from msg_adapters.diagnostics import report_from_msg

_PLAN, _TICK, _STATUS = 'view_plan', 'view_tick', 'status'
_REMEMBERED = 100  # numerical: scans between two updates; a lidar sends ten a second
_POLL_S, _PATIENCE_S = 0.1, 10.0  # numerical; chosen: wait before the line below is shown
_NONE_FOUND = (
    'no localizer node found yet; it must be running and active, with the same ROS_DOMAIN_ID'
)


class ViewTopics:
    """Publishers of ``~/view_plan`` and ``~/view_tick`` of one configured localizer node."""

    def __init__(self, node: ManagedNode) -> None:
        self._node = node
        self._plans = node.add_publisher(UInt8MultiArray, f'~/{_PLAN}', LATCHED)
        self._updates = node.add_publisher(UInt8MultiArray, f'~/{_TICK}', STREAM)
        self._number = 0
        self._rooms: Segmentation | None = None
        self._shown: LocalizerOutput | None = None
        self._scans: deque[LocatedScan] = deque(maxlen=_REMEMBERED)
        self._poses: deque[tuple[int, SE2]] = deque(maxlen=_REMEMBERED)

    def saw(self, scan: LocatedScan | None, located: Located | None) -> None:
        """Keep a scan and its pose on the floorplan; ``located`` is None unless localized."""
        if scan is not None:
            self._scans.append(scan)
            if located is not None:
                self._poses.append((scan.stamp_ns, located.T_plan_base))

    def show(self, snapshot: Snapshot) -> None:
        """Publish an update that is new, after its plan if that is new."""
        plan, output = snapshot.plan, snapshot.output
        is_heard = self._node.is_active and self._updates.get_subscription_count()
        if plan is None or output is self._shown or not is_heard:
            return
        self._shown = output
        if plan.nominal.segmentation is not self._rooms:
            self._number, self._rooms = self._number + 1, plan.nominal.segmentation
            self._plans.publish(_to_msg(ShownPlan(self._number, plan.name, self._rooms)))
        update = ShownTick(self._number, output, self._base_at(output), self._poses_since())
        self._updates.publish(_to_msg(update))

    def _base_at(self, output: LocalizerOutput) -> SE2 | None:
        if output.submap is None:
            return None
        found = [s for s in list(self._scans) if s.stamp_ns == output.submap.stamp_ns]
        return SE2.from_matrix4(found[-1].T_odom_base) if found else None

    def _poses_since(self) -> PlanarTrajectory:
        new = {}  # by stamp, as an update may publish the pose of a scan again
        while self._poses:
            stamp_ns, pose = self._poses.popleft()
            new[stamp_ns] = (pose.x, pose.y, pose.yaw)
        stamps_ns = sorted(new)
        values = np.array([new[stamp_ns] for stamp_ns in stamps_ns]).reshape(-1, 3)
        return PlanarTrajectory(np.array(stamps_ns, np.int64), values[:, :2], values[:, 2])


def watch(namespace: str = '') -> Iterator[ShownPlan | ShownTick | str]:
    """
    Yield plans, updates and text lines of a running localizer until it ends.

    An empty ``namespace`` selects the only running localizer.

    Raises
    ------
    ConfigError
        If several localizers run and ``namespace`` does not select one.
    FpnetError
        If the localizer has another version.
    """
    context = rclpy.Context()
    rclpy.init(context=context)
    try:
        yield from _Watcher(Node('fpnet_view', context=context), namespace).events()
    finally:
        context.try_shutdown()


class _Watcher:
    """Subscriber to the first localizer that it discovers."""

    def __init__(self, node: Node, namespace: str) -> None:
        self._node, self._namespace = node, namespace.strip('/')
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)
        self._heard: deque[ShownPlan | ShownTick | str] = deque()

    def events(self) -> Iterator[ShownPlan | ShownTick | str]:
        """Yield plans, updates and text lines."""
        started, is_shown = time.monotonic(), False
        while not (localizer := self._found()):
            self._executor.spin_once(timeout_sec=_POLL_S)
            if not is_shown and time.monotonic() - started > _PATIENCE_S:
                is_shown = True
                yield _NONE_FOUND
        self._listen(localizer)
        yield f'listening to {localizer}'
        while self._node.count_publishers(f'{localizer}/{_TICK}'):
            self._executor.spin_once(timeout_sec=_POLL_S)
            while self._heard:
                yield self._heard.popleft()

    def _found(self) -> str:
        """Return the localizer's full name; empty while there is none."""
        names = [
            name.removesuffix(f'/{_TICK}')
            for name, _ in self._node.get_topic_names_and_types()
            if name.endswith(f'/{_TICK}') and self._node.count_publishers(name)
        ]
        if self._namespace:
            names = [name for name in names if name.startswith(f'/{self._namespace}/')]
        if len(names) > 1:
            raise ConfigError(
                f'several localizers run: {", ".join(sorted(names))}; choose one with --namespace'
            )
        return ''.join(names)

    def _listen(self, localizer: str) -> None:
        for name, kind, qos in ((_PLAN, ShownPlan, LATCHED), (_TICK, ShownTick, STREAM)):
            self._subscribe(f'{localizer}/{name}', kind, qos)
        self._node.create_subscription(
            DiagnosticStatus, f'{localizer}/{_STATUS}', self._on_status, STATUS
        )

    def _subscribe(self, topic: str, kind: type[Any], qos: Any) -> None:
        def take(msg: UInt8MultiArray) -> None:
            self._heard.append(unpacked(kind, bytes(msg.data)))

        self._node.create_subscription(UInt8MultiArray, topic, take, qos)

    def _on_status(self, msg: DiagnosticStatus) -> None:
        try:
            report = report_from_msg(msg)
        except ValueError as error:
            raise FpnetError(f'{error}; both sides need the same version of fpnet') from None
        self._heard.append('; '.join(filter(None, (report.said, report.warning))))


def _to_msg(value: ShownPlan | ShownTick) -> UInt8MultiArray:
    return UInt8MultiArray(data=array('B', packed(value)))
