# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Duration figures, and functions that measure wall and processor time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import os
from pathlib import Path
import subprocess
import sys
import time
from typing import Any, TypeVar

import numpy as np

from fpnet.cli.exits import NO_ANSWER
from fpnet_core.errors import FpnetError
from fpnet_lab.scores import Score, Unit, Units

REPEATS = 5
"""Numerical: timed calls per median."""

_UNIT = Units.SECONDS.to(4)  # numerical: digits

Clocked = tuple[float, float]
"""Wall time and processor time [s]."""

Result = TypeVar('Result')


@dataclass(frozen=True, kw_only=True)
class Figure(Score):
    """
    A wall time [s] and its upper limit as aim; None: no aim.

    ``cpu_s`` is the processor time of all threads, which other load on the machine affects less.
    ``of`` is the number of calls of the median or quantile.
    """

    unit: Unit = _UNIT
    cpu_s: float
    of: int = REPEATS

    def as_json(self) -> dict[str, Any]:
        """Return the figure as an entry of a report."""
        return {
            'seconds': round(self.value, 5),
            'cpu_s': round(self.cpu_s, 5),
            'aim_s': self.aim,
            'of': self.of,
        }


def median_of(
    name: str, aim_s: float | None, calls: Sequence[Callable[[], object]], repeats: int = REPEATS
) -> Figure:
    """
    Return the median over ``calls`` of each one's median time.

    Each call runs once before, untimed, for compilation and loading.
    """
    times = np.array([_medians(call, repeats) for call in calls])
    wall_s, cpu_s = np.median(times, axis=0)
    return Figure(name, float(wall_s), aim_s, cpu_s=float(cpu_s), of=repeats * len(calls))


def _medians(call: Callable[[], object], repeats: int) -> Clocked:
    call()
    times = np.array([clocked(call)[1] for _ in range(repeats)])
    wall_s, cpu_s = np.median(times, axis=0)
    return float(wall_s), float(cpu_s)


def clocked(call: Callable[[], Result]) -> tuple[Result, Clocked]:
    """Return the result of a call, and its duration."""
    start, cpu = time.perf_counter(), time.process_time()
    result = call()
    return result, (time.perf_counter() - start, time.process_time() - cpu)


def quantile_of(name: str, aim_s: float | None, times: Sequence[Clocked], share: float) -> Figure:
    """Return a quantile of given times."""
    wall_s, cpu_s = np.quantile(np.array(times), share, axis=0)
    return Figure(name, float(wall_s), aim_s, cpu_s=float(cpu_s), of=len(times))


def shell_figure(name: str, aim_s: float, arguments: Sequence[str], cwd: Path) -> Figure:
    """
    Return the duration of an ``fpnet`` command from the shell, the median of five.

    Raises
    ------
    FpnetError
        If the command fails.
    """
    times = [_shell(arguments, cwd) for _ in range(1 + REPEATS)][1:]
    wall_s, cpu_s = np.median(np.array(times), axis=0)
    return Figure(name, float(wall_s), aim_s, cpu_s=float(cpu_s))


def _shell(arguments: Sequence[str], cwd: Path) -> Clocked:
    before, start = os.times(), time.perf_counter()
    done = subprocess.run(  # noqa: S603 - our own arguments
        [sys.executable, '-m', 'fpnet', *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )
    wall_s, after = time.perf_counter() - start, os.times()
    if done.returncode not in (0, NO_ANSWER):
        raise FpnetError(f'fpnet {" ".join(arguments)} failed: {done.stderr.strip()[-300:]}')
    user_s = after.children_user - before.children_user
    return wall_s, user_s + after.children_system - before.children_system
