# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that turn at 50 degrees per second, and clouds of them as drivers stamp them."""

from functools import cache

import numpy as np
from short_recording import start_of_recording

from fpnet_lab.sim.drives.scanning import sensor_poses_at
from fpnet_lab.sim.lidars.sensors import LidarModel

PERIOD_NS = 100_000_000
SECONDS, SEED, OTHER_SEEDS = 15.0, 5, (6, 7)
STAMPS = ('start', 'middle', 'end')
_BEFORE_END = {'start': 1.0, 'middle': 0.5, 'end': 0.0}


@cache
def turning_recording(seed=SEED):
    """Return the start of a drive that turns for much of the time."""
    return start_of_recording(SECONDS, LidarModel(beams=16, columns=360), seed)


@cache
def _scans(seed):
    return list(turning_recording(seed))


def clouds(stamp, times, seed=SEED):
    """Yield header stamp [ns], points (P, 3) and the time field (P,), None where it is missing."""
    for scan in _scans(seed):
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


def yaw_errors_deg(stamps_ns, T_odom_sensor, seed=SEED):
    """Return by how much headings are ahead at the stamps that they came with (S,)."""
    truth = sensor_poses_at(turning_recording(seed).tour, np.asarray(stamps_ns))
    off = np.array(T_odom_sensor)[:, :2, :2] @ np.swapaxes(truth[:, :2, :2], 1, 2)
    off = off @ off[0].T
    return np.degrees(np.unwrap(np.arctan2(off[:, 1, 0], off[:, 0, 0])))


def lag_ms(stamps_ns, errors_deg, seed=SEED):
    """
    Return by how long headings are behind their stamps: by what the error changes with the rate.

    Over a second at a time, in which drift is no matter.
    """
    stamps_s = (np.asarray(stamps_ns) - stamps_ns[0]) / 1e9
    truth = sensor_poses_at(turning_recording(seed).tour, np.asarray(stamps_ns))
    rate = np.gradient(np.degrees(np.unwrap(np.arctan2(truth[:, 1, 0], truth[:, 0, 0]))), stamps_s)
    error, faster = (each[10:] - each[:-10] for each in (errors_deg, rate))
    return -1e3 * (error @ faster) / (faster @ faster)
