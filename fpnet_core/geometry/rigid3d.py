# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rigid 3D transforms as homogeneous (4, 4) matrices, to and from quaternions in ROS order."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fpnet_core.errors import OdometryError

# Numerical: tolerance on R^T R against the identity, and on the last row, of a rigid transform.
# Poses from text files have six digits, and chains of single-precision poses drift by 1e-4.
RIGID_TOLERANCE = 1e-3

_LEAST_NORM = 1e-6  # numerical: a quaternion with a smaller norm counts as zero


def is_rigid(matrix: ArrayLike) -> bool:
    """Return whether ``matrix`` is a finite (4, 4) rotation plus translation, not mirrored."""
    m = np.asarray(matrix, dtype=np.float64)
    if m.shape != (4, 4) or not np.isfinite(m).all():
        return False
    R = m[:3, :3]
    return bool(
        np.abs(R.T @ R - np.eye(3)).max() < RIGID_TOLERANCE
        and np.linalg.det(R) > 0.0
        and np.abs(m[3] - (0.0, 0.0, 0.0, 1.0)).max() < RIGID_TOLERANCE
    )


def checked_rigid(matrix: ArrayLike) -> NDArray[np.float64]:
    """
    Return a sensor's pose as a (4, 4) float64 array after checking that it is rigid.

    Raises
    ------
    OdometryError
        If it is not a rigid transform.
    """
    m = np.asarray(matrix, dtype=np.float64)
    if m.shape != (4, 4):
        raise OdometryError(f'sensor pose: expected a (4, 4) matrix, got shape {m.shape}')
    if not is_rigid(m):
        raise OdometryError(
            f'sensor pose: expected a rigid transform of finite values, got {m.tolist()}; fix the '
            'odometry'
        )
    return m


def rigid_from_quaternion(xyz: ArrayLike, xyzw: ArrayLike) -> NDArray[np.float64]:
    """
    Return the (4, 4) transform of translation ``xyz (3,)`` [m] and quaternion ``xyzw (4,)``.

    The quaternion is normalised, because recordings hold rounded ones.

    Raises
    ------
    ValueError
        If a value is not finite or the quaternion is zero.
    """
    xyz, xyzw = np.asarray(xyz, dtype=np.float64), np.asarray(xyzw, dtype=np.float64)
    if not (np.isfinite(xyz).all() and np.isfinite(xyzw).all()):
        raise ValueError('pose contains NaN or infinity')
    if np.linalg.norm(xyzw) < _LEAST_NORM:
        raise ValueError('quaternion is zero: the orientation was never set')
    m = np.eye(4)
    m[:3, :3] = Rotation.from_quat(xyzw).as_matrix()
    m[:3, 3] = xyz
    return m


def quaternion_from_rigid(matrix: ArrayLike) -> NDArray[np.float64]:
    """Return the unit quaternion ``xyzw (4,)``, w >= 0, of a rigid (4, 4) transform."""
    m = np.asarray(matrix, dtype=np.float64)
    if not is_rigid(m):
        raise ValueError(f'not a rigid (4, 4) transform: {m.tolist()}')
    quaternion: NDArray[np.float64] = Rotation.from_matrix(m[:3, :3]).as_quat(canonical=True)
    return quaternion
