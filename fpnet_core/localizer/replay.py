# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Replay of recorded scans through a localizer, in sensor time and without ROS."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
import logging
import math
import re
import time

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.io.scans import RegisteredSweep, Scan
from fpnet_core.localizer.kept import KeptOutputs, KeptPoses
from fpnet_core.localizer.localizer import Localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput

_log = logging.getLogger(__name__)

Register = Callable[[Scan], RegisteredSweep]
"""Converts a scan to deskewed points with their sensor pose."""


@dataclass(frozen=True, eq=False)
class ReplayResult:
    """
    Results of a run, in time order.

    ``outputs`` are those of all updates, as in :class:`fpnet_core.localizer.kept.KeptOutputs`.
    ``published`` contains every published pose, plan frame, nominal metres, with the sensor's
    stamps, and ``covariances (S, 3, 3)`` those of their x, y [m] and yaw [rad]; ``odometry`` the
    sensor's path in ``odom``. ``storeys`` names the storey of each published pose.
    """

    outputs: tuple[LocalizerOutput, ...]
    published: PlanarTrajectory
    covariances: NDArray[np.float64]
    odometry: PlanarTrajectory
    add_scan_ms: NDArray[np.float64]
    rejected_scans: int
    storeys: tuple[str, ...] = ()

    @property
    def tick_ms(self) -> NDArray[np.float64]:
        """Durations of the updates that had a submap [ms]."""
        totals = [o.timings_ms['total'] for o in self.outputs if 'total' in o.timings_ms]
        return np.array(totals, dtype=np.float64)


def replay(
    scans: Iterable[Scan],
    localizer: Localizer,
    update_period_s: float,
    register: Register | None = None,
    on_scan: Callable[[], None] = lambda: None,
) -> ReplayResult:
    """
    Feed all scans to the localizer and return the run; see :class:`Replay`.

    Raises
    ------
    FpnetError
        The last one, if every scan was rejected.
    """
    run = Replay(scans, localizer, update_period_s, register, on_scan)
    for _ in run:
        pass
    return run.result()


class Replay:
    """
    Run over recorded scans that advances as its outputs are consumed.

    Iterating feeds scans to the localizer, updates it at its period of sensor time and yields the
    output of each update; one more update follows the last scan, so that the last status covers
    all scans. A pose is published after every scan while the status is LOCALIZED.

    Parameters
    ----------
    scans : in time order; those without ``T_odom_sensor`` go through ``register``
    localizer : with its plan set
    update_period_s : sensor time between two updates
    register : odometry for scans without a pose; None if all have one
    on_scan : called after each scan, for progress bars
    registers_all : ``register`` also gets scans with poses, e.g. as an initial guess
    map_bytes : memory for maps, see :class:`fpnet_core.localizer.kept.KeptOutputs`

    Raises
    ------
    FpnetError
        While iterating: the last one, if every scan was rejected.
    """

    def __init__(
        self,
        scans: Iterable[Scan],
        localizer: Localizer,
        update_period_s: float,
        register: Register | None,
        on_scan: Callable[[], None] = lambda: None,
        registers_all: bool = False,
        map_bytes: float = math.inf,
    ) -> None:
        self._registers_all = registers_all
        self._run = _Run(localizer, int(update_period_s * NS_PER_S), KeptOutputs(map_bytes))
        self._outputs = self._follow(scans, register, on_scan)

    def __iter__(self) -> Iterator[LocalizerOutput]:
        """Return the iterator itself: a second loop continues where the first one stopped."""
        return self._outputs

    def result(self) -> ReplayResult:
        """Return the results so far."""
        return self._run.result()

    def _registered(self, scan: Scan, register: Register | None) -> RegisteredSweep:
        if register is not None and (self._registers_all or scan.T_odom_sensor is None):
            return register(scan)
        assert scan.T_odom_sensor is not None, 'without an odometry every scan has a pose'
        return RegisteredSweep(scan.points, scan.T_odom_sensor, scan.viewpoints)

    def _follow(
        self, scans: Iterable[Scan], register: Register | None, on_scan: Callable[[], None]
    ) -> Iterator[LocalizerOutput]:
        run, refusal = self._run, None
        for scan in scans:
            try:
                ticked = run.take(scan.stamp_ns, self._registered(scan, register))
            except FpnetError as error:
                run.refuse(error)
                refusal, ticked = error, False
            on_scan()
            if ticked:
                yield run.outputs.newest[-1]
        if refusal is not None and not len(run.path):
            raise refusal
        run.tell_of_refused()
        if run.finish():
            yield run.outputs.newest[-1]


