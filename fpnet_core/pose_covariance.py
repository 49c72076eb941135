# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Covariance of a published pose and its growth between updates."""

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
    Features of an update that determine the covariance of its pose.

    ``information (3, 3)`` is the information of nearby returns on x, y and yaw, in plan axes about
    the robot; ``figures (F,)`` are those of :class:`fpnet_core.pose.uncertainty.Misfit`. Both are
    in working metres. ``heading_residual_rad`` is carried over to the next update.
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
    Drift of odometry as standard deviations; contributions add up in quadrature.

    Position [m] and yaw [rad] per metre from the position of the update, and per second since it.
    """

    position_per_m: float
    position_per_s: float
    yaw_per_m: float
    yaw_per_s: float


@dataclass(frozen=True, eq=False)
class PoseCovariance:
    """
    Covariance of a pose at an update, with its growth afterwards.

    Parameters
    ----------
    cov : (3, 3)
        Of the robot's x, y [m] and yaw [rad] in the floorplan's frame, nominal metres, at the
        newest scan of the update.
    xy_odom : (2,)
        Position of the robot in ``odom`` at that scan [m].
    stamp_ns
        Stamp of that scan.
    growth
        Drift that odometry adds from there on, in the same metres.
    features
        Features that the covariance was computed from.
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
    Propagate covariances ``(..., 3, 3)`` of poses by the motion of odometry.

    An error in yaw displaces the robot in proportion to the distance travelled.

    Parameters
    ----------
    cov : (..., 3, 3) of x, y [m] and yaw [rad] on the plan
    away : (..., 2) displacement of the robot since then, plan axes [m]
    age_s : (...) time since then
    growth : drift of odometry
    """
    there = np.zeros(cov.shape) + np.eye(3)
    there[..., 0, 2], there[..., 1, 2] = -away[..., 1], away[..., 0]
    m2, s2 = (away**2).sum(axis=-1), age_s**2
    position = m2 * growth.position_per_m**2 + s2 * growth.position_per_s**2
    yaw = m2 * growth.yaw_per_m**2 + s2 * growth.yaw_per_s**2
    lost = np.stack([position, position, yaw], axis=-1)[..., None] * np.eye(3)
    return np.asarray(there @ cov @ np.swapaxes(there, -1, -2) + lost)
