# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Angles in radians, wrapped to (-pi, pi], and rotations by them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def wrap_to_pi(angle_rad: ArrayLike) -> NDArray[np.float64]:
    """Return the angle(s) wrapped to (-pi, pi], in the same shape."""
    return np.pi - np.mod(np.pi - np.asarray(angle_rad, dtype=np.float64), 2.0 * np.pi)


def angle_between(a_rad: ArrayLike, b_rad: ArrayLike) -> NDArray[np.float64]:
    """Return the absolute difference of two headings, in [0, pi]."""
    return np.abs(wrap_to_pi(np.asarray(a_rad) - np.asarray(b_rad)))


def rotation(angle_rad: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrices ``(..., 2, 2)`` of angles ``(...)``."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)
