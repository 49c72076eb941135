# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Entry points of ``ros2 run fpnet_ros`` and ``python -m fpnet_ros.executables NAME``."""

from __future__ import annotations

from importlib import import_module
import signal
import sys


def localizer() -> int:
    """Run the localizer and return the exit status."""
    return _run('localizer')


def odometry() -> int:
    """Run the odometry and return the exit status."""
    return _run('odometry')


def floorplan_server() -> int:
    """Run the floorplan server and return the exit status."""
    return _run('floorplan_server')


def replay() -> int:
    """Run the replay of a recording and return the exit status."""
    return _run('replay')


def seeder() -> int:
    """Run the seeder of another localizer and return the exit status."""
    return _run('seeder')


def _run(name: str) -> int:
    """
    Import a node's module and run it.

    The imports take a second. During that time signals have their default action and end the
    process without a traceback; the node then installs its own handlers.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    return int(import_module(f'fpnet_ros.{name}').main())


if __name__ == '__main__':
    sys.exit(_run(sys.argv.pop(1)))
