# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Time the accumulation and re-segmentation of a submap over an hour of driving.

Run: python benchmarks/incremental.py [--minutes 60] [--json OUT]

A robot tours a large office building for five minutes and then repeats the tour, each time with
new noise. Times are CPU times of one core: re-segmentations in the last part of the first round
are compared with those at the same places in the last round, and with segmentations from scratch.
"""

import argparse
import json
from pathlib import Path
import time

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.segmentation import SubmapSegmenter, segment_submap
from fpnet_core.submaps import SubmapBuilder
from fpnet_lab.sim.recording import RecordingOptions, make_recording
from fpnet_lab.sim.sensors import sensor_named
from fpnet_lab.sim.tours import TourLimits

SEED, FAMILY, ROOMS = 5, 'racetrack', (40, 80)
TOUR = TourLimits(rooms=24, shortest_s=280.0, longest_s=420.0)
SCAN_POINTS = 25_000
STEP = 5  # every so many sweeps is added: two a second
TICK = 2  # scans between two re-segmentations: one a second
NOISE_M = 0.01
COMPARED = 0.5  # the last share of a round


def drive():
    """Return deskewed scans of one round: points (P, 3) float32 and true poses (4, 4)."""
    options = RecordingOptions(
        family=FAMILY, rooms=ROOMS, lidar=sensor_named('beams64'), limits=TOUR
    )
    recording = make_recording(SEED, options)
    period_s = recording.lidar.model.period_s
    scans = []
    for index in range(0, len(recording), STEP):
        scan = recording.scan(index)
        R, origin = recording.tour.sensor_poses(index * period_s + scan.time_s)
        world = np.einsum('pij,pj->pi', R, scan.points) + origin
        pose = scan.T_truth_sensor
        points = (world - pose[:3, 3]) @ pose[:3, :3]
        scans.append((points.astype(np.float32), pose))
    return scans, recording.tour.duration_s


def cpu_ms(call):
    """Return the call's result and its CPU time [ms]."""
    start = time.process_time()
    result = call()
    return result, 1e3 * (time.process_time() - start)


class Run:
    """One robot: repeats rounds and keeps the times of the last one."""

    def __init__(self, config: FpnetConfig) -> None:
        self.config = config
        self.rng = np.random.default_rng(SEED)
        self.builder = SubmapBuilder(config.submap)
        self.segmenter = SubmapSegmenter()
        self.stamp_ns = 0
        self.explored_m2 = 0.0
        self.rooms = 0

    def round(self, scans, is_timed):
        """Drive one round; returns CPU times [ms] of add_scan, update and from scratch."""
        added, updated, scratch = [], [], []
        first = (1.0 - COMPARED) * len(scans)
        for k, (points, pose) in enumerate(scans):
            noisy = points + self.rng.normal(0.0, NOISE_M, points.shape).astype(np.float32)
            chosen = self.rng.permutation(len(noisy))[:SCAN_POINTS]
            self.stamp_ns += 10**8
            cloud, stamp_ns = noisy[np.sort(chosen)], self.stamp_ns
            _, ms = cpu_ms(lambda c=cloud, p=pose, s=stamp_ns: self.builder.add_scan(c, p, s))
            added.append(ms)
            if is_timed and k % TICK == 0:
                submap = self.builder.take()
                (found, self.segmenter), ms = cpu_ms(lambda s=submap: self.segmenter.update(s))
                self.explored_m2, self.rooms = submap.free_area_m2, len(found.rooms)
                if k >= first:
                    updated.append(ms)
        if is_timed:
            _, ms = cpu_ms(lambda: segment_submap(submap))
            scratch.append(ms)
        return added, updated, scratch


def main() -> None:
    """Print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=60.0)
    parser.add_argument('--json', type=Path)
    arguments = parser.parse_args()
    scans, duration_s = drive()
    run = Run(FpnetConfig())
    rounds = max(2, round(arguments.minutes * 60.0 / duration_s))
    timed = {0, rounds - 1}
    results = []
    for number in range(rounds):
        result = run.round(scans, number in timed or number == rounds - 2)
        if number in timed:
            results.append(result)
    (added, early, scratch), (_, late, _) = results
    report = {
        'round_minutes': duration_s / 60.0,
        'minutes': rounds * duration_s / 60.0,
        'explored_m2': run.explored_m2,
        'rooms': run.rooms,
        'scan_points': SCAN_POINTS,
        'add_scan_ms': summary(added),
        'resegment_ms_first_round': summary(early),
        'resegment_ms_last_round': summary(late),
        'last_over_first': float(np.median(late) / np.median(early)),
        'from_scratch_ms': float(scratch[0]),
    }
    print(json.dumps(report, indent=1))
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(report, indent=1) + '\n', encoding='utf-8')


def summary(values):
    """Return median and 95th percentile."""
    return {'p50': float(np.median(values)), 'p95': float(np.quantile(values, 0.95))}


if __name__ == '__main__':
    main()
