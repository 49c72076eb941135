# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs of the localizer on a recording, and the registered scans for other methods and plans."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig, OdometryConfig, SubmapConfig
from fpnet_core.io.scans import Scan
from fpnet_core.localizer import ReplayResult, create_localizer, replay
from fpnet_core.odometry import KissOdometry
from fpnet_core.pose import PreparedMap
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import GridMap, LocalizerOutput, Status, Submap
from fpnet_lab.baselines.monte_carlo import planar_slice
from fpnet_lab.evaluation.localization.records import MethodRun, UpdateEstimate

KEEP_EVERY = 3
"""Stride of the registered scans kept for other plans: a scan each 0.2 m. Chosen."""

_KB_PER_MB = 1024.0  # given


def registered(scans: Iterable[Scan], config: OdometryConfig) -> Iterator[Scan]:
    """Yield the scans deskewed and with poses; KISS-ICP registers those without a pose."""
    odometry = KissOdometry(config)
    for scan in scans:
        points, pose = scan.points, scan.T_odom_sensor
        if pose is None:
            sweep = odometry.register_scan(scan)
            points, pose = sweep.points, sweep.T_odom_sensor
        yield Scan(scan.stamp_ns, points, T_odom_sensor=pose)


def kept_scans(scans: Iterable[Scan], config: OdometryConfig) -> list[Scan]:
    """Return one in :data:`KEEP_EVERY` registered scans."""
    return list(islice(registered(scans, config), 0, None, KEEP_EVERY))


def submap_of(scans: Iterable[Scan], config: SubmapConfig | None = None) -> Submap:
    """Return the submap of registered scans, at least one."""
    builder = SubmapBuilder(config)
    for scan in scans:
        assert scan.T_odom_sensor is not None, 'the scan is registered'
        builder.add_scan(scan.points, scan.T_odom_sensor, scan.stamp_ns)
    submap = builder.take()
    assert submap is not None, 'a scan has returns'
    return submap


@dataclass(eq=False)
class Registrar:
    """
    Registers scans and stores the data that later runs share.

    ``kept`` are registered scans, one in :data:`KEEP_EVERY`; ``slices`` the planar slice of every
    scan in the levelled sensor frame [m].
    """

    config: OdometryConfig
    kept: list[Scan] = field(default_factory=list)
    slices: list[NDArray[np.float32]] = field(default_factory=list)

    def follow(self, scans: Iterable[Scan]) -> Iterator[Scan]:
        """Yield the registered scans."""
        for number, scan in enumerate(registered(scans, self.config)):
            assert scan.T_odom_sensor is not None, 'the scan is registered'
            self.slices.append(planar_slice(scan.points, scan.T_odom_sensor))
            if number % KEEP_EVERY == 0:
                self.kept.append(scan)
            yield scan


@dataclass(frozen=True, eq=False)
class ProductRun:
    """Run of the localizer as for any method, with its prepared plan and all outputs."""

    run: MethodRun
    replay: ReplayResult
    plan: PreparedMap

    @property
    def updates(self) -> tuple[LocalizerOutput, ...]:
        """Outputs of the updates that had a submap and a match, in time order."""
        return tuple(
            o for o in self.replay.outputs if o.submap is not None and o.match is not None
        )


def run_product(
    scans: Iterable[Scan],
    plan: GridMap,
    config: FpnetConfig,
    update_period_s: float,
    scale: ScaleEstimate | None = None,
) -> ProductRun:
    """
    Run the localizer over registered scans, with updates in sensor time.

    ``scale`` is the prior of a drawing whose scale is unknown.

    Raises
    ------
    FpnetError
        If the plan has no room or the weights cannot be used.
    """
    localizer = create_localizer(config)
    localizer.set_plan(plan, scale)
    rss_mb = [0.0]
    result = replay(
        scans, localizer, update_period_s, on_scan=lambda: rss_mb.append(resident_mb())
    )
    assert localizer.plan is not None  # set above
    run = MethodRun(
        published=result.published,
        odometry=result.odometry,
        beliefs=tuple(_best_estimate(output) for output in result.outputs),
        tick_ms=result.tick_ms,
        add_scan_ms=result.add_scan_ms,
        rss_mb=max(rss_mb),
        statuses=tuple(output.status.value for output in result.outputs),
        covariances=result.covariances,
    )
    return ProductRun(run, result, localizer.plan)


def resident_mb() -> float:
    """Return the resident memory of this process [MB]; 0 if the system does not report it."""
    try:
        lines = Path('/proc/self/status').read_text(encoding='ascii').splitlines()
    except OSError:
        return 0.0
    values = [line.split()[1] for line in lines if line.startswith('VmRSS:')]
    return float(values[0]) / _KB_PER_MB if values else 0.0


def _best_estimate(output: LocalizerOutput) -> UpdateEstimate:
    if output.status is Status.LOCALIZED:
        return UpdateEstimate(output.stamp_ns, output.probability, output.A_plan_odom)
    if not output.estimates or output.submap is None:
        return UpdateEstimate(output.stamp_ns, output.probability, None)
    placed = output.estimates[0].A_plan_submap @ output.submap.T_odom_submap.inv()
    return UpdateEstimate(output.stamp_ns, output.probability, placed)
