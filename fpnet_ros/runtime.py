# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How every node of this package starts, logs a fatal error, and ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import logging
from typing import Any, TypeVar

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSProfile,
    QoSReliabilityPolicy,
)

from fpnet_core.errors import ConfigError, FpnetError

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

STATUS = QoSProfile(
    history=QoSHistoryPolicy.KEEP_LAST,
    depth=10,
    reliability=QoSReliabilityPolicy.RELIABLE,
    durability=QoSDurabilityPolicy.TRANSIENT_LOCAL,
)
"""Like ``LATCHED`` for a topic that changes: a late joiner sees what was said last."""

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
        _enter_ros(arguments)
        node = make_node()
        run(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    except FpnetError as error:
        logger = get_logger('fpnet_ros') if node is None else node.get_logger()
        logger.fatal(' '.join(str(error).split()))
        return 1
    except RuntimeError:
        if rclpy.ok():
            raise
        # The signal arrived within a callback, whose publishers were gone from then on.
        return 0
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


class _ToRos(logging.Handler):
    """Hands what the core logs to the ROS logger, so that it reaches /rosout too."""

    def emit(self, record: logging.LogRecord) -> None:
        """Log one record at its level."""
        logger = get_logger(record.name)
        message = record.getMessage()
        if record.levelno >= logging.ERROR:
            logger.error(message)
        elif record.levelno >= logging.WARNING:
            logger.warning(message)
        else:
            logger.info(message)


def _enter_ros(arguments: Sequence[str] | None) -> None:
    try:
        rclpy.init(args=None if arguments is None else list(arguments))
    except RuntimeError as error:
        # rcl raises its own child for unreadable parameter files and malformed --ros-args.
        raise ConfigError(f'{error}; check the arguments after --ros-args') from None
    logging.basicConfig(level=logging.INFO, handlers=[_ToRos()])


def log_throttled(node: Node, error: FpnetError) -> None:
    """Log bad input that was dropped: one line, and not at sensor rate."""
    node.get_logger().error(' '.join(str(error).split()), throttle_duration_sec=ERROR_PERIOD_S)
