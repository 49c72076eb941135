# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Motion during a sweep, and points without it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation


def carried(
    points: ArrayLike, T_a_b: NDArray[np.float64], share: ArrayLike
) -> NDArray[np.float64]:
    """
    Return every point moved by its own share of a motion: straight, and turning evenly.

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
    turned: NDArray[np.float64] = Rotation.from_rotvec(share[:, None] * turn).apply(points)
    return turned + share[:, None] * T_a_b[:3, 3]
