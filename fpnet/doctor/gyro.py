# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a gyroscope turns as the scans do: its unit, its sign, its offset and its axes."""

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

_FEWEST, _LEAST_RAD = 20, math.radians(45.0)  # chosen: fewer sweeps, or turns, tell nothing
_LEFT = 0.5  # chosen: of the mean square, what no factor and offset explain is of other axes
_DEGREES = 180.0 / math.pi  # given
_FACTOR_OFF, _OFFSET_RADPS = 0.1, math.radians(2.0)  # chosen: less is of the scans' own errors
_NEVER = 'it is not used until that is mended'


def check_gyro(seen: Observed, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Yield what is wrong with the gyroscope, by the ``poses`` of the scans."""
    topic = seen.topic(seen.imu)
    if topic is None or len(seen.gyro_ns) < _FEWEST or not seen.sweeps:
        return
    sensor = seen.sweeps[0].frame
    try:
        R_imu_sensor = seen.tree.mount(topic.frames[0], sensor)[:3, :3]
    except OdometryError as error:
        if any(each.is_static for each in seen.transforms):  # else nobody places anything here
            yield Finding(
                Problem.FRAME,
                topic.frames[0] or seen.imu,
                f'{error}; the gyroscope on {seen.imu} is not used',
                'publish where the IMU sits on the robot as a static transform',
            )
        return
    if len(poses) <= _FEWEST:
        return
    turns = _turns(seen, poses, R_imu_sensor)
    if len(turns) >= _FEWEST and np.abs(turns[:, 1]).sum() > _LEAST_RAD:
        yield from _scored(seen.imu, *turns.transpose(1, 0, 2))


def _turns(seen: Observed, poses: Sequence[Pose], R_imu_sensor: Array) -> Array:
    """
    Return turns between sweeps by the gyroscope and by the scans, and their times ``(N, 3, A)``.

    Rotation vectors in the sensor's frame [rad], or their last axis alone where a planar scanner
    sees no other one; times [s] on every axis. Rates are added up, not composed: in degrees they
    would go around several times from one sweep to the next.
    """
    stamps_ns, R = np.array([stamp_ns for stamp_ns, _ in poses]), np.array([T for _, T in poses])
    step_s = np.diff(seen.gyro_ns) / NS_PER_S
    steps = 0.5 * (seen.gyro_radps[1:] + seen.gyro_radps[:-1]) * step_s[:, None]
    # The last column counts gaps, over which rates tell nothing.
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
    """Yield how the turns ``(N, A)`` of a gyroscope differ from those of the scans."""
    offsets = np.einsum('na,ab->nab', seconds, np.eye(seconds.shape[1])).reshape(by_scans.size, -1)
    given = np.column_stack([by_gyro.ravel(), offsets])  # of both, it has less noise
    # What is wrong is fitted, and as small as can be: a steady turn tells no offset from a factor.
    (more, *offset), *_ = np.linalg.lstsq(given, (by_scans - by_gyro).ravel(), rcond=None)
    share = 1.0 + more
    left = by_scans.ravel() - given @ [share, *offset]
    if np.mean(left**2) > _LEFT * np.mean(by_scans**2) or not by_gyro.any():
        said = 'no multiple of its turns is those that the scans tell: it has other axes'
        fix = "mend the rotation of the static transform to the IMU, or the driver's axes"
        yield Finding(Problem.GYRO, where, said, f'{fix}; {_NEVER}')
        return
    factor = 1.0 / share
    offset_radps = float(np.linalg.norm(offset)) / abs(share)
    if abs(abs(factor) / _DEGREES - 1.0) < _FACTOR_OFF:
        said = f'it reports {factor:.0f} times the turns that the scans tell: degrees'
        fix = 'let its driver publish angular_velocity in rad/s'
    elif factor < 0.0:
        said = f'it reports {factor:.2f} times the turns that the scans tell'
        fix = 'it is upside down: mend the roll of the static transform to the IMU, or the sign'
    elif abs(factor - 1.0) > _FACTOR_OFF:
        said = f'it reports {factor:.2f} times the turns that the scans tell'
        fix = "set the gyroscope's scale in its driver"
    elif offset_radps > _OFFSET_RADPS:
        said = f'it turns by {math.degrees(offset_radps):.1f} degrees a second that nobody turned'
        fix = "calibrate the gyroscope's offset while the robot stands still"
    else:
        return
    yield Finding(Problem.GYRO, where, said, f'{fix}; {_NEVER}')
