# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Simulated odometry drift: wheel odometry of a robot, and scan-matching odometry of a walk.

Both integrate the true steps, each rotated by the heading error accumulated so far. They differ
in the model of that error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_lab.sim.config import ScanConfig

Array = NDArray[np.float64]

# Chosen, not measured:
WARP_WAVES = 3
WARP_LENGTHS_M = (25.0, 80.0)


@dataclass(frozen=True)
class WheelErrors:
    """
    Standard deviations of wheel odometry errors.

    ``length`` and ``turn`` are relative errors of wheel radius and wheel distance, sampled once;
    ``slip_rad_per_sqrt_m`` is the heading random walk, ``slip_turn`` the relative error of each
    rotation step.
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
    T_building_sensor : (S, 4, 4), ground truth in equal steps
    rng : random generator of the errors
    errors : WheelErrors

    ``odom`` is the sensor's first pose. Roll, pitch and height stay 0: wheels do not measure them.
    """
    errors = errors or WheelErrors()
    yaw = np.unwrap(np.arctan2(T_building_sensor[:, 1, 0], T_building_sensor[:, 0, 0]))
    steps = np.diff(T_building_sensor[:, :2, 3], axis=0)
    turned = np.diff(yaw)
    way = np.linalg.norm(steps, axis=1)
    length, turn = 1.0 + rng.normal(0.0, (errors.length, errors.turn))
    slip = rng.normal(size=(2, len(way)))
    felt = turned * (turn + errors.slip_turn * slip[0])
    felt += errors.slip_rad_per_sqrt_m * np.sqrt(way) * slip[1]
    error = np.concatenate([[0.0], np.cumsum(felt - turned)]) - yaw[0]
    poses = np.tile(np.eye(4), (len(yaw), 1, 1))
    c, s = np.cos(yaw + error), np.sin(yaw + error)
    poses[:, 0, 0], poses[:, 0, 1], poses[:, 1, 0], poses[:, 1, 1] = c, -s, s, c
    poses[1:, :2, 3] = _integrated(length * steps, (error[1:] + error[:-1]) / 2.0)
    return poses


def _integrated(steps: Array, error: Array) -> Array:
    """Return positions (S, 2) after steps (S, 2), each rotated by its heading error (S,)."""
    c, s = np.cos(error), np.sin(error)
    dx, dy = steps.T
    return np.asarray(np.cumsum(np.stack([c * dx - s * dy, s * dx + c * dy], axis=1), axis=0))


def estimate_walk(xy: Array, rng: np.random.Generator, config: ScanConfig) -> tuple[Array, Array]:
    """
    Return estimated positions (S, 2) and heading errors (S,) of a walk at positions (S, 2).

    Scan matching against a local map has errors that depend on the position, so that a revisited
    room looks the same, small errors that grow with the distance, and some jitter.
    """
    warped, bend = _warp(xy, rng, config)
    steps = np.diff(warped, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    rate = rng.uniform(*config.yaw_drift_rad)
    noise = rate * np.sqrt(lengths) * rng.standard_normal(len(steps))
    yaw = np.concatenate([[0.0], np.cumsum(noise)])
    factor = 1.0 + config.length_drift * rng.uniform(-1.0, 1.0)
    moved = _integrated(factor * steps, yaw[:-1])
    estimated = np.concatenate([warped[:1], warped[:1] + moved])
    jitter_m, jitter_rad = rng.uniform(*config.jitter_m), rng.uniform(*config.jitter_rad)
    estimated += jitter_m * rng.standard_normal(estimated.shape)
    return estimated, yaw + bend + jitter_rad * rng.standard_normal(len(yaw))


def _warp(xy: Array, rng: np.random.Generator, config: ScanConfig) -> tuple[Array, Array]:
    """Displace positions by a few long waves; return them and the local rotation [rad]."""
    warped, bend = xy.copy(), np.zeros(len(xy))
    strain = rng.uniform(*config.warp) / WARP_WAVES
    for _ in range(WARP_WAVES):
        a, b = rng.uniform(-np.pi, np.pi, 2)
        rate = 2.0 * np.pi / rng.uniform(*WARP_LENGTHS_M)
        wave = rate * np.array([np.cos(a), np.sin(a)])
        push = strain / rate * np.array([np.cos(b), np.sin(b)])
        phase = xy @ wave + rng.uniform(-np.pi, np.pi)
        warped += np.sin(phase)[:, None] * push
        bend += 0.5 * np.cos(phase) * (wave[0] * push[1] - wave[1] * push[0])
    return warped, bend
