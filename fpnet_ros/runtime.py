# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Start, logging and shutdown of every node of this package."""

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
"""Queue depth of the publishers and subscriptions of this package. Chosen."""

ODOMETRY_QUEUE = 100
"""
Queue depth: wheel odometry at 100 Hz for one second; older poses would be too late. Chosen.
"""


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


def sensor_data(depth: int) -> QoSProfile:
    """
    Return a profile that matches every lidar driver.

    Messages also wait in this queue while a node is busy: the depth bounds their delay.
    """
    return _profile(depth, QoSReliabilityPolicy.BEST_EFFORT)


STREAM = _profile(STREAM_QUEUE)
"""Profile of publishers; subscriptions of either reliability match it."""

TF = _profile(100)
"""Given: as tf2_ros for ``/tf``."""

TF_STATIC = _profile(100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Given: as tf2_ros for ``/tf_static``."""

_SWITCH_S = 0.001
"""
Interval of thread switches. With Python's default of 5 ms the executor's thread, which needs the
interpreter only briefly, would wait that long at every switch during an update. Chosen.
"""

STALE_INPUT_S = 3.0
"""Numerical: an input silent for longer is missing; sensors publish ten times a second."""

_QUIET_S = 60.0  # chosen: the next loss after this time without one is logged

ERROR_PERIOD_S = 5.0
"""Least time between two log lines about the same kind of bad input. Chosen."""


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
    Raises KeyboardInterrupt at the first SIGINT or SIGTERM only.

    If ``is_over``, not even at the first. Outside the main thread it leaves signals unchanged.
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
        """Ignore SIGINT and SIGTERM from now on, while the state is saved."""
        self.is_over = True
        self._handle(signal.SIG_IGN)

    def _handle(self, handler: Any) -> None:
        if threading.current_thread() is threading.main_thread():
            for number in self._NUMBERS:
                signal.signal(number, handler)


class _ToRos(logging.Handler):
    """Forwards log records of the core to the ROS logger, so that they reach /rosout too."""

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
    if is_writable(wanted):
        return ''
    os.environ['ROS_LOG_DIR'] = kept = tempfile.mkdtemp(prefix='fpnet_log_')
    return f'{wanted} is not writable: log files are in {kept}; set ROS_LOG_DIR to keep them'


class ErrorLog:
    """
    Logs bad input that was dropped: one line per kind of error and period, not at sensor rate.

    Errors whose messages differ only in numbers are of one kind.

    Parameters
    ----------
    log
        Logs a line.
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
    """Return a function that logs errors of a node: bad input rate-limited, defects always."""
    errors = ErrorLog(node.get_logger().error)

    def report(error: BaseException) -> None:
        if isinstance(error, FpnetError):
            errors.report(error)
        elif node.context.ok():  # otherwise the node is shutting down, which is no defect
            node.get_logger().error(described(error))

    return report


class StatusLog:
    """
    Logs each change of the localizer's status once, as a warning if it needs attention.

    Parameters
    ----------
    info, warn
        Log a line.
    """

    def __init__(self, info: Callable[[str], Any], warn: Callable[[str], Any]) -> None:
        self._info, self._warn = info, warn
        self._last: tuple[Status, bool] | None = None

    def tell(self, report: LocalizerReport) -> None:
        """Log the report of an update unless the last one had the same status."""
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
    Logs once when an input stops or never starts, and once when it is back.

    Parameters
    ----------
    info, warn
        Log a line.
    """

    def __init__(self, info: Callable[[str], Any], warn: Callable[[str], Any]) -> None:
        self._info, self._warn = info, warn
        self._silent: set[str] = set()

    def follow(self, ages_s: Mapping[str, float], limit_s: float) -> bool:
        """Check the age of each topic's last message [s]; return whether a line was logged."""
        before = set(self._silent)
        for topic, age_s in ages_s.items():
            if age_s > limit_s and topic not in self._silent:
                self._silent.add(topic)
                self._warn(f'no message on {topic} for {age_s:.0f} s: is it published?')
            elif age_s <= limit_s and topic in self._silent:
                self._silent.remove(topic)
                self._info(f'{topic} is received again')
        return self._silent != before


class LossLog:
    """
    Logs each reason for lost scans once, and again after a minute without losses.

    Parameters
    ----------
    warn
        Logs a line.
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
        Return the reasons for scans lost since the last call, and log new ones.

        Parameters
        ----------
        counts
            Scans lost so far, by reason.
        remedies
            Advice by reason; reasons without any are logged elsewhere.
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
    Logs each distinct failure once, until success is reported.

    Parameters
    ----------
    tell
        Logs a failure.
    """

    def __init__(self, tell: Callable[[Any], Any]) -> None:
        self._tell = tell
        self._logged: set[str] = set()

    def tell(self, what: Any, way: str = '') -> None:
        """Log the first of several failures of the same kind ``way``."""
        if way not in self._logged:
            self._logged.add(way)
            self._tell(what)

    def clear(self, way: str | None = None) -> None:
        """Report success, for one kind of failure or for all."""
        self._logged -= self._logged.copy() if way is None else {way}


def one_line(error: BaseException) -> str:
    """Return the message of an error without line breaks and control characters."""
    return printable(' '.join(str(error).split()))


def described(error: BaseException) -> str:
    """Return an error in one line; that of a defect has type, location and cause."""
    if isinstance(error, FpnetError):
        return one_line(error)
    where = traceback.extract_tb(error.__traceback__)[-1:]
    place = ''.join(f' in {Path(at.filename).name}:{at.lineno} ({at.name})' for at in where)
    before = error.__cause__ or error.__context__
    cause = '' if before is None else f'; caused by: {_typed(before)}'
    return f'internal error, please report it: {_typed(error)}{place}{cause}'


def _typed(error: BaseException) -> str:
    return f'{type(error).__name__}: {one_line(error)}'
