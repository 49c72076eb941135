# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drive through the planted building with a planar scanner and perfect odometry."""

from functools import cache
from itertools import pairwise

import numpy as np
from planted import building_cells

from fpnet_core.geometry import SE2
from fpnet_core.types import FREE

SCAN_NS = 200_000_000
# A drive through four rooms, in building metres.
VIA = [
    (2, 3), (3, 4), (3, 6), (8, 6), (8, 9), (8, 6), (9, 6), (9, 3), (9, 6), (17.3, 6), (17.3, 3),
]  # fmt: skip


def scan(xy, yaw, rng, rays=270, max_range=12.0):
    """Planar returns (P, 3) in the sensor frame at a pose in the building."""
    angles = np.linspace(-np.pi, np.pi, rays, endpoint=False) + rng.normal(0, 1e-3, rays)
    steps = np.arange(0.1, max_range, 0.03)
    along = np.stack([np.cos(angles + yaw), np.sin(angles + yaw)], axis=-1)
    cells = building_cells(np.asarray(xy) + along[:, None] * steps[:, None])
    blocked = cells != FREE
    hit = blocked.any(axis=1)
    ranges = steps[blocked.argmax(axis=1)] + rng.normal(0, 0.01, rays)
    local = np.stack([np.cos(angles), np.sin(angles), np.zeros(rays)], axis=-1)
    return (local * ranges[:, None])[hit].astype(np.float32)


def drive(step_m=0.4):
    """Poses (x, y, yaw) in the building along VIA."""
    poses = []
    for start, end in pairwise(VIA):
        delta = np.subtract(end, start)
        count = max(1, round(np.linalg.norm(delta) / step_m))
        yaw = np.arctan2(delta[1], delta[0])
        poses += [(*(np.asarray(start) + delta * k / count), yaw) for k in range(count)]
    return poses


@cache
def recorded():
    """Scans with odometry that starts at identity and knows nothing of the building."""
    rng = np.random.default_rng(0)
    first = None
    scans = []
    for index, (x, y, yaw) in enumerate(drive()):
        T_building_sensor = SE2.from_xy_yaw(x, y, yaw)
        first = first or T_building_sensor
        T_odom_sensor = first.inv() @ T_building_sensor
        points = scan((x, y), yaw, rng)
        scans.append((points, T_odom_sensor.as_matrix4(), (index + 1) * SCAN_NS))
    return scans


def standing(count=80):
    """Scans of a robot that stands in the middle of the drive, sixteen seconds of them."""
    rng, (x, y, yaw) = np.random.default_rng(1), drive()[40]
    return [(scan((x, y), yaw, rng), np.eye(4), (k + 1) * SCAN_NS) for k in range(count)]
