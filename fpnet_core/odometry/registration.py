# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Register a sweep with KISS-ICP's parts: what stands tells the place, what lies tells the level.

A beam that hits a level floor or ceiling draws a ring around the sensor, and the ring goes where
the sensor goes. Point to point, the rings of two sweeps agree best where nobody moved, and hold
the estimate back. So place and heading come from the returns of upright surfaces alone; then all
that lies flat is brought to the map from there, and of that only height, roll and pitch are
believed.

Sweep and map are thinned to the means of voxels that stay where they are in the odometry's frame.
KISS-ICP takes the first point of each voxel that moves with the sensor: what it takes of a bare
wall moves along, and rings hold on to rings. What stands and what lies do not meet in a mean.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet_core.geometry.voxels import voxel_means

if TYPE_CHECKING:
    from kiss_icp.kiss_icp import KissICP

Array = NDArray[np.float64]

MIN_POINTS = 100
"""Fewer returns within range than this move the estimate at random. Chosen."""

_COLUMN_M = 0.4
"""Width of the columns that surfaces are told apart in [m]: a step between rings. Chosen."""

_UPRIGHT_M = 0.3
"""
Returns that span more than this in one column stand upright [m]. Chosen: floors that are tilted
by a third of a radian do not, walls that two beams of 16 meet at 8 m do.
"""

_EDGE_M = 0.08
"""
As near to a column's lowest and highest return, floor and ceiling beside a wall are not told from
it [m]. Chosen: some deviations of a lidar's ranges.
"""


# Given: by KISS-ICP, what registers and what the map takes, over the voxels of its map.
_SOURCE_VOXELS = 1.5
_MAP_VOXELS = 0.5  # given: see above


def register_sweep(kiss: KissICP, points: Array, T_guess: Array) -> Array:
    """
    Move ``kiss`` on by one sweep; as its ``register_frame``, but surface by surface.

    Parameters
    ----------
    kiss
        Its pose, motion, threshold and map are brought up to date.
    points : (P, 3)
        In range, as seen from the place at the stamp, sensor frame [m].
    T_guess : (4, 4)
        Where that may be.

    Returns
    -------
    (Q, 3)
        What it takes of upright surfaces into its map, sensor frame [m].
    """
    in_odom = placed(points, T_guess)
    is_upright = upright(in_odom)
    surfaces = in_odom[is_upright], in_odom[~is_upright]
    standing, lying = (_thinned(kiss, each, T_guess, _SOURCE_VOXELS) for each in surfaces)
    source = np.vstack([standing, lying])
    if len(standing) < MIN_POINTS:
        T_odom_sensor = _aligned(kiss, source, T_guess)
    else:
        T_standing = _aligned(kiss, standing, T_guess)
        level = lying if len(lying) >= MIN_POINTS else source
        T_odom_sensor = levelled(T_standing, _aligned(kiss, level, T_standing))
    for_map = [_thinned(kiss, each, T_guess, _MAP_VOXELS) for each in surfaces]
    _move_on(kiss, T_guess, T_odom_sensor, np.vstack(for_map))
    return for_map[0]


def register_planar(kiss: KissICP, sweep: Array, T_guess: Array) -> Array:
    """
    Move ``kiss`` on by one sweep ``(P, 3)`` of a planar scanner; as :func:`register_sweep`.

    All that the map takes registers: a single beam has few points.
    """
    in_odom = placed(sweep, T_guess)
    in_odom[:, 2] = T_guess[2, 3]  # or rounding would part one voxel in two
    for_map = _thinned(kiss, in_odom, T_guess, _MAP_VOXELS)
    _move_on(kiss, T_guess, _aligned(kiss, for_map, T_guess), for_map)
    return for_map


def deskewed(kiss: KissICP, sweep: Array, share: Array, motion: Array) -> Array:
    """
    Return points ``(P, 3)`` as seen from the place of the sweep's end, by KISS-ICP's own means.

    Parameters
    ----------
    kiss
        Left as it is.
    sweep : (P, 3)
        As they came, sensor frame [m].
    share : (P,)
        When they were seen: -1 for a period before the sweep's end to 0.
    motion : (4, 4)
        Of the sensor during one period.
    """
    # KISS-ICP takes the first and the last point for the ends of the motion. Two that it drops,
    # as they are nowhere, stand there.
    sweep = np.vstack([sweep, np.full((2, 3), np.nan)])
    share = np.append(np.maximum(share, -1.0), [-1.0, 0.0])
    return np.asarray(kiss.preprocessor.preprocess(sweep, share, motion))


def placed(points: Array, T_odom_sensor: Array) -> Array:
    """Return points ``(P, 3)`` of the sensor in the odometry's frame [m]."""
    moved: Array = points @ T_odom_sensor[:3, :3].T + T_odom_sensor[:3, 3]
    return moved


def upright(points: Array) -> NDArray[np.bool_]:
    """Return which points ``(P, 3)``, z up [m], are of upright surfaces, clear of their ends."""
    row, col = np.floor(points[:, :2].T / _COLUMN_M).astype(np.int64)
    _, column = np.unique(row + (col << 32), return_inverse=True)
    z, low, high = points[:, 2], np.full(len(points), np.inf), np.full(len(points), -np.inf)
    np.minimum.at(low, column, z)
    np.maximum.at(high, column, z)
    low, high = low[column], high[column]
    is_clear = (z - low > _EDGE_M) & (high - z > _EDGE_M)
    is_upright: NDArray[np.bool_] = (high - low > _UPRIGHT_M) & is_clear
    return is_upright


def levelled(T_place: Array, T_level: Array) -> Array:
    """
    Return ``T_place (4, 4)`` at the height and tilt of ``T_level``, z up.

    The small turn from one to the other loses its part about z.
    """
    turn = Rotation.from_matrix(T_level[:3, :3] @ T_place[:3, :3].T).as_rotvec()
    T = T_place.copy()
    T[:3, :3] = Rotation.from_rotvec(turn * [1.0, 1.0, 0.0]).as_matrix() @ T_place[:3, :3]
    T[2, 3] = T_level[2, 3]
    return T


def _thinned(kiss: KissICP, in_odom: Array, T_guess: Array, voxels: float) -> Array:
    """Return means of voxels, in the sensor's frame, of points in the odometry's ``(P, 3)``."""
    means = voxel_means(in_odom, voxels * kiss.config.mapping.voxel_size)
    thinned: Array = (means - T_guess[:3, 3]) @ T_guess[:3, :3]
    return thinned


def _move_on(kiss: KissICP, T_guess: Array, T_odom_sensor: Array, for_map: Array) -> None:
    """Take the pose that was found, and the sweep's points into the map."""
    kiss.adaptive_threshold.update_model_deviation(np.linalg.inv(T_guess) @ T_odom_sensor)
    kiss.local_map.update(for_map, T_odom_sensor)
    kiss.last_delta = np.linalg.inv(kiss.last_pose) @ T_odom_sensor
    kiss.last_pose = T_odom_sensor


def _aligned(kiss: KissICP, source: Array, T_guess: Array) -> Array:
    """Return the pose ``(4, 4)`` that brings voxels of a sweep to the map, from a guess."""
    sigma = kiss.adaptive_threshold.get_threshold()
    T: Array = kiss.registration.align_points_to_map(
        points=source,
        voxel_map=kiss.local_map,
        initial_guess=T_guess,
        max_correspondance_distance=3.0 * sigma,
        kernel=sigma,
    )
    return T
