# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Polar decomposition of linear maps of the plane, ``linear = stretch @ R(heading)``.

In closed form: ``R`` is the rotation for which ``stretch`` is symmetric with a trace >= 0.
If the map mirrors, one eigenvalue of ``stretch`` is negative.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def heading_of(linear: ArrayLike) -> NDArray[np.float64]:
    """Return the rotations ``(...)`` [rad] in linear maps ``(..., 2, 2)``, in [-pi, pi]."""
    a = np.asarray(linear, dtype=np.float64)
    turn = np.arctan2(a[..., 1, 0] - a[..., 0, 1], a[..., 0, 0] + a[..., 1, 1])
    return np.asarray(turn, dtype=np.float64)


def scale_of(linear: ArrayLike) -> NDArray[np.float64]:
    """Return the mean scales ``(...)`` of linear maps ``(..., 2, 2)``: ``sqrt(abs(det))``."""
    a = np.asarray(linear, dtype=np.float64)
    return np.asarray(np.sqrt(np.abs(np.linalg.det(a))), dtype=np.float64)


def stretch_of(linear: ArrayLike) -> NDArray[np.float64]:
    """Return the symmetric parts ``(..., 2, 2)`` of linear maps of that shape."""
    a = np.asarray(linear, dtype=np.float64)
    heading = heading_of(a)
    c, s = np.cos(heading), np.sin(heading)
    xx = a[..., 0, 0] * c - a[..., 0, 1] * s
    yy = a[..., 1, 0] * s + a[..., 1, 1] * c
    # Both terms are equal up to rounding; the mean makes the result exactly symmetric.
    xy = 0.5 * (a[..., 0, 0] * s + a[..., 0, 1] * c + (a[..., 1, 0] * c - a[..., 1, 1] * s))
    return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)
