# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of a gyroscope against the scans: unit, sign, offset and axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet.doctor.motion import Pose
from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed
from fpnet_core.errors import OdometryError
from fpnet_core.geometry.gyro_track import MAX_GAP_NS
from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]

_FEWEST, _LEAST_RAD = 20, math.radians(45.0)  # chosen: least number of sweeps, and rotation
_LEFT = 0.5  # chosen: residual share of the mean square that means other axes
_DEGREES = 180.0 / math.pi  # given
_FACTOR_OFF, _OFFSET_RADPS = 0.1, math.radians(2.0)  # chosen: the scans' errors are smaller
_NEVER = 'it is not used until this is fixed'


def check_gyro(seen: Observed, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Yield the faults of the gyroscope, compared with the ``poses`` of the scans."""
    topic = seen.topic(seen.imu)
    if topic is None or len(seen.gyro_ns) < _FEWEST or not seen.sweeps:
        return
    sensor = seen.sweeps[0].frame
    try:
        R_imu_sensor = seen.tree.mount(topic.frames[0], sensor)[:3, :3]
    except OdometryError as error:
        if any(each.is_static for each in seen.transforms):  # else there are no static transforms
            yield Finding(
                Problem.FRAME,
                topic.frames[0] or seen.imu,
                f'{error}; the gyroscope on {seen.imu} is not used',
                'publish the static transform from the robot to the IMU',
            )
        return
    if len(poses) <= _FEWEST:
        return
    turns = _turns(seen, poses, R_imu_sensor)
    if len(turns) >= _FEWEST and np.abs(turns[:, 1]).sum() > _LEAST_RAD:
        yield from _scored(seen.imu, *turns.transpose(1, 0, 2))


def _turns(seen: Observed, poses: Sequence[Pose], R_imu_sensor: Array) -> Array:
    """
    Return rotations between sweeps by gyroscope and by scans, and durations ``(N, 3, A)``.

    Rotation vectors in the sensor frame [rad], for a planar scanner only the last axis; durations
    [s], repeated on every axis. Rates are summed, not composed: rates in degrees would wrap around
    several times between two sweeps.
    """
    stamps_ns, R = np.array([stamp_ns for stamp_ns, _ in poses]), np.array([T for _, T in poses])
    step_s = np.diff(seen.gyro_ns) / NS_PER_S
    steps = 0.5 * (seen.gyro_radps[1:] + seen.gyro_radps[:-1]) * step_s[:, None]
    # The last column counts gaps in the gyroscope data.
    sums = np.cumsum(np.column_stack([steps, step_s > MAX_GAP_NS / NS_PER_S]), axis=0)
    sums = np.vstack([np.zeros(4), sums])
    added = [
        np.interp(stamps_ns, seen.gyro_ns, each, left=np.nan, right=np.nan) for each in sums.T
    ]
    by_gyro = np.diff(np.stack(added, axis=1), axis=0)
    by_scans = Rotation.from_matrix(np.swapaxes(R[:-1, :3, :3], 1, 2) @ R[1:, :3, :3]).as_rotvec()
    seconds = np.repeat(np.diff(stamps_ns)[:, None] / NS_PER_S, 3, axis=1)
    found = np.stack([by_gyro[:, :3] @ R_imu_sensor, by_scans, seconds], axis=1)
    axes = slice(2, None) if seen.sweeps[0].is_planar else slice(None)
    return np.asarray(found[by_gyro[:, 3] == 0.0, :, axes])


def _scored(where: str, by_gyro: Array, by_scans: Array, seconds: Array) -> Iterator[Finding]:
    """Yield the difference between the rotations ``(N, A)`` of gyroscope and scans."""
    offsets = np.einsum('na,ab->nab', seconds, np.eye(seconds.shape[1])).reshape(by_scans.size, -1)
    given = np.column_stack([by_gyro.ravel(), offsets])  # the less noisy one
    # Minimum-norm fit of the error: a steady rotation does not separate offset from factor.
    (more, *offset), *_ = np.linalg.lstsq(given, (by_scans - by_gyro).ravel(), rcond=None)
    share = 1.0 + more
    left = by_scans.ravel() - given @ [share, *offset]
    if np.mean(left**2) > _LEFT * np.mean(by_scans**2) or not by_gyro.any():
        said = 'no multiple of its rotation fits that of the scans: it has other axes'
        fix = "correct the rotation of the static transform to the IMU, or the driver's axes"
        yield Finding(Problem.GYRO, where, said, f'{fix}; {_NEVER}')
        return
    factor = 1.0 / share
    offset_radps = float(np.linalg.norm(offset)) / abs(share)
    if abs(abs(factor) / _DEGREES - 1.0) < _FACTOR_OFF:
        said = f'it reports {factor:.0f} times the rotation of the scans: degrees'
        fix = 'make its driver publish angular_velocity in rad/s'
    elif factor < 0.0:
        said = f'it reports {factor:.2f} times the rotation of the scans'
        fix = 'it is upside down: correct the roll of the static transform to the IMU, or the sign'
    elif abs(factor - 1.0) > _FACTOR_OFF:
        said = f'it reports {factor:.2f} times the rotation of the scans'
        fix = "correct the gyroscope's scale in its driver"
    elif offset_radps > _OFFSET_RADPS:
        said = f'it has an offset of {math.degrees(offset_radps):.1f} degrees per second'
        fix = "calibrate the gyroscope's offset while the robot stands still"
    else:
        return
    yield Finding(Problem.GYRO, where, said, f'{fix}; {_NEVER}')
