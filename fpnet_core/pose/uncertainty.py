# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Model of the uncertainty of a pose on a drawing.

Alignment residuals underestimate it: hundreds of returns hit the same wall and share the error of
its drawing. The model instead uses how far the drawing must deform to explain the whole submap,
how far walls lie off drawn ones, the heading residual of odometry, and the directions of the walls
near the robot: a bare corridor does not constrain the position along it. Odometry adds drift
between updates. ``fpnet train covariance`` fits the weights to recordings with ground truth.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
import json
import math
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import WeightsError
from fpnet_core.geometry import Affine2D
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose_covariance import Growth, PoseCovariance, PoseFeatures

Array = NDArray[np.float64]

WEIGHTS_NAME = 'covariance.json'
FIGURES = ('bend', 'residual', 'unrest')
"""Given: logarithms of the features of :class:`Misfit`, in this order."""

CLIP = 2.5
"""Numerical: features are clipped to this many standard deviations."""

FEW_RETURNS, FEWEST_RETURNS = 50.0, 10.0
"""
Returns facing a direction, five metres of wall, at which its variance is twice the minimum; and
returns added to every direction, one metre, so that none has zero. Chosen: in furnished buildings
values from 5 to 60 fit recordings equally well; bare corridors must stay uncertain.
"""

_LEAST = np.array([0.02, 0.02, 0.003])  # numerical: smaller features are not significant
_WIDTH_M = 0.3  # chosen: returns farther from drawn walls do not count
_DAMPING = np.diag([2.0, 2.0, 20.0])  # numerical: keeps a turn solvable with few walls
_RECOVERY_S = 9.0  # chosen: time constant after which odometry is trusted again


@dataclass(frozen=True)
class Misfit:
    """
    Features of a bad fit; the larger, the more uncertain the pose.

    Parameters
    ----------
    deformation_m
        Deformation of the drawing under the whole submap [m].
    residual_m
        75th percentile of the distances of the submap's walls to drawn ones [m].
    heading_residual_rad
        Rotation of the newest scans relative to the drawing, maximum over the last updates:
        wheel slip and similar faults of odometry persist in some places.
    """

    deformation_m: float
    residual_m: float
    heading_residual_rad: float

    @property
    def figures(self) -> Array:
        """Features of the model ``(F,)``, in the order of :data:`FIGURES`."""
        values = np.array([self.deformation_m, self.residual_m, self.heading_residual_rad])
        return np.asarray(np.log(values + _LEAST))


def wall_information(
    plan: MapEvidence, seen: Array, A_plan_odom: Affine2D, robot_odom: Array
) -> Array:
    """
    Return the information of returns on x, y and yaw about the robot, ``(3, 3)``, plan axes.

    ``seen (P, 2)`` and ``robot_odom (2,)`` are in odom [m]. Each return near a drawn wall adds
    one to the direction normal to that wall, and nothing along it.
    """
    return _normal_equations(plan, seen, A_plan_odom, robot_odom)[0]


def heading_residual_of(
    plan: MapEvidence,
    newest: Array,
    A_plan_odom: Affine2D,
    robot_odom: Array,
    before: tuple[float, float] = (0.0, 0.0),
) -> float:
    """
    Return the rotation that would move the ``newest (P, 2)`` returns onto drawn walls [rad].

    ``before`` is the last result and its age [s]; its decayed value is a lower bound.
    """
    information, pull = _normal_equations(plan, newest, A_plan_odom, robot_odom)
    turn = np.linalg.solve(information + _DAMPING, pull)[2]
    last, age_s = before
    return max(abs(float(turn)), last * math.exp(-abs(age_s) / _RECOVERY_S))


