# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot that turns at 50 degrees per second, and clouds of it as drivers stamp them."""

from functools import cache

import numpy as np
from short_recording import start_of_recording

from fpnet_lab.sim.scanning import sensor_poses_at
from fpnet_lab.sim.sensors import LidarModel

PERIOD_NS = 100_000_000
SECONDS, SEED = 15.0, 5
STAMPS = ('start', 'middle', 'end')
TIMES = ('absolute', 'relative', 'missing')
_BEFORE_END = {'start': 1.0, 'middle': 0.5, 'end': 0.0}


@cache
def turning_recording():
    """Return the start of a drive that turns for much of the time."""
    return start_of_recording(SECONDS, LidarModel(beams=16, columns=720), SEED)


@cache
def _scans():
    return list(turning_recording())


def clouds(stamp, times):
    """Yield header stamp [ns], points (P, 3) and the time field (P,), None where it is missing."""
    for scan in _scans():
        stamp_ns = scan.stamp_ns - round(_BEFORE_END[stamp] * PERIOD_NS)
        since_start_s = scan.time_s
        start_ns = scan.stamp_ns - PERIOD_NS
        if times == 'missing':
            yield stamp_ns, scan.points, None
        elif times == 'absolute':
            yield stamp_ns, scan.points, start_ns / 1e9 + since_start_s
        else:
            relative_s = since_start_s + (start_ns - stamp_ns) / 1e9
            yield stamp_ns, scan.points, relative_s.astype(np.float32)


def yaw_errors_deg(stamps_ns, T_odom_sensor):
    """Return by how much headings are off at the stamps that they came with (S,)."""
    truth = sensor_poses_at(turning_recording().tour, np.asarray(stamps_ns))
    first = sensor_poses_at(turning_recording().tour, np.asarray(stamps_ns[:1]))[0]
    errors = []
    for true, pose in zip(truth, T_odom_sensor, strict=True):
        apart = (np.linalg.inv(first) @ true)[:2, :2].T @ pose[:2, :2]
        errors.append(abs(np.degrees(np.arctan2(apart[1, 0], apart[0, 0]))))
    return np.array(errors)
