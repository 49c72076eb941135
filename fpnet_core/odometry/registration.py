# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Registration of a sweep with components of KISS-ICP, separately for upright and level surfaces.

Beams that hit a level floor or ceiling form rings around the sensor, which move with it. In
point-to-point ICP the rings of two sweeps match best without motion and bias the estimate towards
standing still. Therefore x, y and yaw are estimated from upright surfaces only. Level surfaces
are then aligned from that pose, and only height, roll and pitch of the result are used.

Sweep and map are downsampled to the means of voxels that are fixed in the odometry frame.
KISS-ICP instead takes the first point of each voxel in a grid that moves with the sensor: the
points chosen on a bare wall move along, and rings match rings. Upright and level points are
averaged separately.
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
"""With fewer returns in range, the estimate is unreliable. Chosen."""

_COLUMN_M = 0.4
"""Width of the columns to classify surfaces [m]: the distance between rings. Chosen."""

_UPRIGHT_M = 0.3
"""
Returns with a larger height range in one column are upright [m]. Chosen: includes walls hit by
two of 16 beams at 8 m, excludes floors tilted by a third of a radian.
"""

_EDGE_M = 0.08
"""
Returns this close to a column's lowest and highest one may be floor or ceiling next to a wall and
are not upright [m]. Chosen: a few standard deviations of a lidar's ranges.
"""


# Given: by KISS-ICP, voxel sizes for registration and for the map update, in map voxels.
_SOURCE_VOXELS = 1.5
_MAP_VOXELS = 0.5  # given: see above


def register_sweep(kiss: KissICP, points: Array, T_guess: Array) -> Array:
    """
    Update ``kiss`` with one sweep; as its ``register_frame``, but by type of surface.

    Parameters
    ----------
    kiss
        Its pose, motion, threshold and map are updated.
    points : (P, 3)
        Deskewed points in range, sensor frame at the stamp [m].
    T_guess : (4, 4)
        Initial guess of the pose.

    Returns
    -------
    (Q, 3)
        Upright points that were added to the map, sensor frame [m].
    """
    in_odom = placed(points, T_guess)
    is_upright = upright(in_odom)
    surfaces = in_odom[is_upright], in_odom[~is_upright]
    standing, lying = (_downsampled(kiss, each, T_guess, _SOURCE_VOXELS) for each in surfaces)
    source = np.vstack([standing, lying])
    if len(standing) < MIN_POINTS:
        T_odom_sensor = _aligned(kiss, source, T_guess)
    else:
        T_standing = _aligned(kiss, standing, T_guess)
        level = lying if len(lying) >= MIN_POINTS else source
        T_odom_sensor = levelled(T_standing, _aligned(kiss, level, T_standing))
    for_map = [_downsampled(kiss, each, T_guess, _MAP_VOXELS) for each in surfaces]
    _update_state(kiss, T_guess, T_odom_sensor, np.vstack(for_map))
    return for_map[0]


def register_planar(kiss: KissICP, sweep: Array, T_guess: Array) -> Array:
    """
    Update ``kiss`` with one sweep ``(P, 3)`` of a planar scanner; as :func:`register_sweep`.

    All points for the map are also used for registration, as a single beam has few.
    """
    in_odom = placed(sweep, T_guess)
    in_odom[:, 2] = T_guess[2, 3]  # else rounding could split points between two voxels
    for_map = _downsampled(kiss, in_odom, T_guess, _MAP_VOXELS)
    _update_state(kiss, T_guess, _aligned(kiss, for_map, T_guess), for_map)
    return for_map


def deskewed(kiss: KissICP, sweep: Array, share: Array, motion: Array) -> Array:
    """
    Return points ``(P, 3)`` deskewed to the end of the sweep by KISS-ICP's preprocessor.

    Parameters
    ----------
    kiss
        Not changed.
    sweep : (P, 3)
        Raw points, sensor frame [m].
    share : (P,)
        Times of points in periods: from -1, a period before the sweep's end, to 0.
    motion : (4, 4)
        Motion of the sensor during one period.
    """
    # KISS-ICP uses the earliest and the latest point as the ends of the motion. Two NaN points,
    # which it drops, are added there.
    sweep = np.vstack([sweep, np.full((2, 3), np.nan)])
    share = np.append(np.maximum(share, -1.0), [-1.0, 0.0])
    return np.asarray(kiss.preprocessor.preprocess(sweep, share, motion))


def placed(points: Array, T_odom_sensor: Array) -> Array:
    """Transform points ``(P, 3)`` from the sensor to the odometry frame [m]."""
    moved: Array = points @ T_odom_sensor[:3, :3].T + T_odom_sensor[:3, 3]
    return moved


def upright(points: Array) -> NDArray[np.bool_]:
    """Return which points ``(P, 3)``, z up [m], are on upright surfaces, away from their ends."""
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
    Return ``T_place (4, 4)`` with height, roll and pitch of ``T_level``, z up.

    The z component of the small rotation vector between the two is dropped.
    """
    turn = Rotation.from_matrix(T_level[:3, :3] @ T_place[:3, :3].T).as_rotvec()
    T = T_place.copy()
    T[:3, :3] = Rotation.from_rotvec(turn * [1.0, 1.0, 0.0]).as_matrix() @ T_place[:3, :3]
    T[2, 3] = T_level[2, 3]
    return T


def _downsampled(kiss: KissICP, in_odom: Array, T_guess: Array, voxels: float) -> Array:
    """Return voxel means, in the sensor frame, of points in the odometry frame ``(P, 3)``."""
    means = voxel_means(in_odom, voxels * kiss.config.mapping.voxel_size)
    thinned: Array = (means - T_guess[:3, 3]) @ T_guess[:3, :3]
    return thinned


def _update_state(kiss: KissICP, T_guess: Array, T_odom_sensor: Array, for_map: Array) -> None:
    """Update pose, motion and threshold, and add the sweep's points to the map."""
    kiss.adaptive_threshold.update_model_deviation(np.linalg.inv(T_guess) @ T_odom_sensor)
    kiss.local_map.update(for_map, T_odom_sensor)
    kiss.last_delta = np.linalg.inv(kiss.last_pose) @ T_odom_sensor
    kiss.last_pose = T_odom_sensor


def _aligned(kiss: KissICP, source: Array, T_guess: Array) -> Array:
    """Return the pose ``(4, 4)`` that aligns a downsampled sweep with the map, from a guess."""
    sigma = kiss.adaptive_threshold.get_threshold()
    T: Array = kiss.registration.align_points_to_map(
        points=source,
        voxel_map=kiss.local_map,
        initial_guess=T_guess,
        max_correspondance_distance=3.0 * sigma,
        kernel=sigma,
    )
    return T