@dataclass(frozen=True, eq=False)
class UncertaintyModel:
    """
    Fitted model of the pose covariance.

    ``mean`` and ``std (F,)`` standardise the features; ``position`` and ``yaw (F + 1,)`` give the
    log variances as a linear function of 1 and the features: of position [m^2] with many walls in
    every direction, and of yaw [rad^2]. In a direction that few returns face, the variance grows
    by :data:`FEW_RETURNS` over their number.
    """

    mean: Array
    std: Array
    position: Array
    yaw: Array
    growth: Growth

    def covariance(self, features: PoseFeatures, xy_odom: Array, stamp_ns: int) -> PoseCovariance:
        """Return the covariance of the pose at ``xy_odom (2,)``, with its growth afterwards."""
        cov = self.covariances(features.figures, features.information)
        return PoseCovariance(cov, xy_odom, stamp_ns, self.growth, features)

    def covariances(self, figures: Array, information: Array) -> Array:
        """
        Return the covariances ``(..., 3, 3)`` of poses at their updates.

        ``figures (..., F)`` and ``information (..., 3, 3)`` are those of :class:`PoseFeatures`.
        """
        scaled = np.clip((figures - self.mean) / self.std, -CLIP, CLIP)
        position, yaw = (np.exp(w[0] + scaled @ w[1:]) for w in (self.position, self.yaw))
        few = np.linalg.inv(information[..., :2, :2] + FEWEST_RETURNS * np.eye(2))
        cov = np.zeros((*position.shape, 3, 3))
        cov[..., :2, :2] = position[..., None, None] * (np.eye(2) + FEW_RETURNS * few)
        cov[..., 2, 2] = yaw
        return cov

    @classmethod
    def from_json(cls, stored: dict[str, Any]) -> Self:
        """
        Return the model stored in a file.

        Raises
        ------
        WeightsError
            If it was fitted to other features.
        """
        if stored['figures'] != list(FIGURES):
            raise WeightsError(
                f'{WEIGHTS_NAME} was fitted to {stored["figures"]}, expected {list(FIGURES)}; '
                'fit again with fpnet train covariance'
            )
        arrays = {name: np.array(stored[name]) for name in ('mean', 'std', 'position', 'yaw')}
        growth = Growth(**stored['growth'])
        return cls(**arrays, growth=growth)


@cache
def packaged_uncertainty() -> UncertaintyModel:
    """Return the packaged model, loaded once."""
    file = resources.files('fpnet_core.weights') / WEIGHTS_NAME
    return UncertaintyModel.from_json(json.loads(file.read_text(encoding='utf-8')))


def _normal_equations(
    plan: MapEvidence, seen: Array, A_plan_odom: Affine2D, robot_odom: Array
) -> tuple[Array, Array]:
    """Return information ``(3, 3)`` and gradient ``(3,)`` of returns near drawn walls."""
    placed = A_plan_odom.apply(seen).reshape(-1, 2)
    distance, gradient, inside = _distances(plan, placed)
    away = placed[inside] - A_plan_odom.apply(robot_odom)
    turn = gradient[:, 1] * away[:, 0] - gradient[:, 0] * away[:, 1]
    jacobian = np.column_stack([gradient, turn])
    weighed = jacobian.T * np.exp(-0.5 * (distance / _WIDTH_M) ** 2)
    return weighed @ jacobian, -weighed @ distance


def _distances(plan: MapEvidence, placed: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return distances to drawn walls ``(Q,)``, gradients ``(Q, 2)``, and the mask inside."""
    field, A = plan.wall_distance, plan.A_rc_xy
    rc = placed @ A[:, :2].T + A[:, 2]
    is_inside = (rc >= 0.0) & (rc < np.array(field.shape) - 1)
    inside = np.asarray(is_inside.all(axis=1))
    low = np.floor(rc[inside]).astype(np.int64)
    (row, col), (down, across) = low.T, (rc[inside] - low).T
    near, right = field[row, col], field[row, col + 1]
    below, opposite = field[row + 1, col], field[row + 1, col + 1]
    d_row = (below - near) * (1.0 - across) + (opposite - right) * across
    d_col = (right - near) * (1.0 - down) + (opposite - below) * down
    value = near * (1.0 - across) + right * across + d_row * down
    return value, np.column_stack([d_row, d_col]) @ A[:, :2], inside
