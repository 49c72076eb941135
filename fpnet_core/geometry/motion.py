# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Motion during a sweep, and points without it (Lynch and Park, Modern Robotics, 3.88)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

_NO_TURN_RAD = 1e-12  # numerical: below, a rotation has no axis


def carried(
    points: ArrayLike, T_a_b: NDArray[np.float64], share: ArrayLike
) -> NDArray[np.float64]:
    """
    Return every point moved by its own share of a motion at even speed, turning evenly.

    A sensor that moved by ``T_a_b`` over a time, from pose ``a`` to pose ``b``, saw each point
    from somewhere in between; with the share of that time from the end back to the point, as a
    negative number, all points come out as seen from the end.

    Parameters
    ----------
    points : (P, 3)
        Relative to the sensor at each point's own instant [m].
    T_a_b : (4, 4)
        Rigid motion.
    share : (P,)
        Of the motion; 0 leaves a point where it is, -1 undoes all of it.
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
    """Return a share of a rigid motion ``(4, 4)`` at even speed, turning evenly."""
    turn = Rotation.from_matrix(T_a_b[:3, :3]).as_rotvec()
    velocity = np.linalg.solve(_integral(turn), T_a_b[:3, 3])
    part = np.eye(4)
    part[:3, :3] = Rotation.from_rotvec(share * turn).as_matrix()
    part[:3, 3] = _integral(share * turn) @ (share * velocity)
    return part


def twist(T_a_b: NDArray[np.float64], seconds: float) -> NDArray[np.float64]:
    """
    Return the even velocity ``(6,)`` that leads from pose ``a`` to pose ``b`` in a time.

    Along x, y and z [m/s] and about them [rad/s], in the moving frame itself.
    """
    turn = Rotation.from_matrix(T_a_b[:3, :3]).as_rotvec()
    velocity = np.linalg.solve(_integral(turn), T_a_b[:3, 3])
    return np.concatenate([velocity, turn]) / seconds


def _integral(turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``V (3, 3)``: an even twist of rotation vector ``turn`` moves by ``V @ velocity``."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn / max(angle, _NO_TURN_RAD)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    straight = float(np.sinc(angle / np.pi))
    aside = float(np.sinc(angle / (2.0 * np.pi))) ** 2 * angle / 2.0
    whole: NDArray[np.float64] = np.eye(3) + aside * cross + (1.0 - straight) * (cross @ cross)
    return whole
