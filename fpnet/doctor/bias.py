# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Systematic odometry errors: too small for half a second, significant over a recording.

Least squares over all motions estimates the distance ratio and direction offset of odometry
against scan registration, and the rotation that it adds per metre and per rotation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.doctor.findings import Finding, Problem

Array = NDArray[np.float64]

_SIGMAS = 3.0  # given: deviations of this many standard deviations are significant
# Chosen: tyres, loads and floors cause smaller errors, which the localizer tracks.
_WAY, _TURNED, _MOUNT_RAD, _DRIFT_RADPM = 0.1, 0.1, math.radians(5.0), math.radians(0.5)
# Chosen: least distance, rotation and number of motions for an estimate.
_FEWEST_M, _FEWEST_RAD, _FEWEST = 2.0, math.radians(90.0), 8


OPPOSITE = (
    'check how the lidar is mounted: upside down, it swaps left and right, and its static '
    'transform needs --roll 3.14159; else the rotation of the odometry has the wrong sign '
    '(swapped wheels, an IMU upside down)'
)
"""Fix if odometry and scans rotate in opposite directions."""


def check_bias(where: str, moved: Sequence[tuple[Array, Array]]) -> Iterator[Finding]:
    """
    Yield the systematic errors of the odometry on topic ``where``.

    ``moved`` are motions ``(4, 4)`` by odometry and by the scans, in the robot's axes.
    """
    way = np.array([[T[0, 3] + 1j * T[1, 3] for T in pair] for pair in moved]).reshape(-1, 2)
    driven_m = np.abs(way[:, 1])
    if len(way) < _FEWEST or driven_m.sum() < _FEWEST_M:
        return
    told = f'over {driven_m.sum():.0f} m, compared with the scans,'
    (factor,), (sigma,) = _fitted(way[:, 1:], way[:, 0])
    if _is_off(abs(factor) - 1.0, sigma, _WAY):
        fix = 'correct the wheel radius or the encoder ticks per revolution in its driver'
        yield _found(where, f'{told} it reports {abs(factor):.2f} times the distance', fix)
    if _is_off(float(np.angle(factor)), sigma, _MOUNT_RAD):
        turned_deg = math.degrees(np.angle(factor))
        fix = f'change the yaw of the static transform to the sensor by {turned_deg:.0f} degrees'
        yield _found(where, f'{told} it drives {abs(turned_deg):.0f} degrees to one side', fix)
    turn = np.array([[math.atan2(T[1, 0], T[0, 0]) for T in pair] for pair in moved])
    (drift, gain), sigmas = _fitted(np.stack([driven_m, turn[:, 1]], axis=1), turn[:, 0])
    if _is_off(float(drift), sigmas[0], _DRIFT_RADPM):
        fix = 'calibrate the gyro offset, or the ratio of the wheel radii'
        said = f'{told} it drifts in heading by {math.degrees(abs(drift)):.1f} degrees per metre'
        yield _found(where, said, fix)
    has_turned = np.abs(turn[:, 1]).sum() > _FEWEST_RAD
    if has_turned and _is_off(float(gain) - 1.0, sigmas[1], _TURNED):
        fix = 'correct the track width or the gyro scale in its driver'
        if gain < 0.0:
            fix = OPPOSITE
        yield _found(where, f'{told} it reports {float(gain):.2f} times the rotation', fix)


def _found(where: str, said: str, fix: str) -> Finding:
    return Finding(Problem.ODOMETRY, where, said, f'{fix}; meanwhile use KISS-ICP')


def _is_off(value: float, sigma: float, tolerated: float) -> bool:
    return abs(value) - _SIGMAS * sigma > tolerated


def _fitted(of: NDArray[Any], to: NDArray[Any]) -> tuple[Array, Array]:
    """Return the least-squares factors ``(F,)`` from ``of (N, F)`` to ``to (N,)``, and sigmas."""
    inverse = np.linalg.pinv(of)
    factors = inverse @ to
    left = np.linalg.norm(to - of @ factors) / math.sqrt(max(len(to) - of.shape[1], 1))
    return factors, np.asarray(left * np.linalg.norm(inverse, axis=1))
