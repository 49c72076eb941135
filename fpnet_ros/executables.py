# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What ``ros2 run fpnet_ros`` starts; ``python -m fpnet_ros.executables NAME`` does the same."""

from __future__ import annotations

from importlib import import_module
import signal
import sys


def localizer() -> int:
    """Run the localizer; returns the exit status."""
    return _run('localizer')


def odometry() -> int:
    """Run the odometry; returns the exit status."""
    return _run('odometry')


def floorplan_server() -> int:
    """Run the floorplan server; returns the exit status."""
    return _run('floorplan_server')


def replay() -> int:
    """Run the replay of a recording; returns the exit status."""
    return _run('replay')


def _run(name: str) -> int:
    """
    Import a node's module and run it.

    The imports take a second. A signal ends the process there as it does any other program's, and
    not in Python's traceback; the node has handlers of its own from its first line on.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    return int(import_module(f'fpnet_ros.{name}').main())


if __name__ == '__main__':
    sys.exit(_run(sys.argv.pop(1)))
