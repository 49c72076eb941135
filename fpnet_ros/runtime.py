# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How every node of this package starts, logs a fatal error, and ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import rclpy
from rclpy.exceptions import ROSInterruptException
from rclpy.executors import ExternalShutdownException
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSProfile,
    QoSReliabilityPolicy,
)

from fpnet_core.errors import FpnetError

AnyNode = TypeVar('AnyNode', bound=Node)

SCAN_QUEUE = 50
"""Scans that a subscription holds back: at 10 Hz five seconds of a busy processor."""

LATCHED = QoSProfile(
    history=QoSHistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=QoSReliabilityPolicy.RELIABLE,
    durability=QoSDurabilityPolicy.TRANSIENT_LOCAL,
)
"""As map_server: whoever subscribes later still gets the last message."""

SENSOR_DATA = QoSProfile(
    history=QoSHistoryPolicy.KEEP_LAST,
    depth=SCAN_QUEUE,
    reliability=QoSReliabilityPolicy.BEST_EFFORT,
    durability=QoSDurabilityPolicy.VOLATILE,
)
"""Matches every lidar driver; deeper than ROS's default, as lost scans harm odometry."""

STREAM = QoSProfile(
    history=QoSHistoryPolicy.KEEP_LAST,
    depth=SCAN_QUEUE,
    reliability=QoSReliabilityPolicy.RELIABLE,
    durability=QoSDurabilityPolicy.VOLATILE,
)
"""What this package publishes; subscriptions of either reliability match it."""

# Throttle of repeated errors: bad clouds come at sensor rate.
ERROR_PERIOD_S = 5.0


def run_node(
    make_node: Callable[[], AnyNode],
    arguments: Sequence[str] | None = None,
    run: Callable[[AnyNode], Any] = rclpy.spin,
) -> int:
    """
    Make a node, run it until it ends or is interrupted, and return the process's exit status.

    Bad input at the start (FpnetError, a malformed parameter file) is logged in one line and
    gives 1; SIGINT and SIGTERM end the node cleanly and give 0.
    """
    node: AnyNode | None = None
    try:
        rclpy.init(args=None if arguments is None else list(arguments))
        node = make_node()
        run(node)
    except (KeyboardInterrupt, ExternalShutdownException, ROSInterruptException):
        return 0
    except FpnetError as error:
        logger = get_logger('fpnet_ros') if node is None else node.get_logger()
        logger.fatal(' '.join(str(error).split()))
        return 1
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def log_throttled(node: Node, error: FpnetError) -> None:
    """Log bad input that was dropped: one line, and not at sensor rate."""
    node.get_logger().error(' '.join(str(error).split()), throttle_duration_sec=ERROR_PERIOD_S)
