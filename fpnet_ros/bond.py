# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Heartbeat of a managed node on ``bond``, as Nav2's lifecycle manager expects it."""

from __future__ import annotations

from typing import Any
from uuid import uuid4

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from fpnet_ros.optional_messages import BondStatus
from fpnet_ros.runtime import STREAM
from msg_adapters.stamps import header_to_msg

# Given: Nav2's own.
_PERIOD_S, _TIMEOUT_S = 0.25, 4.0


class Bond:
    """
    Publishes on ``bond`` while a node is active.

    This is the watched side of bondcpp's protocol: the manager keeps the bond as long as it
    receives this heartbeat. The class does not subscribe, because every node of Nav2 and its
    manager publish ten times a second on that one topic.

    Parameters
    ----------
    node
        The node; its name is the bond's, as in the manager's ``node_names``.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(BondStatus, 'bond', STREAM)
        self._instance = ''
        self._timer: Any = None

    def form(self) -> None:
        """Start a new bond."""
        self._instance = str(uuid4())
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # simulated time may be paused
        self._timer = self._node.create_timer(_PERIOD_S, self._beat, clock=steady)
        self._beat()

    def dissolve(self) -> None:
        """End the bond, if any, so that the manager does not wait for its timeout."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
            if self._node.context.ok():  # otherwise publishing would fail
                self._beat()

    def _beat(self) -> None:
        self._publisher.publish(
            BondStatus(
                header=header_to_msg(self._node.get_clock().now().nanoseconds, ''),
                id=self._node.get_name(),
                instance_id=self._instance,
                active=self._timer is not None,
                heartbeat_timeout=_TIMEOUT_S,
                heartbeat_period=_PERIOD_S,
            )
        )
