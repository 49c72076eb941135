# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How long ``fpnet --help`` takes, by the clock and in CPU time; the aim is 0.5 s.

Usage: python benchmarks/startup.py [--runs 10] [--json FILE]
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
import subprocess
import sys
import time

from fpnet_core.cli.common import write_json


def measure(runs: int) -> tuple[list[float], list[float]]:
    """Return wall-clock and CPU seconds of ``runs`` calls, after one that warms the disk."""
    wall_s, cpu_s = [], []
    for _ in range(runs + 1):
        before, started = os.times(), time.perf_counter()
        subprocess.run(
            [sys.executable, '-m', 'fpnet_core.cli', '--help'],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        wall_s.append(time.perf_counter() - started)
        after = os.times()
        user_s = after.children_user - before.children_user
        cpu_s.append(user_s + after.children_system - before.children_system)
    return wall_s[1:], cpu_s[1:]


def main() -> None:
    """Print the medians and write them if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--runs', type=int, default=10)
    parser.add_argument('--json', type=Path)
    arguments = parser.parse_args()
    wall_s, cpu_s = (sorted(times) for times in measure(arguments.runs))
    middle = arguments.runs // 2
    print(f'fpnet --help: {wall_s[middle]:.2f} s by the clock, {cpu_s[middle]:.2f} s of CPU')
    if arguments.json is not None:
        result = {'wall_s': wall_s[middle], 'cpu_s': cpu_s[middle], 'runs': arguments.runs}
        write_json(arguments.json, result)


if __name__ == '__main__':
    main()
