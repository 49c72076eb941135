#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localization of a lidar carried by a person, with and without a gyroscope.

Run: python benchmarks/walks.py ../shared/data/radish [--drives 20] [--seed 9500] [--workers 1]
     [--json OUT]; then fpnet bench figures walks=OUT

Walks through generated buildings on exact plans: 1.5 m/s, turn rates of about 150 degrees per
second at the 95th percentile, 280 at the 99th and 430 at most (``fpnet simulate recording --pace
walk``), with 32 and 16-beam lidars, a dome lidar and a planar scanner in turn. Odometry is

gyro
    KISS-ICP as in the odometry node, with the gyroscope of an IMU in the lidar;
scans
    the same without one;
kiss_icp
    the upstream package's ``KissICP`` with the same range, voxels and point times, for comparison
    only: its poses are not used for localization.

A walk is localized if its last pose is right, within 1 m and 10 degrees; a pose is wrong above 3 m
or 30 degrees. ``second_m`` and ``second_deg`` are the median odometry errors over 1 s of the walk;
``path`` is the ratio of estimated to true path length, and ``register_ms`` the CPU time per sweep.
From the folder's real laser log of Freiburg-079, a wheeled robot, odometry only gets the scans
(4 per second, without point times); the poses of the log are the ground truth.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
import functools
import json
from pathlib import Path
import time
from typing import Any

from faults import Faulty, figures
from generated_drives import FAMILIES, drives_parser
from kiss_icp.config import KISSConfig
from kiss_icp.kiss_icp import KissICP
import numpy as np

from fpnet.accuracy import pose_errors
from fpnet.cli.common import load
from fpnet.recordings.opening import open_scans
from fpnet_core.config import FpnetConfig
from fpnet_core.geometry.gyro_track import GyroTrack
from fpnet_core.io.scans import Scan
from fpnet_core.localizer import create_localizer, replay
from fpnet_core.odometry import KissOdometry
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.cli.reports import finish
from fpnet_lab.evaluation.fitted_truth import read_fitted_truth
from fpnet_lab.evaluation.localization.inputs import ROOMS, drive_through
from fpnet_lab.pool import each_done
from fpnet_lab.sim.drives.driving import WALK
from fpnet_lab.sim.drives.recording import Recording
from fpnet_lab.sim.drives.tours import TourLimits

TOUR = TourLimits(rooms=4, shortest_s=24.0, longest_s=50.0, motion=WALK)
SENSORS = ('beams32', 'beams16', 'dome', 'planar')
RIGHT_M, RIGHT_RAD = 1.0, np.deg2rad(10.0)
SECOND = 10  # sweeps
LOG = 'freiburg-079'


def with_gyro(recording: Recording, scans: list[Scan]) -> Iterator[Scan]:
    """Yield the scans with the orientation from a gyroscope."""
    track = GyroTrack()
    for stamp_ns, rate in zip(*recording.gyro_rates(), strict=True):
        track.add(int(stamp_ns), rate)
    for scan in scans:
        yield replace(scan, R_gyro_sensor=track.at(scan.stamp_ns))


def registered(scans: Iterator[Scan], config: FpnetConfig) -> Iterator[tuple[Scan, float]]:
    """Yield the scans with poses of our odometry, and the CPU time of each [s]."""
    odometry = KissOdometry(config.odometry)
    for scan in scans:
        began_s = time.process_time()
        sweep = odometry.register_scan(scan)
        took_s = time.process_time() - began_s
        yield Scan(scan.stamp_ns, sweep.points, T_odom_sensor=sweep.T_odom_sensor), took_s


def by_upstream(scans: list[Scan], config: FpnetConfig) -> Iterator[tuple[Scan, float]]:
    """Yield the scans with poses of the upstream class, and the CPU time of each [s]."""
    own = config.odometry
    data = {'max_range': own.max_range, 'min_range': own.min_range, 'deskew': True}
    is_planar = not np.ptp(scans[0].points[:, 2])
    voxel_size = own.planar_voxel_size if is_planar else own.voxel_size
    kiss = KissICP(KISSConfig(data=data, mapping={'voxel_size': voxel_size}))
    for scan in scans:
        began_s = time.process_time()
        time_s = np.zeros(0) if scan.time_s is None else scan.time_s
        kiss.register_frame(scan.points.astype(np.float64), time_s)
        took_s = time.process_time() - began_s
        yield Scan(scan.stamp_ns, scan.points, T_odom_sensor=kiss.last_pose.copy()), took_s


