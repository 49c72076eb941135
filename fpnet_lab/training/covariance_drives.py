# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Published poses of recordings with their covariance features and their errors.

Buildings, tours and odometry are those of the localization benchmark with other seeds. Each
recording is registered once and run on three drawings: the case's own, a rough one, and a rough
one that is also stretched, sketched or changed. Errors are relative to the best affine fit of a
drawing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet.accuracy import WRONG_POSITION_M, WRONG_YAW_RAD
from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import wrap_to_pi
from fpnet_core.pose.uncertainty import FIGURES
from fpnet_core.stamps import NS_PER_S
from fpnet_lab.evaluation.localization.cases import Case, Distortion, plain_cases
from fpnet_lab.evaluation.localization.drives import ProductRun, kept_scans, run_product
from fpnet_lab.evaluation.localization.inputs import CaseInputs, make_inputs, make_rough_plan
from fpnet_lab.evaluation.localization.records import Truth
from fpnet_lab.evaluation.localization.runs import UPDATE_PERIOD_S, settings_of
from fpnet_lab.kept import make_once
from fpnet_lab.sim.drawn.distort import DrawnPlan
from fpnet_lab.training.gathering import Columns

Array = NDArray[np.float64]

# Chosen: registering the sweeps of sensors with more beams takes five times as long, and their
# odometry noise differs little.
_SENSORS = ('planar', 'beams16', 'planar', 'planar', 'beams16')
_ROUGHER = (Distortion.STRETCHED_5, Distortion.SKETCH, Distortion.CHANGED_WALLS)


@dataclass(frozen=True, eq=False)
class Samples(Columns):
    """
    ``N`` published poses.

    Parameters
    ----------
    figures, information : (N, F), (N, 3, 3)
        The :class:`fpnet_core.pose_covariance.PoseFeatures` of the update behind each pose.
    away : (N, 2)
        Displacement of the robot since that update, plan axes [m].
    age_s : (N,)
        Time since the newest scan of that update.
    error : (N, 3)
        Error in x, y [m] and yaw [rad] of the plan.
    run, building : (N,) int64
        Number of the run (a recording on a drawing), and of the building.
    """

    figures: Array
    information: Array
    away: Array
    age_s: Array
    error: Array
    run: NDArray[np.int64]
    building: NDArray[np.int64]

    def numbered(self) -> Samples:
        """Return the samples with run numbers that are unique over all buildings."""
        keys = np.column_stack([self.building, self.run])
        return replace(self, run=np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1))


def gather_samples(
    folder: Path,
    seed: int,
    drives: int,
    config: FpnetConfig,
    on_drive: Callable[[float], None] = lambda count: None,
) -> Samples:
    """Return the samples of a seed's recordings; results in ``folder`` are reused."""
    tasks = {f'{seed}-{number:03d}': number for number in range(drives)}
    make = partial(_drive_samples, seed, config)
    made = make_once(folder, Samples, tasks, make, on_done=on_drive, columns=FIGURES)
    return Samples.joined(made).numbered()


def _drive_samples(seed: int, config: FpnetConfig, number: int) -> Samples:
    """Return the samples of one recording on its three drawings."""
    plain = plain_cases(seed)
    case = replace(plain[number % len(plain)], sensor=_SENSORS[number % len(_SENSORS)])
    if case.distortion is Distortion.UNKNOWN_SCALE:  # its nominal metres are not true ones
        case = replace(case, distortion=Distortion.EXACT, group=Distortion.EXACT)
    inputs = make_inputs(case, Path())
    scans = kept_scans(inputs.scans, config.odometry)
    runs = []
    for run, (drawn, settings) in enumerate(_drawings(case, inputs, config)):
        product = run_product(scans, drawn.grid, settings, UPDATE_PERIOD_S)
        truth = Truth(inputs.truth, drawn.A_plan_building)
        runs.append(_samples_of(product, truth, run, number))
    return Samples.joined(runs).numbered()


def _drawings(
    case: Case, inputs: CaseInputs, config: FpnetConfig
) -> Iterator[tuple[DrawnPlan, FpnetConfig]]:
    """Yield a recording's drawings with the user settings for their scales."""
    yield DrawnPlan(inputs.plan, inputs.A_plan_truth), settings_of(case, config)
    yield make_rough_plan(case), config
    yield make_rough_plan(case, _ROUGHER[case.seed % len(_ROUGHER)]), config


def _samples_of(product: ProductRun, truth: Truth, run: int, building: int) -> Samples:
    """Return the samples of a run, without wrong poses and poses without truth."""
    published, odometry = product.run.published, product.run.odometry
    true, known = truth.poses.mapped(truth.A_plan_truth).at(published.stamps_ns)
    turned = wrap_to_pi(published.yaw - true.yaw)
    error = np.column_stack([published.xy - true.xy, turned])
    far = np.hypot(error[:, 0], error[:, 1]) > WRONG_POSITION_M
    kept = np.flatnonzero(known & ~far & (np.abs(turned) <= WRONG_YAW_RAD))
    claims = [output for output in product.replay.outputs if output.covariance is not None]
    stamps = np.array([output.stamp_ns for output in claims], dtype=np.int64)
    at = odometry.at(published.stamps_ns)[0].xy
    spreads, away = [], []
    for k in kept.tolist():
        output = claims[int(np.searchsorted(stamps, published.stamps_ns[k], 'right')) - 1]
        assert output.covariance is not None
        assert output.A_plan_odom is not None
        spreads.append(output.covariance)
        away.append(output.A_plan_odom.linear @ (at[k] - output.covariance.xy_odom))
    ticks_ns = np.array([covariance.stamp_ns for covariance in spreads], dtype=np.int64)
    return Samples(
        np.array([covariance.features.figures for covariance in spreads]).reshape(
            -1, len(FIGURES)
        ),
        np.array([covariance.features.information for covariance in spreads]).reshape(-1, 3, 3),
        np.array(away).reshape(-1, 2),
        (published.stamps_ns[kept] - ticks_ns) / NS_PER_S,
        error[kept],
        np.full(len(kept), run, dtype=np.int64),
        np.full(len(kept), building, dtype=np.int64),
    )
