# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How far a published pose may be off: what a tick has found, and how it grows until the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import Affine2D
from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PoseFeatures:
    """
    What a tick saw of how well a pose is known.

    ``information (3, 3)`` is what returns around the robot say of its x, y and yaw, plan axes
    about the robot; ``figures (F,)`` are those of :class:`fpnet_core.pose.uncertainty.Misfit`.
    Both are in working metres. ``unrest_rad`` is what the next tick goes on from.
    """

    information: Array
    figures: Array
    heading_residual_rad: float = 0.0

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        freeze_field(self, 'information', np.float64, (3, 3))
        freeze_field(self, 'figures', np.float64, (None,))


@dataclass(frozen=True, eq=False)
class Growth:
    """
    What odometry loses: standard deviations that add up as squares.

    Position [m] and yaw [rad] per metre from where the tick was, and per second since then.
    """

    position_per_m: float
    position_per_s: float
    yaw_per_m: float
    yaw_per_s: float


@dataclass(frozen=True, eq=False)
class PoseCovariance:
    """
    How far off a pose may be.

    Parameters
    ----------
    cov : (3, 3)
        Of the robot's x, y [m] and yaw [rad] in the floorplan's frame, nominal metres, at the
        tick's newest scan.
    xy_odom : (2,)
        Where odometry had the robot then [m].
    stamp_ns
        When that was.
    growth
        What odometry adds from there on, in the same metres.
    signs
        What all of it was made from.
    """

    cov: Array
    xy_odom: Array
    stamp_ns: int
    growth: Growth
    features: PoseFeatures

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        freeze_field(self, 'cov', np.float64, (3, 3))
        freeze_field(self, 'xy_odom', np.float64, (2,))

    def at(self, A_plan_odom: Affine2D, xy_odom: Array, stamp_ns: int) -> Array:
        """Return the covariance ``(3, 3)`` of the pose at another scan, ``xy_odom (2,)`` [m]."""
        away = A_plan_odom.linear @ (xy_odom - self.xy_odom)
        age_s = np.array((stamp_ns - self.stamp_ns) / NS_PER_S)
        return carried(self.cov, away, age_s, self.growth)


def carried(cov: Array, away: Array, age_s: Array, growth: Growth) -> Array:
    """
    Return covariances ``(..., 3, 3)`` of poses after odometry has carried them on.

    An error in yaw moves the robot the further the more distant it is from where it was.

    Parameters
    ----------
    cov : (..., 3, 3) of x, y [m] and yaw [rad] on the plan
    away : (..., 2) from there to where the robot is, plan axes [m]
    age_s : (...) since then
    growth : what odometry loses
    """
    there = np.zeros(cov.shape) + np.eye(3)
    there[..., 0, 2], there[..., 1, 2] = -away[..., 1], away[..., 0]
    m2, s2 = (away**2).sum(axis=-1), age_s**2
    position = m2 * growth.position_per_m**2 + s2 * growth.position_per_s**2
    yaw = m2 * growth.yaw_per_m**2 + s2 * growth.yaw_per_s**2
    lost = np.stack([position, position, yaw], axis=-1)[..., None] * np.eye(3)
    return np.asarray(there @ cov @ np.swapaxes(there, -1, -2) + lost)
