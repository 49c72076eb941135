# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Local pose filter: pose of the robot on the plan despite drift of its submap.

A placement fits a whole submap to the plan. Odometry without loop closure deforms that submap, and
after some hundred metres no placement fits both its ends. The pose depends on the surroundings of
the robot only: the walls of the last metres are aligned with the plan separately, and a Kalman
filter carries the result from update to update. In a corridor, whose walls do not constrain the
position along it, odometry determines that position.

Wheel odometry loses heading in turns, which also smears the walls of the last metres. A pose that
differs from the accepted placement is therefore finally aligned with the walls of the last few
scans. The filter itself continues from the walls of the last metres, because three scans of a
narrow sensor are too few for tracking.

An inaccurate plan looks like drift and is handled in the same way: the pose is relative to the
walls as they are drawn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Affine2D, Placement, Placements, rotation, wrap_to_pi
from fpnet_core.pose import AGAIN, RIGID_STRAIN, AlignmentPrior, MapEvidence, refine, wall_support
from fpnet_core.submaps.recent import RECENT_M

Array = NDArray[np.float64]

FEWEST_POINTS = 60
"""Fewer returns do not determine a pose. Chosen."""

# Chosen, not measured:
# Standard deviations of x, y [m] and yaw [rad] when a placement is accepted.
_START = np.array([0.2, 0.2, np.deg2rad(2.0)])
_LOSS_PER_UPDATE = np.array([0.02, 0.02, np.deg2rad(0.5)])  # per update at standstill [m, m, rad]
# Returns from one wall share the error of its drawing: this many count as one measurement.
_POINTS_PER_MEASUREMENT = 25.0


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """
    Placement that is valid near ``robot_odom (2,)``.

    ``cov (3, 3)`` is of the robot's x, y [m] and yaw [rad] on the plan.
    """

    A_plan_odom: Affine2D
    robot_odom: Array
    cov: Array


@dataclass(frozen=True, eq=False)
class LocalPoseFilter:
    """Tracks the pose of one accepted placement; transforms are to the plan's working metres."""

    config: LocalizerConfig

    def follow(
        self,
        last: PoseEstimate | None,
        plan: MapEvidence,
        seen: Array,
        A_plan_odom: Affine2D,
        robot_odom: Array,
    ) -> tuple[PoseEstimate | None, Affine2D]:
        """
        Return the pose estimate for the next update, and ``A_plan_odom`` near the robot.

        If the accepted placement fits there, the estimate is None and the placement unchanged.

        Parameters
        ----------
        last : estimate of the last update; None for a newly accepted placement
        plan : evidence of the drawing
        seen : (P, 2) returns of the last metres, odom [m]
        A_plan_odom : accepted placement of the whole submap
        robot_odom : (2,) position of the robot [m]
        """
        tracked = self._predicted(last, A_plan_odom, robot_odom)
        if len(seen) >= FEWEST_POINTS:
            tracked = self._measured(plan, seen, A_plan_odom, tracked)
            both = Placements.of([A_plan_odom, tracked.A_plan_odom])
            support = wall_support(plan, seen, both)
            if support[1] < support[0] + self.config.drift_support:
                return None, A_plan_odom
        return tracked, tracked.A_plan_odom

    def at_last(
        self, plan: MapEvidence, newest: Array, A_plan_odom: Affine2D, robot_odom: Array
    ) -> Affine2D:
        """
        Return ``A_plan_odom`` aligned with the walls of the last scans, within odometry drift.

        It is unchanged if they hardly fit better then, since the plan may be wrong by that much.
        ``newest (P, 2)`` are their returns, and ``robot_odom (2,)`` the robot, odom [m].
        """
        if len(newest) < FEWEST_POINTS:
            return A_plan_odom
        fits = refine(plan, newest, Placements.of([A_plan_odom]), _rigid(A_plan_odom), AGAIN)
        both = Placements.of([A_plan_odom, fits[0].A_plan_submap])
        support = wall_support(plan, newest, both)
        if support[1] < support[0] + self.config.drift_support:
            return A_plan_odom
        # The drift that smeared the last metres lies, on average, half of them back.
        smeared = np.diag((0.5 * RECENT_M * self._loss_per_m()) ** 2)
        return _corrected(PoseEstimate(A_plan_odom, robot_odom, smeared), fits[0]).A_plan_odom

    def _predicted(
        self, last: PoseEstimate | None, accepted: Affine2D, robot_odom: Array
    ) -> PoseEstimate:
        """Return the last estimate plus odometry drift; without one, the accepted placement."""
        if last is None:
            return PoseEstimate(accepted, robot_odom, np.diag(_START**2))
        moved_m = float(np.hypot(*(robot_odom - last.robot_odom)))
        lost = np.diag((_LOSS_PER_UPDATE + moved_m * self._loss_per_m()) ** 2)
        A = _stretched_like(accepted, last.A_plan_odom, robot_odom)
        return PoseEstimate(A, robot_odom, last.cov + lost)

    def _loss_per_m(self) -> Array:
        """Return the drift (3,) of odometry as standard deviations: x, y [m/m], yaw [rad/m]."""
        m, deg = self.config.drift_m_per_m, self.config.drift_deg_per_m
        return np.array([m, m, np.deg2rad(deg)])

    def _measured(
        self, plan: MapEvidence, seen: Array, accepted: Affine2D, last: PoseEstimate
    ) -> PoseEstimate:
        """Return the estimate corrected by the walls near the robot."""
        starts = Placements.of([accepted, last.A_plan_odom])
        fits = refine(plan, seen, starts, _rigid(accepted), AGAIN)
        before, after = (wall_support(plan, seen, each) for each in (starts, fits))
        start, pick = last, 1
        if after[0] > after[1] + self.config.drift_support:
            start, pick = PoseEstimate(accepted, last.robot_odom, np.diag(_START**2)), 0
        return _corrected(start, fits[pick]) if after[pick] > before[pick] else start