def odometry_figures(placed: list[tuple[Scan, float]], truth: np.ndarray) -> dict[str, float]:
    """Return the pose errors over 1 s, the path length ratio, and the CPU time."""
    poses = np.array([scan.T_odom_sensor for scan, _ in placed])
    by_poses, true = (np.linalg.inv(each[:-SECOND]) @ each[SECOND:] for each in (poses, truth))
    off = np.linalg.inv(true) @ by_poses
    path, true_path = (
        np.linalg.norm(np.diff(each[:, :3, 3], axis=0), axis=1).sum() for each in (poses, truth)
    )
    return {
        'second_m': float(np.median(np.linalg.norm(off[:, :2, 3], axis=1))),
        'second_deg': float(np.rad2deg(np.median(np.abs(np.arctan2(off[:, 1, 0], off[:, 0, 0]))))),
        'path': float(path / true_path),
        'register_ms': float(1e3 * np.median([took_s for _, took_s in placed])),
    }


def localised(
    recording: Recording, placed: list[tuple[Scan, float]], config: FpnetConfig
) -> dict[str, Any]:
    """Return the localizer's results for scans with odometry poses."""
    localizer = create_localizer(config)
    localizer.set_plan(recording.floorplan)
    scans = [scan for scan, _ in placed]
    published = replay(scans, localizer, config.localizer.update_period_s).published
    drive = Faulty(scans, recording.stamps_ns, int(recording.stamps_ns[0]), 0)
    truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    metres, radians = pose_errors(published.mapped(recording.A_plan_building.inv()), truth)
    is_right = (metres < RIGHT_M) & (radians < RIGHT_RAD)
    found = figures(recording, drive, published)
    kept = ('poses', 'off', 'wrong', 'first_m', 'median_m')
    return {
        **{name: found[name] for name in kept},
        'localised': bool(len(is_right) and is_right[-1]),
        'median_deg': float(np.rad2deg(np.median(radians))) if len(radians) else None,
    }


def walk(number: int, seed: int, config: FpnetConfig) -> dict[str, Any]:
    """Return the results of one walk with each odometry."""
    family, sensor = FAMILIES[number % len(FAMILIES)], SENSORS[number % len(SENSORS)]
    recording = drive_through(family, sensor, seed + number, rooms=ROOMS, limits=TOUR)
    scans, truth = list(recording), recording.truth()
    runs: dict[str, Callable[[], Iterator[tuple[Scan, float]]]] = {
        'gyro': lambda: registered(with_gyro(recording, scans), config),
        'scans': lambda: registered(iter(scans), config),
        'kiss_icp': lambda: by_upstream(scans, config),
    }
    found: dict[str, Any] = {}
    for name, run in runs.items():
        placed = list(run())
        found[name] = odometry_figures(placed, truth)
        if name != 'kiss_icp':
            found[name] |= localised(recording, placed, config)
    rates = np.abs(np.rad2deg(np.gradient(recording.tour.yaw_rad, recording.tour.time_s)))
    turns = [float(rate) for rate in np.percentile(rates, (95, 99, 100))]
    return {'seed': seed + number, 'family': family, 'sensor': sensor, 'turns': turns, **found}


def real_log(folder: Path, config: FpnetConfig) -> dict[str, Any]:
    """Return errors of scan-only odometry on a real log, relative to the log's poses."""
    scans = list(open_scans(read_fitted_truth(folder, LOG).log))
    truth = np.array([scan.T_odom_sensor for scan in scans])
    bare = [replace(scan, T_odom_sensor=None) for scan in scans]
    return {
        'scans': odometry_figures(list(registered(iter(bare), config)), truth),
        'kiss_icp': odometry_figures(list(by_upstream(bare, config)), truth),
    }


def sums(walks: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the totals of all walks with one odometry: sums of counts, medians otherwise."""
    total: dict[str, Any] = {'walks': len(walks)}
    for name in walks[0]:
        values = [each[name] for each in walks if each[name] is not None]
        is_count = name in ('poses', 'off', 'wrong', 'localised')
        total[name] = int(sum(values)) if is_count else float(np.median(values))
        if name in ('path', 'second_m'):
            total[f'{name}_max'] = float(max(values))
    return total


def main() -> None:
    """Print one line per walk and odometry, and the totals."""
    parser = drives_parser(__doc__, drives=20, seed=9500)
    parser.add_argument('folder', type=Path, help='the radish data folder')
    parser.add_argument('--workers', type=int, default=1)
    arguments = parser.parse_args()
    config = load(None, arguments.set)
    make = functools.partial(walk, seed=arguments.seed, config=config)
    walks = []
    for number, done in each_done(make, range(arguments.drives), arguments.workers):
        for name in ('gyro', 'scans', 'kiss_icp'):
            brief = {'walk': number, 'sensor': done['sensor'], 'odometry': name}
            print(json.dumps(brief | done[name]), flush=True)
        walks.append(done)
    totals = {name: sums([each[name] for each in walks]) for name in ('gyro', 'scans', 'kiss_icp')}
    log = real_log(arguments.folder, config)
    finish('walks', arguments.json, {'walks': walks, 'odometries': totals, 'log': log})


if __name__ == '__main__':
    main()
