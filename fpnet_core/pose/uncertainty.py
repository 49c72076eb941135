# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How far a pose on a drawing may be off: a model of what errs.

The residuals of an alignment say little of it: hundreds of returns share one wall, and with it
what its drawing is off by. What tells is how far the drawing must bend to explain the whole
submap, how far walls lie off drawn ones, whether odometry stumbles, and which way the walls around
the robot face: a bare corridor says nothing of the position along it. Odometry adds its own from
tick to tick. How much each weighs was fitted to drives whose truth is known, by ``fpnet
train covariance``.
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
"""Given: logarithms of the figures of :class:`Misfit`, in this order."""

CLIP = 2.5
"""Numerical: figures are held to so many standard deviations: nothing unseen counts more."""

FEW_RETURNS, FEWEST_RETURNS = 50.0, 10.0
"""
A direction that so many returns face, five metres of wall, is known half as well as any can be;
and a metre is added to each, so that none is without. Chosen: buildings with furniture have walls
everywhere, and drives through them are as probable from 5 to 60; bare corridors must stay wide.
"""

_LEAST = np.array([0.02, 0.02, 0.003])  # numerical: figures below these are as good as none
_WIDTH_M = 0.3  # chosen: walls further off than this are not the drawn ones
_DAMPING = np.diag([2.0, 2.0, 20.0])  # numerical: keeps a turn solvable where walls are few
_CALM_S = 9.0  # chosen: so long after a stumble odometry is trusted again


@dataclass(frozen=True)
class Misfit:
    """
    How badly a placement fits; a pose is known the worse.

    Parameters
    ----------
    deformation_m
        How far the drawing has to bend under the whole submap [m].
    residual_m
        Three quarters of the submap's walls lie nearer to drawn ones [m].
    unrest_rad
        By how much the newest scans are turned against the drawing, at most over the last ticks:
        odometry stumbles in places, and goes on stumbling there.
    """

    deformation_m: float
    residual_m: float
    heading_residual_rad: float

    @property
    def figures(self) -> Array:
        """Return the model's figures ``(F,)``, in the order of :data:`FIGURES`."""
        values = np.array([self.deformation_m, self.residual_m, self.heading_residual_rad])
        return np.asarray(np.log(values + _LEAST))


def wall_information(
    plan: MapEvidence, seen: Array, A_plan_odom: Affine2D, robot_odom: Array
) -> Array:
    """
    Return what returns say of x, y and yaw about the robot, ``(3, 3)``, plan axes.

    ``seen (P, 2)`` and ``robot_odom (2,)`` are in odom [m]. Each return near a drawn wall says
    one of the direction across that wall, and nothing of the one along it.
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
    Return by how much the ``newest (P, 2)`` returns would turn to lie on drawn walls [rad].

    ``before`` is what was returned last, and how long ago that was [s]: it wears off slowly.
    """
    information, pull = _normal_equations(plan, newest, A_plan_odom, robot_odom)
    turn = np.linalg.solve(information + _DAMPING, pull)[2]
    last, age_s = before
    return max(abs(float(turn)), last * math.exp(-abs(age_s) / _CALM_S))


@dataclass(frozen=True, eq=False)
class UncertaintyModel:
    """
    What the figures weigh.

    ``mean`` and ``std (F,)`` standardise the figures; ``position`` and ``yaw (F + 1,)`` give the
    logarithms of variances from 1 and the figures: of position [m^2] where walls abound in every
    direction, and of yaw [rad^2]. In a direction that few returns face the variance grows by
    :data:`FEW_RETURNS` over their number.
    """

    mean: Array
    std: Array
    position: Array
    yaw: Array
    growth: Growth

    def covariance(self, features: PoseFeatures, xy_odom: Array, stamp_ns: int) -> PoseCovariance:
        """Return how far off the pose of a robot at ``xy_odom (2,)`` may be, then and after."""
        cov = self.covariances(features.figures, features.information)
        return PoseCovariance(cov, xy_odom, stamp_ns, self.growth, features)

    def covariances(self, figures: Array, information: Array) -> Array:
        """
        Return the covariances ``(..., 3, 3)`` of poses at their ticks.

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
        Return the model that a file holds.

        Raises
        ------
        WeightsError
            If it was fitted to other figures.
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
    """Return the model as it is shipped, read once."""
    file = resources.files('fpnet_core.weights') / WEIGHTS_NAME
    return UncertaintyModel.from_json(json.loads(file.read_text(encoding='utf-8')))


def _normal_equations(
    plan: MapEvidence, seen: Array, A_plan_odom: Affine2D, robot_odom: Array
) -> tuple[Array, Array]:
    """Return information ``(3, 3)`` and pull ``(3,)`` of returns to the nearest drawn walls."""
    placed = A_plan_odom.apply(seen).reshape(-1, 2)
    distance, gradient, inside = _distances(plan, placed)
    away = placed[inside] - A_plan_odom.apply(robot_odom)
    turn = gradient[:, 1] * away[:, 0] - gradient[:, 0] * away[:, 1]
    jacobian = np.column_stack([gradient, turn])
    weighed = jacobian.T * np.exp(-0.5 * (distance / _WIDTH_M) ** 2)
    return weighed @ jacobian, -weighed @ distance


def _distances(plan: MapEvidence, placed: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return distances ``(Q,)`` to drawn walls, their gradients ``(Q, 2)``, and who is inside."""
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