@dataclass(eq=False)
class _Run:
    """State of a run: scans go in, updates follow their stamps."""

    localizer: Localizer
    period_ns: int
    outputs: KeptOutputs
    published: KeptPoses = field(default_factory=KeptPoses)
    covariances: array[float] = field(default_factory=lambda: array('d'))
    storeys: list[str] = field(default_factory=list)
    path: KeptPoses = field(default_factory=KeptPoses)
    add_ms: array[float] = field(default_factory=lambda: array('d'))
    refused: Counter[str] = field(default_factory=Counter)
    next_update_ns: int | None = None

    def take(self, stamp_ns: int, sweep: RegisteredSweep) -> bool:
        """Add a scan and return whether an update followed."""
        start = time.perf_counter()
        self.localizer.add_scan(sweep.points, sweep.T_odom_sensor, stamp_ns, sweep.viewpoints)
        self.add_ms.append(1e3 * (time.perf_counter() - start))
        self.path.append(stamp_ns, SE2.from_matrix4(sweep.T_odom_sensor))
        if self.next_update_ns is None or stamp_ns < self.next_update_ns - 2 * self.period_ns:
            self.next_update_ns = stamp_ns + self.period_ns
        if is_due := stamp_ns >= self.next_update_ns:
            self.update(stamp_ns)
            self.next_update_ns = stamp_ns + self.period_ns
        output = self.localizer.output
        pose = output.pose(sweep.T_odom_sensor)
        cov = output.covariance_at(sweep.T_odom_sensor, stamp_ns)
        if pose is not None and cov is not None:
            self.published.append(stamp_ns, pose)
            self.covariances.extend(cov.flat)
            self.storeys.append(output.storey)
        return is_due

    def refuse(self, error: FpnetError) -> None:
        """Count a rejected scan and log the first one per reason, ignoring digits."""
        kind = re.sub(r'\d+', '', str(error))
        if kind not in self.refused:
            _log.warning('%s', error)
        self.refused[kind] += 1

    def tell_of_refused(self) -> None:
        if (refused := self.refused.total()) > len(self.refused):
            _log.warning('%d of %d scans were rejected', refused, refused + len(self.path))

    def update(self, stamp_ns: int) -> None:
        self.outputs.append(self.localizer.update(stamp_ns))
        _log_change(self.outputs.newest, self.path.first_ns)

    def finish(self) -> bool:
        """Update once more if there are scans after the last update; return whether there were."""
        if not len(self.path):
            return False
        is_late = all(o.stamp_ns < self.path.last_ns for o in self.outputs.newest[-1:])
        if is_late:
            self.update(self.path.last_ns)
        return is_late

    def result(self) -> ReplayResult:
        return ReplayResult(
            self.outputs.all(),
            self.published.trajectory(),
            np.array(self.covariances).reshape(-1, 3, 3),
            self.path.trajectory(),
            np.array(self.add_ms),
            self.refused.total(),
            tuple(self.storeys),
        )


def _log_change(outputs: Sequence[LocalizerOutput], start_ns: int) -> None:
    """Log the last output if its status differs from the one before."""
    last = outputs[-1]
    if len(outputs) < 2 or outputs[-2].status is not last.status:
        _log.info('%.1f s: %s', (last.stamp_ns - start_ns) / NS_PER_S, last.said)
