# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How every node of this package starts, logs a fatal error, and ends."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
import logging
import math
import os
from pathlib import Path
import re
import signal
import sys
import tempfile
import threading
import time
import traceback
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
from fpnet_core.kernel_cache import is_writable
from fpnet_core.printable import printable
from fpnet_core.types import Status
from fpnet_ros.known_parameters import refuse_unknown
from msg_adapters.diagnostics import LocalizerReport

AnyNode = TypeVar('AnyNode', bound=Node)

STREAM_QUEUE = 50
"""Messages that a publisher or subscription of this package holds back. Chosen."""

ODOMETRY_QUEUE = 100
"""
Wheels report at 100 Hz: a second of a busy processor. Older poses would come too late. Chosen.
"""


def _profile(
    depth: int,
    reliability: QoSReliabilityPolicy = QoSReliabilityPolicy.RELIABLE,
    durability: QoSDurabilityPolicy = QoSDurabilityPolicy.VOLATILE,
) -> QoSProfile:
    history = QoSHistoryPolicy.KEEP_LAST
    return QoSProfile(history=history, depth=depth, reliability=reliability, durability=durability)


LATCHED = _profile(1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Given: as map_server: whoever subscribes later still gets the last message."""

STATUS = _profile(10, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Like ``LATCHED`` for a topic that changes: a late joiner sees what was said last. Chosen."""


def sensor_data(depth: int) -> QoSProfile:
    """
    Return what matches every lidar driver.

    What a node cannot take in time waits here too: the depth bounds how late it may be.
    """
    return _profile(depth, QoSReliabilityPolicy.BEST_EFFORT)


STREAM = _profile(STREAM_QUEUE)
"""What this package publishes; subscriptions of either reliability match it."""

TF = _profile(100)
"""Given: as tf2_ros for ``/tf``."""

TF_STATIC = _profile(100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Given: as tf2_ros for ``/tf_static``."""

_SWITCH_S = 0.001
"""
Threads take turns this often. By Python's default of 5 ms, the executor's thread, which needs the
interpreter for moments only, would wait that long at every turn while a tick computes. Chosen.
"""

STALE_INPUT_S = 3.0
"""Numerical: an input silent for longer is missing; sensors report ten times a second."""

_QUIET_S = 60.0  # chosen: without a loss for so long the next one is news

ERROR_PERIOD_S = 5.0
"""Time between two lines about the same kind of bad input. Chosen."""


def run_node(
    make_node: Callable[[], AnyNode],
    arguments: Sequence[str] | None = None,
    run: Callable[[AnyNode], Any] = rclpy.spin,
) -> int:
    """
    Make a node, run it until it ends or is interrupted, and return the process's exit status.

    Bad input at the start (FpnetError, a malformed parameter file, an unknown parameter) is
    logged in one line and gives 1; SIGINT and SIGTERM end the node cleanly and give 0. More of
    them, as a launch file and a terminal send both, do not interrupt the end.
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
            # The signal arrived within a callback, whose publishers were gone from then on.
            if rclpy.ok():
                raise
        interrupts.is_over = True
    except KeyboardInterrupt:  # the only one, be it as late as in what is above
        pass
    finally:
        interrupts.ignore()
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return status


class _Interrupts:
    """
    Raises KeyboardInterrupt at the first SIGINT or SIGTERM, and at no other.

    ``is_over``: nor at the first one. In threads but the main one it leaves signals as they are.
    """

    _NUMBERS = signal.SIGINT, signal.SIGTERM

    def __init__(self) -> None:
        self.is_over = False
        self._handle(self._interrupt)

    def _interrupt(self, *_: object) -> None:
        if not self.is_over:
            self.is_over = True
            raise KeyboardInterrupt

    def ignore(self) -> None:
        """Let nothing but SIGKILL interrupt what follows: the state is saved there."""
        self.is_over = True
        self._handle(signal.SIG_IGN)

    def _handle(self, handler: Any) -> None:
        if threading.current_thread() is threading.main_thread():
            for number in self._NUMBERS:
                signal.signal(number, handler)


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
    log_dir = _keep_logs_where_possible()
    try:
        rclpy.init(args=None if arguments is None else list(arguments))
    except RuntimeError as error:
        # rcl raises its own child for unreadable parameter files and malformed --ros-args.
        raise ConfigError(f'{error}; check the arguments after --ros-args') from None
    logging.basicConfig(level=logging.INFO, handlers=[_ToRos()])
    for said in (log_dir, kernel_cache.SAID):
        if said:
            get_logger('fpnet_ros').warning(said)
    sys.setswitchinterval(_SWITCH_S)
    keep_freed_memory()


def _keep_logs_where_possible() -> str:
    """Move log files that ROS cannot write, which would end the node; returns what to say."""
    home = Path(os.environ.get('ROS_HOME') or Path.home() / '.ros')
    wanted = Path(os.environ.get('ROS_LOG_DIR') or home / 'log')
    if is_writable(wanted):
        return ''
    os.environ['ROS_LOG_DIR'] = kept = tempfile.mkdtemp(prefix='fpnet_log_')
    return f'{wanted} is not writable: log files are in {kept}; set ROS_LOG_DIR to keep them'


class ErrorLog:
    """
    Logs bad input that was dropped: one line per kind of error and period, not at sensor rate.

    Errors that say the same but for the figures in it are of one kind.

    Parameters
    ----------
    log
        Takes the line.
    clock
        Returns seconds.
    """

    def __init__(
        self, log: Callable[[str], Any], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._log = log
        self._clock = clock
        self._logged_s: dict[str, float] = {}
        self._withheld: Counter[str] = Counter()

    def report(self, error: FpnetError) -> None:
        """Log ``error`` unless one of its kind was logged within ``ERROR_PERIOD_S``."""
        kind, now_s = re.sub(r'\d+', '', one_line(error)), self._clock()
        if now_s - self._logged_s.get(kind, -math.inf) < ERROR_PERIOD_S:
            self._withheld[kind] += 1
            return
        self._logged_s[kind] = now_s
        withheld = self._withheld.pop(kind, 0)
        suffix = f' ({withheld} more since the last report)' if withheld else ''
        self._log(one_line(error) + suffix)


def error_reporter(node: Node) -> Callable[[BaseException], None]:
    """Return what logs a node's errors: bad input now and then, a defect whenever it shows."""
    errors = ErrorLog(node.get_logger().error)

    def report(error: BaseException) -> None:
        if isinstance(error, FpnetError):
            errors.report(error)
        elif node.context.ok():  # else the publishers were gone, which is no defect
            node.get_logger().error(described(error))

    return report


class StatusLog:
    """
    Logs what the localizer says whenever its status changes, once: trouble as a warning.

    Parameters
    ----------
    info, warn
        Take the line.
    """

    def __init__(self, info: Callable[[str], Any], warn: Callable[[str], Any]) -> None:
        self._info, self._warn = info, warn
        self._last: tuple[Status, bool] | None = None

    def tell(self, report: LocalizerReport) -> None:
        """Log a tick's report unless the last one had the same status."""
        status = report.status, report.is_mirrored
        if status == self._last:
            return
        self._last = status
        if report.is_trouble:
            self._warn(report.said)
        else:
            self._info(report.said)


class SilenceLog:
    """
    Logs an input that has fallen silent, or never was heard, and when it is back: once each.

    Parameters
    ----------
    info, warn
        Take the line.
    """

    def __init__(self, info: Callable[[str], Any], warn: Callable[[str], Any]) -> None:
        self._info, self._warn = info, warn
        self._silent: set[str] = set()

    def follow(self, ages_s: Mapping[str, float], limit_s: float) -> bool:
        """Take for how long nothing has come on each topic [s]; True where there is news."""
        before = set(self._silent)
        for topic, age_s in ages_s.items():
            if age_s > limit_s and topic not in self._silent:
                self._silent.add(topic)
                self._warn(f'nothing on {topic} for {age_s:.0f} s: does anybody publish it?')
            elif age_s <= limit_s and topic in self._silent:
                self._silent.remove(topic)
                self._info(f'{topic} is heard again')
        return self._silent != before


class LossLog:
    """
    Logs what scans are lost by, once each, and again after none was for a minute.

    Parameters
    ----------
    warn
        Takes the line.
    clock
        Returns seconds.
    """

    def __init__(
        self, warn: Callable[[str], Any], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._warn, self._clock = warn, clock
        self._counts: dict[str, int] = {}
        self._lost_s: dict[str, float] = {}

    def follow(self, counts: Mapping[str, int], remedies: Mapping[str, str]) -> list[str]:
        """
        Return by what scans were lost since the last call.

        Parameters
        ----------
        counts
            Scans so far, by what they were lost by.
        remedies
            What to do about it; what has none is logged elsewhere.
        """
        news = [what for what, count in counts.items() if count > self._counts.get(what, 0)]
        self._counts, now_s = dict(counts), self._clock()
        for what in news:
            if now_s - self._lost_s.get(what, -math.inf) > _QUIET_S and what in remedies:
                self._warn(f'{what}; {remedies[what]}')
            self._lost_s[what] = now_s
        return news


class Once:
    """
    Tells that something fails, once for each way in which it does, until it has succeeded again.

    Parameters
    ----------
    tell
        Takes what there is to say.
    """

    def __init__(self, tell: Callable[[Any], Any]) -> None:
        self._tell = tell
        self._told: set[str] = set()

    def tell(self, what: Any, way: str = '') -> None:
        """Tell the first of several failures."""
        if way not in self._told:
            self._told.add(way)
            self._tell(what)

    def clear(self, way: str | None = None) -> None:
        """Say that it has succeeded, in one way, or at all."""
        self._told -= self._told.copy() if way is None else {way}


def one_line(error: BaseException) -> str:
    """Return the message of an error without line breaks and control characters."""
    return printable(' '.join(str(error).split()))


def described(error: BaseException) -> str:
    """Return an error in one line: bad input as it says, a defect with type, place and cause."""
    if isinstance(error, FpnetError):
        return one_line(error)
    where = traceback.extract_tb(error.__traceback__)[-1:]
    place = ''.join(f' in {Path(at.filename).name}:{at.lineno} ({at.name})' for at in where)
    before = error.__cause__ or error.__context__
    cause = '' if before is None else f'; before that: {_typed(before)}'
    return f'internal error, please report it: {_typed(error)}{place}{cause}'


def _typed(error: BaseException) -> str:
    return f'{type(error).__name__}: {one_line(error)}'
