# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated gyroscope in the lidar: angular rates of a tour with bias and noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet_core.stamps import NS_PER_S
from fpnet_lab.sim.drives.driving import Tour
from fpnet_lab.sim.drives.scanning import EPOCH_NS

Array = NDArray[np.float64]

RATE_HZ = 200
"""Chosen: inertial sensors in lidars report at 100 to 1000 Hz."""

_BIAS_RADPS = float(np.deg2rad(0.3))
"""Standard deviation of each axis' constant bias. Chosen: an uncalibrated MEMS sensor."""

_NOISE_RADPS = float(np.deg2rad(0.1))
"""Standard deviation of a rate at ``RATE_HZ``. Chosen: 0.007 deg/s/sqrt(Hz), MEMS."""


def gyro_rates(tour: Tour, rng: np.random.Generator) -> tuple[NDArray[np.int64], Array]:
    """
    Return stamps ``(K,)`` [ns] and angular rates ``(K, 3)`` [rad/s] in the sensor's frame.

    Each is the mean rate of the step that ends at its stamp; ``rng`` samples bias and noise.
    """
    count = int(tour.duration_s * RATE_HZ)
    time_s = np.arange(count + 1) / RATE_HZ
    R, _ = tour.sensor_poses(time_s)
    turns = Rotation.from_matrix(np.swapaxes(R[:-1], 1, 2) @ R[1:]).as_rotvec()
    rates = turns * RATE_HZ + rng.normal(0.0, _BIAS_RADPS, 3)
    rates += rng.normal(0.0, _NOISE_RADPS, rates.shape)
    return EPOCH_NS + np.round(time_s[1:] * NS_PER_S).astype(np.int64), rates
