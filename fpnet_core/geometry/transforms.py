# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar transform groups: SE2 is a Similarity2D, which is an Affine2D.

``T_a_b`` maps coordinates in ``b`` to ``a``, so that inner frame names cancel in chains:
``T_map_base = T_map_odom @ T_odom_base``. Composition returns the more general class of the
two factors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.geometry.angles import rotation
from fpnet_core.geometry.polar import heading_of, scale_of, stretch_of

Array = NDArray[np.float64]

# Numerical: relative deviation from the group that the constructor accepts (rounding in long
# chains).
_GROUP_TOLERANCE = 1e-6
_SINGULAR = 1e-12  # numerical: a smaller determinant or scale counts as zero


@dataclass(frozen=True, eq=False)
class Affine2D:
    """
    Affine map ``p_a = linear @ p_b + translation``.

    Parameters
    ----------
    linear : (2, 2) float64, invertible
    translation : (2,) float64, in the units of frame ``a``

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite, or ``linear`` leaves the class's group.
    """

    linear: Array
    translation: Array

    def __post_init__(self) -> None:
        """Copy, check and freeze both arrays."""
        linear = np.array(self.linear, dtype=np.float64)
        translation = np.array(self.translation, dtype=np.float64)
        if linear.shape != (2, 2) or translation.shape != (2,):
            raise ValueError(
                f'expected linear (2, 2) and translation (2,), got {linear.shape} '
                f'and {translation.shape}'
            )
        if not (np.isfinite(linear).all() and np.isfinite(translation).all()):
            raise ValueError('transform contains NaN or infinity')
        self._check_group(linear)
        linear.setflags(write=False)
        translation.setflags(write=False)
        object.__setattr__(self, 'linear', linear)
        object.__setattr__(self, 'translation', translation)

    @classmethod
    def _check_group(cls, linear: Array) -> None:
        if abs(np.linalg.det(linear)) < _SINGULAR:
            raise ValueError('linear part is singular')

    @classmethod
    def identity(cls) -> Self:
        """Return the identity map."""
        return cls(np.eye(2), np.zeros(2))

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Self:
        """Build from a (2, 3) or homogeneous (3, 3) matrix."""
        m = np.asarray(matrix, dtype=np.float64)
        if m.shape not in ((2, 3), (3, 3)):
            raise ValueError(f'expected a (2, 3) or (3, 3) matrix, got {m.shape}')
        return cls(np.array(m[:2, :2]), np.array(m[:2, 2]))

    @property
    def matrix(self) -> Array:
        """Homogeneous (3, 3) matrix."""
        m = np.eye(3)
        m[:2, :2] = self.linear
        m[:2, 2] = self.translation
        return m

    @property
    def is_mirrored(self) -> bool:
        """Whether the map mirrors (negative determinant)."""
        return bool(np.linalg.det(self.linear) < 0.0)

    @property
    def heading(self) -> float:
        """Rotation [rad] of the polar form ``linear = stretch @ R(heading)``."""
        return float(heading_of(self.linear))

    @property
    def scale(self) -> float:
        """Mean scale: length in ``a`` over length in ``b``."""
        return float(scale_of(self.linear))

    @property
    def stretch(self) -> Array:
        """Symmetric part (2, 2) of the polar form, in the axes of frame ``a``."""
        return stretch_of(self.linear)

    def apply(self, xy: ArrayLike) -> Array:
        """Map points ``xy (..., 2)`` from frame ``b`` to frame ``a``; may be empty."""
        return np.asarray(xy, dtype=np.float64) @ self.linear.T + self.translation

    def apply_yaw(self, yaw_rad: float) -> float:
        """Map a heading [rad]: return the direction in ``a`` of the mapped unit vector."""
        d = self.linear @ np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
        return float(np.arctan2(d[1], d[0]))

    def inv(self) -> Self:
        """Return ``T_b_a``."""
        inverse = np.asarray(np.linalg.inv(self.linear), dtype=np.float64)
        return type(self)(inverse, -inverse @ self.translation)

    def __matmul__(self, other: Any) -> Any:
        """Compose ``T_a_b @ T_b_c = T_a_c``; the result has the more general class."""
        if not isinstance(other, Affine2D):
            return NotImplemented
        cls = type(self) if issubclass(type(other), type(self)) else type(other)
        return cls(self.linear @ other.linear, self.linear @ other.translation + self.translation)


@dataclass(frozen=True, eq=False)
class Similarity2D(Affine2D):
    """Rotation, uniform positive scale and translation, without mirroring."""

    @classmethod
    def _check_group(cls, linear: Array) -> None:
        scale = float(np.hypot(linear[0, 0], linear[1, 0]))
        rotation = np.array([[linear[0, 0], -linear[1, 0]], [linear[1, 0], linear[0, 0]]])
        if scale < _SINGULAR or np.abs(linear - rotation).max() > _GROUP_TOLERANCE * scale:
            raise ValueError(f'linear part is not a scaled rotation: {linear.tolist()}')

    @classmethod
    def from_scale_yaw(cls, scale: float, yaw_rad: float, xy: ArrayLike) -> Similarity2D:
        """Build from scale, rotation [rad] and translation ``xy (2,)``."""
        c, s = scale * np.cos(yaw_rad), scale * np.sin(yaw_rad)
        return Similarity2D(np.array([[c, -s], [s, c]]), np.asarray(xy, dtype=np.float64))

    @property
    def scale(self) -> float:
        """Exact uniform scale: length in ``a`` over length in ``b``."""
        return float(np.hypot(self.linear[0, 0], self.linear[1, 0]))

    @property
    def yaw(self) -> float:
        """Rotation [rad] in (-pi, pi]."""
        return float(np.arctan2(self.linear[1, 0], self.linear[0, 0]))


@dataclass(frozen=True, eq=False)
class SE2(Similarity2D):
    """Rigid planar motion."""

    @classmethod
    def _check_group(cls, linear: Array) -> None:
        super()._check_group(linear)
        scale = np.hypot(linear[0, 0], linear[1, 0])
        if abs(scale - 1.0) > _GROUP_TOLERANCE:
            raise ValueError(f'rigid transform has scale {scale:.9f}')

    @classmethod
    def from_xy_yaw(cls, x: float, y: float, yaw_rad: float) -> SE2:
        """Build from translation [m] and rotation [rad]."""
        return SE2(rotation(yaw_rad), np.array([x, y], dtype=np.float64))

    @classmethod
    def from_matrix4(cls, matrix: ArrayLike) -> SE2:
        """
        Project a rigid 3D transform (4, 4) to the ground plane: x, y and the yaw of its x axis.

        Roll, pitch and z are dropped; the caller ensures that the frames are gravity-aligned.
        """
        m = np.asarray(matrix, dtype=np.float64)
        if m.shape != (4, 4):
            raise ValueError(f'expected a (4, 4) matrix, got {m.shape}')
        return cls.from_xy_yaw(m[0, 3], m[1, 3], float(np.arctan2(m[1, 0], m[0, 0])))

    @property
    def x(self) -> float:
        """Translation along x [m]."""
        return float(self.translation[0])

    @property
    def y(self) -> float:
        """Translation along y [m]."""
        return float(self.translation[1])

    def as_matrix4(self, z_m: float = 0.0) -> Array:
        """Return the homogeneous (4, 4) matrix at height ``z_m``."""
        m = np.eye(4)
        m[:2, :2] = self.linear
        m[:2, 3] = self.translation
        m[2, 3] = z_m
        return m
