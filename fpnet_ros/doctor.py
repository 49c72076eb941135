# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recording of the topics of a running robot for ``fpnet doctor``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import time
from typing import Any

from nav_msgs.msg import Odometry
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import Imu, LaserScan, MultiEchoLaserScan, PointCloud2

from fpnet_core.doctor import Observed
from fpnet_core.doctor.observer import Observer, likeliest_odometry, likeliest_scans
from fpnet_core.io.message_types import GRID, IMU, LASER_SCANS, ODOMETRY, POINT_CLOUD, TRANSFORMS
from fpnet_core.io.topic_names import CLOCK_TOPIC, TF_STATIC_TOPIC
from fpnet_ros.checkup import DOCTOR, offers_of
from fpnet_ros.runtime import ODOMETRY_QUEUE, TF_STATIC, TFMessage, sensor_data

_DISCOVERY_S, _PATIENCE_S = 2.0, 8.0  # for discovery; for the first topic of scans; chosen
_POLL_S = 0.1  # numerical
_QUEUE = 10  # scans; chosen
_KINDS = {
    POINT_CLOUD: PointCloud2,
    **dict(zip(LASER_SCANS, (LaserScan, MultiEchoLaserScan), strict=True)),
    ODOMETRY: Odometry,
    IMU: Imu,
    TRANSFORMS: TFMessage,
}


def listen(seconds: float, scans: str = '', odometry: str = '') -> Observed:
    """Return recorded scans, odometry and TF; empty names: the topics with subscribers."""
    context = rclpy.Context()
    rclpy.init(context=context)
    try:
        listener = _Listener(Node(DOCTOR, context=context))
        listener.spin(_DISCOVERY_S)
        listener.spin(_PATIENCE_S - _DISCOVERY_S, listener.sees_scans)
        listener.start(scans, odometry)
        listener.spin(seconds)
        return listener.observed(seconds)
    finally:
        context.try_shutdown()


class _Listener:
    """Subscribes to the checked topics of a robot, with QoS that matches every publisher."""

    def __init__(self, node: Node) -> None:
        self._node, self._observer = node, Observer({})
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)

    def spin(self, seconds: float, is_enough: Callable[[], bool] = lambda: False) -> None:
        """Handle messages for some time, or until it is enough."""
        deadline = time.monotonic() + seconds
        while (left_s := deadline - time.monotonic()) > 0.0 and not is_enough():
            self._executor.spin_once(timeout_sec=min(left_s, _POLL_S))

    def start(self, scans: str, odometry: str) -> None:
        """Subscribe, in simulated time if ``/clock`` has a publisher; call it after discovery."""
        node, types = self._node, self._types()
        if node.count_publishers(CLOCK_TOPIC):
            node.set_parameters([Parameter('use_sim_time', value=True)])
        has_subscriber = lambda name: offers_of(node.get_subscriptions_info_by_topic(name))  # noqa: E731
        subscribed = {name: kind for name, kind in types.items() if has_subscriber(name)}
        self._observer = Observer(
            types,
            scans or likeliest_scans(subscribed) or likeliest_scans(types),
            odometry or likeliest_odometry(subscribed) or likeliest_odometry(types) or None,
        )
        for name in self._observer.topics:
            depth = ODOMETRY_QUEUE if types[name] in (IMU, ODOMETRY) else _QUEUE
            qos = TF_STATIC if name.endswith(TF_STATIC_TOPIC) else sensor_data(depth)
            if (kind := _KINDS.get(types[name])) is not None:  # None for TF without tf2_msgs
                node.create_subscription(kind, name, partial(self._take, name), qos)

    def sees_scans(self) -> bool:
        """Return whether a topic of scans has a publisher."""
        return any(
            likeliest_scans({name: kind}) and self._node.count_publishers(name)
            for name, kind in self._types().items()
        )

    def observed(self, seconds: float) -> Observed:
        """Return everything received so far."""
        node, observer = self._node, self._observer
        wanted = observer.wanted((ODOMETRY, GRID), (*observer.tf, CLOCK_TOPIC))
        offers = {n: offers_of(node.get_publishers_info_by_topic(n)) for n in wanted}
        requests = {n: offers_of(node.get_subscriptions_info_by_topic(n)) for n in wanted}
        return observer.observed(seconds, offers, requests, is_live=True)

    def _types(self) -> dict[str, str]:
        return {name: kinds[0] for name, kinds in self._node.get_topic_names_and_types()}

    def _take(self, name: str, message: Any) -> None:
        self._observer.hear(name, self._node.get_clock().now().nanoseconds, message)
