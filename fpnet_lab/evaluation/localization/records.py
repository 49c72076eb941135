# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scoring of a method's run against the truth, and the records of the scores."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet.accuracy import pose_errors, summarize_run
from fpnet_core.geometry import Affine2D, angle_between
from fpnet_core.trajectory import PlanarTrajectory, lengths_along

SCORED_AT_M = 40.0
"""
Path after which a generated run must be right; shorter tours are scored at their end. Chosen.
"""

TIGHT = (0.5, float(np.deg2rad(5.0)))
RIGHT = (1.0, float(np.deg2rad(10.0)))
"""
Largest errors [m], [rad] of the two recalls; the second also defines right estimates. Chosen.
"""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class UpdateEstimate:
    """Best placement at an update, None without one, and its probability."""

    stamp_ns: int
    probability: float
    A_plan_odom: Affine2D | None


@dataclass(frozen=True, eq=False)
class MethodRun:
    """
    Complete output of a method during a run.

    ``published`` holds a pose for every scan while localized, plan frame, nominal metres, and
    ``covariances (S, 3, 3)`` theirs, None if the method estimates none; ``odometry`` is the
    sensor's path in ``odom``; ``statuses`` has one entry per update.
    """

    published: PlanarTrajectory
    odometry: PlanarTrajectory
    beliefs: tuple[UpdateEstimate, ...]
    tick_ms: Array
    add_scan_ms: Array
    rss_mb: float
    statuses: tuple[str, ...] = ()
    covariances: Array | None = None


@dataclass(frozen=True)
class Truth:
    """True sensor poses, ``A_plan_truth`` to the plan, and the path length at scoring [m]."""

    poses: PlanarTrajectory
    A_plan_truth: Affine2D
    judged_at_m: float = float('inf')


@dataclass(frozen=True)
class RunLabels:
    """Identification of a run: attributes of the case, the method, and the plan's building."""

    case: str
    group: str
    building: str
    sensor: str
    seed: int
    method: str
    plan: str


@dataclass(frozen=True)
class Record(RunLabels):
    """
    One scored run of one method, plain values only.

    Errors are in true metres and degrees, None if no pose was published. ``is_open_set`` runs have
    no right answer: poses published there are false acceptances and enter no other figure.
    ``beliefs`` holds ``(probability, is_right)`` of every update with a placement; ``nees_mean``
    and ``inside_95`` are those of :class:`fpnet.accuracy.RunSummary`.
    """

    is_open_set: bool
    is_right: bool
    is_tight: bool
    poses: int
    wrong_poses: int
    path_to_first_pose_m: float | None
    median_position_error_m: float | None
    median_yaw_error_deg: float | None
    beliefs: tuple[tuple[float, bool], ...]
    tick_ms: tuple[float, ...]
    add_scan_ms: float | None
    rss_mb: float
    statuses: tuple[str, ...] = ()
    nees_mean: float | None = None
    inside_95: float | None = None


def score(labels: RunLabels, run: MethodRun, truth: Truth | None) -> Record:
    """Score a run against the truth; None: another building's plan, where no pose is right."""
    summary = summarize_run(
        run.published,
        run.odometry,
        run.tick_ms,
        truth.poses if truth else None,
        truth.A_plan_truth if truth else None,
        run.covariances,
    )
    position, yaw = _final_error(run, truth) if truth else (np.inf, np.inf)
    return Record(
        **asdict(labels),
        is_open_set=truth is None,
        is_right=position <= RIGHT[0] and yaw <= RIGHT[1],
        is_tight=position <= TIGHT[0] and yaw <= TIGHT[1],
        poses=summary.poses,
        wrong_poses=summary.wrong_poses or 0,
        path_to_first_pose_m=summary.path_to_first_pose_m,
        median_position_error_m=summary.median_position_error_m,
        median_yaw_error_deg=summary.median_yaw_error_deg,
        beliefs=_scored_estimates(run, truth),
        tick_ms=tuple(np.round(run.tick_ms, 2).tolist()),
        add_scan_ms=float(np.median(run.add_scan_ms)) if len(run.add_scan_ms) else None,
        rss_mb=round(run.rss_mb, 1),
        statuses=run.statuses,
        nees_mean=summary.nees_mean,
        inside_95=summary.inside_95,
    )


def stamp_at_path(odometry: PlanarTrajectory, path_m: float) -> int:
    """Return the stamp of the first pose after ``path_m``; of the last pose on shorter paths."""
    index = int(np.searchsorted(lengths_along(odometry.xy)[1:], path_m)) + 1
    return int(odometry.stamps_ns[min(index, len(odometry) - 1)])


def _final_error(run: MethodRun, truth: Truth) -> tuple[float, float]:
    """Return the errors [m], [rad] of the pose published at the scored path, or infinity."""
    stamp_ns = stamp_at_path(run.odometry, truth.judged_at_m)
    there = run.published.stamps_ns == stamp_ns
    standing = run.published.take(there)
    position, yaw = pose_errors(standing.mapped(truth.A_plan_truth.inv()), truth.poses)
    return (float(position[0]), float(yaw[0])) if len(position) else (np.inf, np.inf)


def belief_errors(run: MethodRun, truth: Truth) -> list[tuple[float, float] | None]:
    """Return the errors [m], [rad] of the best placement's robot pose at each update."""
    return [
        None
        if estimate.A_plan_odom is None
        else robot_error(estimate.stamp_ns, estimate.A_plan_odom, run.odometry, truth)
        for estimate in run.beliefs
    ]


def robot_error(
    stamp_ns: int, A_plan_odom: Affine2D, odometry: PlanarTrajectory, truth: Truth
) -> tuple[float, float]:
    """Return the error [m], [rad] of the robot pose under a placement of the odometry frame."""
    stamp = np.array([stamp_ns])
    (odom, _), (true, _) = odometry.at(stamp), truth.poses.at(stamp)
    placed = odom.mapped(truth.A_plan_truth.inv() @ A_plan_odom)
    position = float(np.linalg.norm(placed.xy[0] - true.xy[0]))
    return position, float(angle_between(placed.yaw, true.yaw)[0])


def _scored_estimates(run: MethodRun, truth: Truth | None) -> tuple[tuple[float, bool], ...]:
    if truth is None:
        placed = [estimate for estimate in run.beliefs if estimate.A_plan_odom is not None]
        return tuple((round(estimate.probability, 4), False) for estimate in placed)
    scored = zip(run.beliefs, belief_errors(run, truth), strict=True)
    return tuple(
        (round(estimate.probability, 4), error[0] <= RIGHT[0] and error[1] <= RIGHT[1])
        for estimate, error in scored
        if error is not None
    )