def _rigid(A: Affine2D) -> AlignmentPrior:
    """Return the prior for rigid motion: the stretch stays that of ``A``."""
    return AlignmentPrior(RIGID_STRAIN, A.stretch)


def _corrected(fix: PoseEstimate, fit: Placement) -> PoseEstimate:
    """Return the estimate corrected by an alignment, weighted by their covariances."""
    robot, start = fix.robot_odom, fix.A_plan_odom
    measured = _POINTS_PER_MEASUREMENT * _cov_at(fit.cov, fit.A_plan_submap, robot)
    gain = fix.cov @ np.linalg.inv(fix.cov + measured)
    moved = _moved(start, gain @ _difference(fit.A_plan_submap, start, robot), robot)
    return PoseEstimate(moved, robot, (np.eye(3) - gain) @ fix.cov)


def _stretched_like(accepted: Affine2D, A: Affine2D, robot_odom: Array) -> Affine2D:
    """Return ``A`` with the stretch of ``accepted`` and the robot's position and heading."""
    linear = accepted.stretch @ rotation(A.heading)
    return Affine2D(linear, A.apply(robot_odom) - linear @ robot_odom)


def _difference(A: Affine2D, other: Affine2D, robot_odom: Array) -> Array:
    """Return the robot's pose by ``A`` relative to that by ``other``: x, y [m], yaw [rad]."""
    turned = wrap_to_pi(A.heading - other.heading)
    return np.append(A.apply(robot_odom) - other.apply(robot_odom), turned)


def _moved(A: Affine2D, by: Array, robot_odom: Array) -> Affine2D:
    """Return ``A`` with the robot translated and rotated on the plan."""
    S = A.stretch
    R = np.linalg.inv(S) @ A.linear
    linear = S @ rotation(by[2]) @ R
    return Affine2D(linear, A.apply(robot_odom) + by[:2] - linear @ robot_odom)


def _cov_at(cov: Array, A: Affine2D, robot_odom: Array) -> Array:
    """Return the covariance (3, 3) at the frame's origin transferred to the robot."""
    x, y = A.linear @ robot_odom
    J = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
    return np.asarray(J @ cov @ J.T)
