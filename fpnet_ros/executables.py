# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Entry points of ``ros2 run fpnet_ros`` and ``python -m fpnet_ros.executables NAME``."""

from __future__ import annotations

from functools import partial
from importlib import import_module
import signal
import sys


def run(module: str) -> int:
    """
    Import a node's module, run it and return the exit status.

    The imports take a second. During that time signals have their default action and end the
    process without a traceback; the node then installs its own handlers.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    return int(import_module(module).main())


localizer = partial(run, 'fpnet_ros.localizer')
odometry = partial(run, 'fpnet_ros.odometry')
floorplan_server = partial(run, 'fpnet_ros.floorplan_server')
seeder = partial(run, 'fpnet_ros.seeder')

if __name__ == '__main__':
    sys.exit(run(f'fpnet_ros.{sys.argv.pop(1)}'))
