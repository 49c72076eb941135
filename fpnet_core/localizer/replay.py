# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drive a localizer with recorded scans, as the node would, in sensor time and without ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
import logging
import time

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.io import Scan
from fpnet_core.io.scans import RegisteredSweep
from fpnet_core.localizer.localizer import Localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput

_log = logging.getLogger(__name__)

Register = Callable[[Scan], RegisteredSweep]
"""Turns a scan into deskewed points where they were seen."""


@dataclass(frozen=True, eq=False)
class ReplayResult:
    """
    Everything a run produced, in time order.

    ``published`` holds every pose given out, plan frame, nominal metres, with the sensor's
    stamps; ``odometry`` the sensor's path in ``odom``.
    """

    outputs: tuple[LocalizerOutput, ...]
    published: PlanarTrajectory
    odometry: PlanarTrajectory
    add_scan_ms: NDArray[np.float64]
    rejected_scans: int

    @property
    def tick_ms(self) -> NDArray[np.float64]:
        """Durations of the ticks that had a submap to work on [ms]."""
        totals = [o.timings_ms['total'] for o in self.outputs if 'total' in o.timings_ms]
        return np.array(totals, dtype=np.float64)


def replay(
    scans: Iterable[Scan],
    localizer: Localizer,
    tick_period_s: float,
    register: Register,
    on_scan: Callable[[], None] = lambda: None,
    registers_all: bool = False,
) -> ReplayResult:
    """
    Feed scans to the localizer and tick it on its period of sensor time.

    Parameters
    ----------
    scans : in time order; those without ``T_odom_sensor`` go through ``register``
    localizer : with its plan set
    tick_period_s : sensor time between two ticks
    register : odometry for scans that bring none
    on_scan : called after each scan, for progress bars
    registers_all : scans with poses go through ``register``, too, which may take them as a guess

    Returns
    -------
    The run; one more tick follows the last scan, so that the last status says all. A pose
    is published after every scan while the status is LOCALIZED.

    Raises
    ------
    FpnetError
        The last one, if every scan was refused.
    """
    run = _Run(localizer, int(tick_period_s * NS_PER_S))
    refusal: FpnetError | None = None
    for scan in scans:
        try:
            run.take(scan.stamp_ns, _registered(scan, register, registers_all))
        except FpnetError as error:
            _log.warning('%s', error)
            run.rejected, refusal = run.rejected + 1, error
        on_scan()
    if refusal is not None and not run.path:
        raise refusal
    return run.result()


@dataclass(eq=False)
class _Run:
    """A run so far: scans go in, ticks follow their stamps."""

    localizer: Localizer
    period_ns: int
    outputs: list[LocalizerOutput] = field(default_factory=list)
    published: list[tuple[int, SE2]] = field(default_factory=list)
    path: list[tuple[int, SE2]] = field(default_factory=list)
    add_ms: list[float] = field(default_factory=list)
    rejected: int = 0
    next_tick_ns: int | None = None

    def take(self, stamp_ns: int, sweep: RegisteredSweep) -> None:
        start = time.perf_counter()
        self.localizer.add_scan(sweep.points, sweep.T_odom_sensor, stamp_ns, sweep.viewpoints)
        self.add_ms.append(1e3 * (time.perf_counter() - start))
        self.path.append((stamp_ns, SE2.from_matrix4(sweep.T_odom_sensor)))
        if self.next_tick_ns is None or stamp_ns < self.next_tick_ns - 2 * self.period_ns:
            self.next_tick_ns = stamp_ns + self.period_ns
        if stamp_ns >= self.next_tick_ns:
            self.tick(stamp_ns)
            self.next_tick_ns = stamp_ns + self.period_ns
        pose = self.localizer.output.pose(sweep.T_odom_sensor)
        if pose is not None:
            self.published.append((stamp_ns, pose))

    def tick(self, stamp_ns: int) -> None:
        self.outputs.append(self.localizer.tick(stamp_ns))
        _log_change(self.outputs, self.path[0][0])

    def result(self) -> ReplayResult:
        """Tick once more where the last scan was not the last tick's."""
        if self.path and (not self.outputs or self.outputs[-1].stamp_ns < self.path[-1][0]):
            self.tick(self.path[-1][0])
        return ReplayResult(
            tuple(self.outputs),
            _trajectory(self.published),
            _trajectory(self.path),
            np.array(self.add_ms),
            self.rejected,
        )


def _log_change(outputs: list[LocalizerOutput], start_ns: int) -> None:
    """Log the last of the outputs where its status is another than the one's before it."""
    last = outputs[-1]
    if len(outputs) < 2 or outputs[-2].status is not last.status:
        _log.info('%.1f s: %s', (last.stamp_ns - start_ns) / NS_PER_S, last.said)


def _trajectory(poses: list[tuple[int, SE2]]) -> PlanarTrajectory:
    return PlanarTrajectory(
        np.array([stamp for stamp, _ in poses], dtype=np.int64),
        np.array([T.translation for _, T in poses]).reshape(-1, 2),
        np.array([T.yaw for _, T in poses]),
    )


def _registered(scan: Scan, register: Register, always: bool) -> RegisteredSweep:
    if always or scan.T_odom_sensor is None:
        return register(scan)
    return RegisteredSweep(scan.points, scan.T_odom_sensor, scan.viewpoints)
