#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
CPU time per scan and drift of lidar odometry for every simulated sensor.

Run: python benchmarks/recordings.py [--seeds 1] [--sensor NAME ...] [--building STYLE]
     [--bare] [--clouds timed|untimed|instant] [--json OUT]; then
fpnet bench figures recordings=OUT, once more with each further OUT of the same table

Drift is the motion error over 15 m of path, scaled to 100 m, for KISS-ICP with the product's
settings and for wheel odometry on the same tours. Times are CPU time per scan.
``--clouds``: clouds with point times; without, as from drivers of spinning sensors that omit them;
or of one instant, along rays without jitter, as from simulators.
``--bare``: plain walls, no furniture.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
import time
from typing import Any

import numpy as np

from fpnet_core.config import OdometryConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.io.scans import Scan
from fpnet_core.odometry import KissOdometry
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import lengths_along
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.sim.buildings.fittings import BUILDING_STYLES
from fpnet_lab.sim.drives.recording import Recording, RecordingOptions, make_recording
from fpnet_lab.sim.drives.scanning import sensor_poses_at
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.lidars.sensors import SENSORS

STRETCH_M = 15.0
SCAN, DRIFT = ('scan_ms', 'odometry_ms'), ('metres', 'degrees', 'end_m')
LIMITS = TourLimits(rooms=3, shortest_s=25.0, longest_s=45.0)


def scan_of(recording: Recording, index: int, clouds: str) -> Scan:
    """Return a scan in the form selected by ``--clouds``."""
    if clouds == 'instant':
        return replace(recording.deskewed(index), T_odom_sensor=None)
    scan = recording.scan(index)
    return scan if clouds == 'timed' else replace(scan, time_s=None)


def truth_of(recording: Recording, clouds: str) -> np.ndarray:
    """Return the true sensor poses (S, 4, 4) at the instants of the odometry poses."""
    half_ns = round(0.5 * recording.lidar.model.period_s * NS_PER_S) if clouds == 'untimed' else 0
    return sensor_poses_at(recording.tour, recording.stamps_ns - half_ns)


def register(recording: Recording, clouds: str) -> tuple[np.ndarray, float, float]:
    """Return KISS-ICP poses (S, 4, 4), and CPU seconds per scan for casting and registration."""
    odometry = KissOdometry(OdometryConfig())
    poses, cast_s, match_s = [], 0.0, 0.0
    for index in range(len(recording)):
        start = time.process_time()
        scan = scan_of(recording, index, clouds)
        middle = time.process_time()
        try:
            pose = odometry.register_scan(scan).T_odom_sensor
        except CloudFormatError:  # too few returns in range: repeat the last pose
            pose = poses[-1] if poses else np.eye(4)
        cast_s, match_s = cast_s + middle - start, match_s + time.process_time() - middle
        poses.append(pose)
    return np.array(poses), cast_s / len(recording), match_s / len(recording)


def drift(truth: np.ndarray, poses: np.ndarray) -> tuple[float, float, float]:
    """Return the mean drift [m] and [deg] per 100 m, and the error at the end [m]."""
    path_m = lengths_along(truth[:, :2, 3])
    first = np.flatnonzero(path_m <= path_m[-1] - STRETCH_M)[::5]
    last = np.searchsorted(path_m, path_m[first] + STRETCH_M)
    errors = [motion_error(truth[[i, j]], poses[[i, j]]) for i, j in zip(first, last, strict=True)]
    metres, degrees = np.mean(errors, axis=0) * (100.0 / STRETCH_M)
    return metres, degrees, motion_error(truth[[0, -1]], poses[[0, -1]])[0]


def motion_error(truth: np.ndarray, poses: np.ndarray) -> tuple[float, float]:
    """Return the planar error [m], [deg] of the motion between two poses (2, 4, 4)."""
    true_motion = np.linalg.inv(truth[0]) @ truth[1]
    error = np.linalg.inv(true_motion) @ np.linalg.inv(poses[0]) @ poses[1]
    return float(np.hypot(*error[:2, 3])), abs(float(np.rad2deg(np.arctan2(*error[1::-1, 0]))))


def measure(
    sensors: Iterable[str], options: RecordingOptions, seeds: int, clouds: str
) -> dict[str, dict[str, Any]]:
    """Return the results of each sensor, and of wheels, which have no scans."""
    rows: dict[str, dict[str, Any]] = {}
    wheels = []
    for name in sensors:
        model, found = SENSORS[name], []
        if clouds == 'instant':
            model = replace(model, angle_sigma_rad=0.0)
        for seed in range(seeds):
            recording = make_recording(seed, replace(options, lidar=model), threads=1)
            poses, cast_s, match_s = register(recording, clouds)
            truth = truth_of(recording, clouds)
            found.append([1e3 * cast_s, 1e3 * match_s, *drift(truth, poses)])
            wheels.append(drift(recording.truth(), recording.wheel_odometry()))
        rows[name] = {'rays': model.beams * model.columns}
        rows[name] |= _means((*SCAN, *DRIFT), found)
    nothing = dict.fromkeys(('rays', *SCAN))
    return rows | {'wheels, no lidar': nothing | _means(DRIFT, wheels)}


def _means(keys: Sequence[str], rows: Sequence[Sequence[float]]) -> dict[str, float]:
    return dict(zip(keys, np.mean(rows, axis=0).tolist(), strict=True))


def main() -> None:
    """Print a Markdown table with one row per sensor, and one for wheels."""
    parser = script_parser(__doc__)
    parser.add_argument('--seeds', type=int, default=1)
    parser.add_argument('--sensor', action='append', choices=sorted(SENSORS))
    parser.add_argument('--building', choices=sorted(BUILDING_STYLES), default='plain')
    parser.add_argument('--bare', action='store_true')
    parser.add_argument('--clouds', choices=('timed', 'untimed', 'instant'), default='timed')
    arguments = parser.parse_args()
    options = RecordingOptions(
        limits=LIMITS, style=BUILDING_STYLES[arguments.building], is_furnished=not arguments.bare
    )
    sensors = arguments.sensor or SENSORS
    measured = measure(sensors, options, arguments.seeds, arguments.clouds)
    finish('recordings', arguments.json, {'clouds': arguments.clouds, 'sensors': measured})


if __name__ == '__main__':
    main()
