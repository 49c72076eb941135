# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The robot's side of Nav2's bond: a heartbeat by which a lifecycle manager sees who is alive."""

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
    Says on ``bond`` that a node is active, as long as it is.

    The protocol of bondcpp, as far as the watched side needs it: the manager holds the bond by
    what it hears from here, whatever it says itself. Nobody listens, as every node of Nav2 and its
    manager speak ten times a second on that one topic.

    Parameters
    ----------
    node
        Its name is that of the bond, as in the manager's ``node_names``.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(BondStatus, 'bond', STREAM)
        self._instance = ''
        self._timer: Any = None

    def form(self) -> None:
        """Begin a new bond."""
        self._instance = str(uuid4())
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # a paused simulation is alive
        self._timer = self._node.create_timer(_PERIOD_S, self._beat, clock=steady)
        self._beat()

    def dissolve(self) -> None:
        """End it in good order, where there is one: the manager need not wait for its death."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
            if self._node.context.ok():  # else nobody can be told any more
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
