# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Wheel odometry: dead reckoning that drifts as that of a differential drive does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import wrap_to_pi

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WheelErrors:
    """
    Standard deviations of what goes wrong.

    ``length`` and ``turn`` are relative errors of the wheels' radius and distance, drawn once;
    ``slip_rad_per_sqrt_m`` is a random walk of the heading, ``slip_turn`` the relative error of
    every single turn.
    """

    length: float = 0.01
    turn: float = 0.015
    slip_rad_per_sqrt_m: float = float(np.deg2rad(0.3))
    slip_turn: float = 0.05


def wheel_odometry(
    T_building_sensor: Array, rng: np.random.Generator, errors: WheelErrors | None = None
) -> Array:
    """
    Return drifting poses ``T_odom_sensor (S, 4, 4)`` of a sensor above the wheels' axle.

    Parameters
    ----------
    T_building_sensor : (S, 4, 4), the truth in equal steps
    rng : draws the errors
    errors : WheelErrors

    ``odom`` is the sensor's first pose; roll, pitch and height stay 0, as wheels do not feel them.
    """
    errors = errors or WheelErrors()
    yaw = np.unwrap(np.arctan2(T_building_sensor[:, 1, 0], T_building_sensor[:, 0, 0]))
    steps = np.diff(T_building_sensor[:, :2, 3], axis=0)
    heading = yaw[:-1] + np.diff(yaw) / 2.0
    ahead = steps[:, 0] * np.cos(heading) + steps[:, 1] * np.sin(heading)
    turned = np.diff(yaw)
    length, turn = 1.0 + rng.normal(0.0, (errors.length, errors.turn))
    slip = rng.normal(size=(2, len(ahead)))
    felt = turned * (turn + errors.slip_turn * slip[0])
    felt += errors.slip_rad_per_sqrt_m * np.sqrt(np.abs(ahead)) * slip[1]
    felt_yaw = np.concatenate([[0.0], np.cumsum(felt)])
    middle = felt_yaw[:-1] + felt / 2.0
    xy = np.cumsum((length * ahead)[:, None] * np.stack([np.cos(middle), np.sin(middle)], 1), 0)
    felt_yaw = wrap_to_pi(felt_yaw)
    poses = np.tile(np.eye(4), (len(yaw), 1, 1))
    c, s = np.cos(felt_yaw), np.sin(felt_yaw)
    poses[:, 0, 0], poses[:, 0, 1], poses[:, 1, 0], poses[:, 1, 1] = c, -s, s, c
    poses[1:, :2, 3] = xy
    return poses
