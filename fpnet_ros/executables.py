# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Entry points of ``ros2 run fpnet_ros`` and ``python -m fpnet_ros.executables NAME``."""

from __future__ import annotations

from functools import partial
from importlib import import_module
import signal
import sys


def run(name: str) -> int:
    """
    Import a node's module, run it and return the exit status.

    The imports take a second. During that time signals have their default action and end the
    process without a traceback; the node then installs its own handlers.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    return int(import_module(f'fpnet_ros.{name}').main())


localizer = partial(run, 'localizer')
odometry = partial(run, 'odometry')
floorplan_server = partial(run, 'floorplan_server')
replay = partial(run, 'replay')

if __name__ == '__main__':
    sys.exit(run(sys.argv.pop(1)))
