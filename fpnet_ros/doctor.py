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
from fpnet_ros.optional_messages import TFMessage
from fpnet_ros.runtime import ODOMETRY_QUEUE, TF_STATIC, sensor_data

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
        node = Node(DOCTOR, context=context)
        listener = Listener(node)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        _spin(executor, _DISCOVERY_S)
        _spin(executor, _PATIENCE_S - _DISCOVERY_S, listener.sees_scans)
        listener.start(scans, odometry)
        _spin(executor, seconds)
        return listener.observed(seconds)
    finally:
        context.try_shutdown()


def _spin(
    executor: SingleThreadedExecutor, seconds: float, is_enough: Callable[[], bool] = lambda: False
) -> None:
    deadline = time.monotonic() + seconds
    while (left_s := deadline - time.monotonic()) > 0.0 and not is_enough():
        executor.spin_once(timeout_sec=min(left_s, _POLL_S))


class Listener:
    """
    Subscribes to the checked topics, with QoS that matches every publisher.

    Parameters
    ----------
    node
        Set to simulated time if ``/clock`` has a publisher, as the robot's nodes should be.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._observer = Observer({})

    def start(self, scans: str, odometry: str) -> None:
        """Subscribe; call it after discovery."""
        node = self._node
        types = self._types()
        if node.count_publishers(CLOCK_TOPIC):
            node.set_parameters([Parameter('use_sim_time', value=True)])
        subscribed = {name: kind for name, kind in types.items() if self._has_subscriber(name)}
        self._observer = Observer(
            types,
            scans or likeliest_scans(subscribed) or likeliest_scans(types),
            odometry or likeliest_odometry(subscribed) or likeliest_odometry(types) or None,
        )
        for name in self._observer.topics:
            depth = ODOMETRY_QUEUE if types[name] in (IMU, ODOMETRY) else _QUEUE
            qos = TF_STATIC if name.endswith(TF_STATIC_TOPIC) else sensor_data(depth)
            take = partial(self._take, name)
            if (kind := _KINDS.get(types[name])) is not None:  # None for TF without tf2_msgs
                node.create_subscription(kind, name, take, qos)

    def sees_scans(self) -> bool:
        """Return whether a topic of scans has a publisher."""
        return any(
            likeliest_scans({name: kind}) and self._node.count_publishers(name)
            for name, kind in self._types().items()
        )

    def observed(self, seconds: float) -> Observed:
        """Return everything received so far."""
        wanted = self._observer.wanted((ODOMETRY, GRID), (*self._observer.tf, CLOCK_TOPIC))
        offers = {n: offers_of(self._node.get_publishers_info_by_topic(n)) for n in wanted}
        subscribed = {n: offers_of(self._node.get_subscriptions_info_by_topic(n)) for n in wanted}
        return self._observer.observed(seconds, offers, subscribed, is_live=True)

    def _types(self) -> dict[str, str]:
        return {name: kinds[0] for name, kinds in self._node.get_topic_names_and_types()}

    def _has_subscriber(self, name: str) -> bool:
        return bool(offers_of(self._node.get_subscriptions_info_by_topic(name)))

    def _take(self, name: str, message: Any) -> None:
        self._observer.hear(name, self._node.get_clock().now().nanoseconds, message)
