# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Entry point of ``ros2 run fpnet_ros replay`` and ``python -m fpnet_lab.nodes``."""

from __future__ import annotations

import sys

from fpnet_ros.executables import run


def replay() -> int:
    """Run the replay of a recording and return the exit status."""
    return run('fpnet_lab.nodes.replay')


if __name__ == '__main__':
    sys.exit(replay())
