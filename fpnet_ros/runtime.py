# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""QoS profiles, optional message types, start and shutdown of every node of this package."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
import logging
import os
from pathlib import Path
import signal
import sys
import tempfile
import threading
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

from fpnet_core import kernel_cache
from fpnet_core.errors import ConfigError, FpnetError
from fpnet_core.freed_memory import keep_freed_memory
from fpnet_ros.logs import one_line
from fpnet_ros.params import refuse_unknown

AnyNode = TypeVar('AnyNode', bound=Node)

ODOMETRY_QUEUE = 100
"""Chosen: wheel odometry at 100 Hz for one second; older poses would be too late."""


def _profile(
    depth: int,
    reliability: QoSReliabilityPolicy = QoSReliabilityPolicy.RELIABLE,
    durability: QoSDurabilityPolicy = QoSDurabilityPolicy.VOLATILE,
) -> QoSProfile:
    history = QoSHistoryPolicy.KEEP_LAST
    return QoSProfile(history=history, depth=depth, reliability=reliability, durability=durability)


LATCHED = _profile(1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Given: as map_server; late subscribers get the last message."""

STATUS = _profile(10, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Like ``LATCHED``, with a longer queue for a topic that changes. Chosen."""

STREAM = _profile(50)
"""Profile of publishers; subscriptions of either reliability match it. Depth: chosen."""

TF = _profile(100)
"""Given: as tf2_ros for ``/tf``."""

TF_STATIC = _profile(100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Given: as tf2_ros for ``/tf_static``."""


def sensor_data(depth: int) -> QoSProfile:
    """
    Return a profile that matches every lidar driver.

    Messages also wait in this queue while a node is busy: the depth bounds their delay.
    """
    return _profile(depth, QoSReliabilityPolicy.BEST_EFFORT)


def _optional(module: str, name: str) -> Any:
    try:
        return getattr(import_module(module), name)
    except ImportError:
        return None


TFMessage = _optional('tf2_msgs.msg', 'TFMessage')  # in no wheel; see docs/install.md
BondStatus = _optional('bond.msg', 'Status')
SetInitialPose = _optional('nav2_msgs.srv', 'SetInitialPose')
Localize = _optional('fpnet_msgs.action', 'Localize')

_SETUP = 'or run make setup with a C++ compiler'

NO_TF = f'tf2_msgs is not installed; install ROS 2, {_SETUP}'
NO_BOND = (
    f'no bond to a lifecycle manager: bond is not installed; install ros-jazzy-bond, {_SETUP}, or '
    "set the manager's bond_timeout to 0.0"
)
NO_SERVICE = (
    f'no ~/set_initial_pose: nav2_msgs is not installed; install ros-jazzy-nav2-msgs, {_SETUP}'
)
NO_ACTION = f'no ~/localize: fpnet_msgs is not installed; build interfaces/fpnet_msgs, {_SETUP}'

_SWITCH_S = 0.001
"""
Interval of thread switches. With Python's default of 5 ms the executor's thread, which needs the
interpreter only briefly, would wait that long at every switch during an update. Chosen.
"""


def run_node(
    make_node: Callable[[], AnyNode],
    arguments: Sequence[str] | None = None,
    run: Callable[[AnyNode], Any] = rclpy.spin,
) -> int:
    """
    Create a node, run it until it ends or is interrupted, and return the process's exit status.

    Bad input at the start (FpnetError, a malformed parameter file, an unknown parameter) is
    logged in one line and gives 1; SIGINT and SIGTERM end the node cleanly and give 0. Further
    signals do not interrupt the shutdown: a launch file and a terminal may both send one.
    """
    interrupts = _Interrupts()
    node: AnyNode | None = None
    status = 0
    try:
        try:
            _enter_ros(arguments)
            node = make_node()
            refuse_unknown(node)
            run(node)
        except ExternalShutdownException:
            pass
        except FpnetError as error:
            logger = get_logger('fpnet_ros') if node is None else node.get_logger()
            logger.fatal(one_line(error))
            status = 1
        except RuntimeError:
            # A signal shut the context down during a callback, so that publishing failed.
            if rclpy.ok():
                raise
        interrupts.is_over = True
    except KeyboardInterrupt:  # raised at most once, perhaps in the handlers above
        pass
    finally:
        interrupts.ignore()
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return status


class _Interrupts:
    """
    Raises KeyboardInterrupt at the first SIGINT or SIGTERM only; if ``is_over``, at none.

    Outside the main thread it leaves signals unchanged.
    """

    def __init__(self) -> None:
        self.is_over = False
        self._handle(self._interrupt)

    def _interrupt(self, *_: object) -> None:
        if not self.is_over:
            self.is_over = True
            raise KeyboardInterrupt

    def ignore(self) -> None:
        """Ignore SIGINT and SIGTERM from now on, while the state is saved."""
        self.is_over = True
        self._handle(signal.SIG_IGN)

    def _handle(self, handler: Any) -> None:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, handler)


class _ToRos(logging.Handler):
    """Forwards log records of the core to the ROS logger, so that they reach /rosout too."""

    def emit(self, record: logging.LogRecord) -> None:
        """Log one record at its level."""
        logger, message = get_logger(record.name), record.getMessage()
        # One line for each level: rclpy allows only one at a line of code.
        if record.levelno >= logging.ERROR:
            logger.error(message)
        elif record.levelno >= logging.WARNING:
            logger.warning(message)
        else:
            logger.info(message)


def _enter_ros(arguments: Sequence[str] | None) -> None:
    log_dir = _keep_logs_where_possible()
    try:
        rclpy.init(args=None if arguments is None else list(arguments))
    except RuntimeError as error:
        # rcl raises a subclass of it for unreadable parameter files and malformed --ros-args.
        raise ConfigError(f'{error}; check the arguments after --ros-args') from None
    logging.basicConfig(level=logging.INFO, handlers=[_ToRos()])
    for said in (log_dir, kernel_cache.SAID):
        if said:
            get_logger('fpnet_ros').warning(said)
    sys.setswitchinterval(_SWITCH_S)
    keep_freed_memory()


def _keep_logs_where_possible() -> str:
    """Move log files that ROS cannot write, which would end the node; return a warning."""
    home = Path(os.environ.get('ROS_HOME') or Path.home() / '.ros')
    wanted = Path(os.environ.get('ROS_LOG_DIR') or home / 'log')
    if kernel_cache.is_writable(wanted):
        return ''
    os.environ['ROS_LOG_DIR'] = kept = tempfile.mkdtemp(prefix='fpnet_log_')
    return f'{wanted} is not writable: log files are in {kept}; set ROS_LOG_DIR to keep them'
