# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drive a localizer with recorded scans, as the node would, in sensor time and without ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
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
"""Turns a scan without pose into deskewed points where they were seen."""


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

    Returns
    -------
    The run; one more tick follows the last scan, so that the last status says all. A pose
    is published after every scan while the status is LOCALIZED.
    """
    outputs: list[LocalizerOutput] = []
    published: list[tuple[int, SE2]] = []
    path: list[tuple[int, SE2]] = []
    add_ms: list[float] = []
    rejected, next_tick_ns = 0, None
    period_ns = int(tick_period_s * NS_PER_S)
    for scan in scans:
        sweep = _registered(scan, register)
        T_odom_sensor = sweep.T_odom_sensor
        start = time.perf_counter()
        try:
            localizer.add_scan(sweep.points, T_odom_sensor, scan.stamp_ns, sweep.viewpoints)
        except FpnetError as error:
            _log.warning('%s', error)
            rejected += 1
        else:
            add_ms.append(1e3 * (time.perf_counter() - start))
            path.append((scan.stamp_ns, SE2.from_matrix4(T_odom_sensor)))
            if next_tick_ns is None or scan.stamp_ns < next_tick_ns - 2 * period_ns:
                next_tick_ns = scan.stamp_ns + period_ns
            if scan.stamp_ns >= next_tick_ns:
                outputs.append(localizer.tick(scan.stamp_ns))
                _log_change(outputs, path[0][0])
                next_tick_ns = scan.stamp_ns + period_ns
            pose = localizer.output.pose(T_odom_sensor)
            if pose is not None:
                published.append((scan.stamp_ns, pose))
        on_scan()
    if path and (not outputs or outputs[-1].stamp_ns < path[-1][0]):
        outputs.append(localizer.tick(path[-1][0]))
        _log_change(outputs, path[0][0])
    return ReplayResult(
        tuple(outputs), _trajectory(published), _trajectory(path), np.array(add_ms), rejected
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


def _registered(scan: Scan, register: Register) -> RegisteredSweep:
    if scan.T_odom_sensor is None:
        return register(scan)
    return RegisteredSweep(scan.points, scan.T_odom_sensor, scan.viewpoints)
