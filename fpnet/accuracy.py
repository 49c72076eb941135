# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Metrics of a localization run: time to the first pose, errors, covariance consistency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D, angle_between, wrap_to_pi
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory

# Chosen, not measured:
WRONG_POSITION_M = 3.0
WRONG_YAW_RAD = np.deg2rad(30.0)

GATE_95 = 7.815
"""Given: 95 % quantile of the chi-squared distribution with three degrees of freedom."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RunSummary:
    """
    Metrics of one run; None without a published pose or without ground truth.

    Errors are in true metres and degrees; a pose is wrong beyond 3 m or 30 degrees.
    ``nees_mean`` is the mean of :func:`normalised_errors`, 3 for consistent covariances, and
    ``inside_95`` their share within :data:`GATE_95`. The ``sigma`` are medians of the published
    standard deviations of position and yaw.
    """

    localized: bool
    poses: int
    wrong_poses: int | None
    time_to_first_pose_s: float | None
    path_to_first_pose_m: float | None
    median_position_error_m: float | None
    median_yaw_error_deg: float | None
    tick_ms_p50: float | None
    tick_ms_p95: float | None
    sigma_position_m_median: float | None = None
    sigma_yaw_deg_median: float | None = None
    nees_mean: float | None = None
    inside_95: float | None = None

    def __str__(self) -> str:
        """Return the main metrics in one line."""
        if not self.localized:
            return 'no pose was published'
        text = (
            f'{self.poses} poses, the first after {self.time_to_first_pose_s:.1f} s '
            f'and {self.path_to_first_pose_m:.1f} m'
        )
        if self.median_position_error_m is None:
            return text
        return (
            f'{text}; {self.wrong_poses} wrong, median error '
            f'{self.median_position_error_m:.2f} m, {self.median_yaw_error_deg:.1f} deg'
        )

    def as_json(self) -> dict[str, Any]:
        """Return a JSON-serializable mapping, floats rounded to 4 digits."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {k: round(v, 4) if isinstance(v, float) else v for k, v in values.items()}


def pose_errors(estimate: PlanarTrajectory, truth: PlanarTrajectory) -> tuple[Array, Array]:
    """
    Return position [m] and yaw [rad] errors ``(K,)`` of poses with ground truth near in time.

    Both trajectories are in the same metric frame. Without poses or truth the arrays are empty.
    """
    if len(estimate) == 0 or len(truth) < 2:
        return np.zeros(0), np.zeros(0)
    reference, known = truth.at(estimate.stamps_ns)
    position = np.linalg.norm(estimate.xy - reference.xy, axis=1)
    return position[known], angle_between(estimate.yaw, reference.yaw)[known]


def normalised_errors(
    published: PlanarTrajectory,
    covariances: Array,
    truth: PlanarTrajectory,
    A_plan_truth: Affine2D,
) -> Array:
    """
    Return the normalised estimation errors squared ``(K,)``, three degrees of freedom.

    Only poses with ground truth near in time that are not wrong are included: wrong poses are
    counted separately, and :attr:`LocalizerOutput.probability` covers them.

    Parameters
    ----------
    published, covariances : poses and ``(S, 3, 3)`` of x, y [m] and yaw [rad], plan frame
    truth : ground-truth poses in a frame of true metres
    A_plan_truth : transform from that frame to the plan's nominal metres
    """
    if len(published) == 0 or len(truth) < 2:
        return np.zeros(0)
    position, yaw = pose_errors(published.mapped(A_plan_truth.inv()), truth)
    right = (position <= WRONG_POSITION_M) & (yaw <= WRONG_YAW_RAD)
    on_plan, known = truth.mapped(A_plan_truth).at(published.stamps_ns)
    turned = wrap_to_pi(published.yaw - on_plan.yaw)
    error = np.column_stack([published.xy - on_plan.xy, turned])[known][right]
    solved = np.linalg.solve(covariances[known][right], error[..., None])[..., 0]
    return np.asarray((error * solved).sum(axis=1))


def summarize_run(
    published: PlanarTrajectory,
    odometry: PlanarTrajectory,
    tick_ms: Array,
    truth: PlanarTrajectory | None = None,
    A_plan_truth: Affine2D | None = None,
    covariances: Array | None = None,
) -> RunSummary:
    """
    Return the metrics of a run.

    Parameters
    ----------
    published : all published poses, plan frame, nominal metres
    odometry : odometry path [m], for time and path length to the first pose
    tick_ms : (T,) durations of the updates that had a submap
    truth : ground-truth poses in a frame of true metres; None if unknown
    A_plan_truth : transform from that frame to the plan's nominal metres; None for the identity
    covariances : (S, 3, 3) of the published poses; None if unknown
    """
    first_ns = int(published.stamps_ns[0]) if len(published) else None
    wrong: int | None = None
    position, yaw = np.zeros(0), np.zeros(0)
    nees = np.zeros(0)
    if truth is not None:
        on_plan = A_plan_truth or Affine2D.identity()
        position, yaw = pose_errors(published.mapped(on_plan.inv()), truth)
        if covariances is not None:
            nees = normalised_errors(published, covariances, truth, on_plan)
        wrong = int(np.count_nonzero((position > WRONG_POSITION_M) | (yaw > WRONG_YAW_RAD)))
    return RunSummary(
        localized=len(published) > 0,
        poses=len(published),
        wrong_poses=wrong,
        time_to_first_pose_s=None
        if first_ns is None or len(odometry) == 0
        else (first_ns - int(odometry.stamps_ns[0])) / NS_PER_S,
        path_to_first_pose_m=None if first_ns is None else odometry.path_length_m(first_ns),
        median_position_error_m=quantile(position, 0.5),
        median_yaw_error_deg=quantile(np.rad2deg(yaw), 0.5),
        tick_ms_p50=quantile(tick_ms, 0.5),
        tick_ms_p95=quantile(tick_ms, 0.95),
        **_sigmas(covariances),
        nees_mean=float(nees.mean()) if len(nees) else None,
        inside_95=float((nees <= GATE_95).mean()) if len(nees) else None,
    )


def _sigmas(covariances: Array | None) -> dict[str, float | None]:
    """Return the median standard deviations of covariances ``(S, 3, 3)``."""
    cov = np.zeros((0, 3, 3)) if covariances is None else covariances
    return {
        'sigma_position_m_median': quantile(np.sqrt(cov[:, 0, 0] + cov[:, 1, 1]), 0.5),
        'sigma_yaw_deg_median': quantile(np.rad2deg(np.sqrt(cov[:, 2, 2])), 0.5),
    }


def quantile(values: Array | Sequence[float], q: float) -> float | None:
    """Return the quantile ``q`` in [0, 1] of values (N,), None without values."""
    return float(np.quantile(values, q)) if len(values) else None
