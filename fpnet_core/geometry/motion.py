# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Constant-twist motion, to deskew sweeps (Lynch and Park, Modern Robotics, eq. 3.88)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

_NO_TURN_RAD = 1e-12  # numerical: a smaller rotation has no axis


def carried(
    points: ArrayLike, T_a_b: NDArray[np.float64], share: ArrayLike
) -> NDArray[np.float64]:
    """
    Return the points ``(P, 3)``, each moved by its own share of a constant-twist motion.

    To deskew, pass the sensor's motion ``T_a_b`` from pose ``a`` at the start of the sweep to
    pose ``b`` at its end, and as share each point's time minus the end time, over the sweep's
    duration (-1 to 0). The points returned are relative to pose ``b``.

    Parameters
    ----------
    points : (P, 3)
        Relative to the sensor at each point's own time [m].
    T_a_b : (4, 4)
        Rigid motion.
    share : (P,)
        Fraction of the motion to apply; 0 keeps the point, -1 applies the inverse motion.
    """
    points, share = np.asarray(points, dtype=np.float64), np.asarray(share, dtype=np.float64)
    if not len(points):
        return points
    turn = Rotation.from_matrix(T_a_b[:3, :3]).as_rotvec()
    velocity = np.linalg.solve(_integral(turn), T_a_b[:3, 3])
    angle = share * np.linalg.norm(turn)
    axis = turn / max(float(np.linalg.norm(turn)), _NO_TURN_RAD)
    turned: NDArray[np.float64] = Rotation.from_rotvec(share[:, None] * turn).apply(points)
    straight, aside = np.sinc(angle / np.pi), np.sinc(angle / (2.0 * np.pi)) ** 2 * angle / 2.0
    moved = (
        straight[:, None] * velocity
        + aside[:, None] * np.cross(axis, velocity)
        + (1.0 - straight)[:, None] * axis * (axis @ velocity)
    )
    result: NDArray[np.float64] = turned + share[:, None] * moved
    return result


def part_of(T_a_b: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Return the fraction ``share`` of a rigid motion ``(4, 4)`` at constant twist."""
    turn = Rotation.from_matrix(T_a_b[:3, :3]).as_rotvec()
    velocity = np.linalg.solve(_integral(turn), T_a_b[:3, 3])
    part = np.eye(4)
    part[:3, :3] = Rotation.from_rotvec(share * turn).as_matrix()
    part[:3, 3] = _integral(share * turn) @ (share * velocity)
    return part


def twist(T_a_b: NDArray[np.float64], seconds: float) -> NDArray[np.float64]:
    """
    Return the constant body twist ``(6,)`` that leads from pose ``a`` to ``b`` in a time.

    Linear [m/s], then angular velocity [rad/s], in the moving frame.
    """
    turn = Rotation.from_matrix(T_a_b[:3, :3]).as_rotvec()
    velocity = np.linalg.solve(_integral(turn), T_a_b[:3, 3])
    return np.concatenate([velocity, turn]) / seconds


def _integral(turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``V (3, 3)`` of SE(3)'s exponential map: translation = ``V @ velocity``."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn / max(angle, _NO_TURN_RAD)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    straight = float(np.sinc(angle / np.pi))
    aside = float(np.sinc(angle / (2.0 * np.pi))) ** 2 * angle / 2.0
    whole: NDArray[np.float64] = np.eye(3) + aside * cross + (1.0 - straight) * (cross @ cross)
    return whole
