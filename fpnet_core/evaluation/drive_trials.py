# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Calibration trials from drives: what a robot's first half minute says of its plan and of others.

The buildings, sensors and inaccurate plans are those of the localization benchmark, of another
seed. Every look of a drive, from the first corner of a room on, is a chance to be wrongly sure,
and another building by the same architect is the plan that tempts most.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from fpnet_core.config import FpnetConfig
from fpnet_core.evaluation.calibration import Trial
from fpnet_core.evaluation.localization.cases import Case, plain_cases
from fpnet_core.evaluation.localization.drives import Drive, ProductRun, run_product
from fpnet_core.evaluation.localization.records import RIGHT, Truth, robot_error
from fpnet_core.evaluation.localization.runs import (
    OPEN_SET_TICK_PERIOD_S,
    TICK_PERIOD_S,
    settings_of,
)
from fpnet_core.evaluation.localization.scenes import make_plan, make_scene
from fpnet_core.io import Scan
from fpnet_core.odometry import KissOdometry
from fpnet_core.pose import map_evidence
from fpnet_core.types import LocalizerOutput

DRIVE_S = 30.0
"""Later ticks mostly repeat what the earlier ones found."""

WRONG_PLANS = 3
"""So many other buildings' plans are tried on each drive, the first one of its own family."""

_GROWTH = 1.1
"""A tick becomes a trial when the walls have grown by this factor since the last one."""

_NS_PER_S = 10**9


def drive_trials(
    seed: int,
    count: int,
    config: FpnetConfig,
    on_drive: Callable[[int], None] = lambda count: None,
) -> list[Trial]:
    """Return the trials of ``count`` generated drives, at most those of all plain cases."""
    plain = plain_cases(seed)
    trials: list[Trial] = []
    for case in plain[:count]:
        others = [plain[number] for number in case.wrong_cases[:WRONG_PLANS]]
        trials += _of_drive(case, others, settings_of(case, config))
        on_drive(1)
    return trials


def _of_drive(case: Case, others: Iterable[Case], config: FpnetConfig) -> Iterator[Trial]:
    scene = make_scene(case, Path())
    drive = Drive(KissOdometry(config.odometry))
    scans = drive.follow(_beginning(scene.scans))
    own = run_product(scans, scene.plan, config, TICK_PERIOD_S)
    yield from _of_run(own, Truth(scene.truth, scene.A_plan_truth))
    for other in others:
        foreign = run_product(drive.kept, make_plan(other), config, OPEN_SET_TICK_PERIOD_S)
        yield from _of_run(foreign, None)


def _beginning(scans: Iterable[Scan]) -> Iterator[Scan]:
    """Yield the scans of the first :data:`DRIVE_S`."""
    end_ns = None
    for scan in scans:
        end_ns = end_ns or scan.stamp_ns + int(DRIVE_S * _NS_PER_S)
        if scan.stamp_ns > end_ns:
            return
        yield scan


def _of_run(product: ProductRun, truth: Truth | None) -> Iterator[Trial]:
    """Yield the ticks that saw more than the one before; no truth marks another's plan."""
    seen_m = 0.0
    for output in product.ticks:
        assert output.submap is not None  # ticks have one
        walls_m = map_evidence(output.submap.grid).wall_length_m
        if not output.estimates or walls_m < _GROWTH * seen_m:
            continue
        seen_m = walls_m
        yield Trial(
            scores=output.estimates.score,
            wall_length_m=walls_m,
            truth=None if truth is None else _right_estimate(output, product, truth),
            is_foreign=truth is None,
        )


def _right_estimate(output: LocalizerOutput, product: ProductRun, truth: Truth) -> int | None:
    """Return the index of the first estimate that puts the robot where it is."""
    assert output.submap is not None  # ticks have one
    A_submap_odom = output.submap.T_odom_submap.inv()
    for index, estimate in enumerate(output.estimates):
        A_plan_odom = estimate.A_plan_submap @ A_submap_odom
        error = robot_error(output.stamp_ns, A_plan_odom, product.replay.odometry, truth)
        if error[0] <= RIGHT[0] and error[1] <= RIGHT[1]:
            return index
    return None
