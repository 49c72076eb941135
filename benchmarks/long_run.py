# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Duration of updates and memory over an hour of localization.

Run: python benchmarks/long_run.py [--minutes 60] [--every 5] [--tick-s 5] [--json OUT]; then
fpnet bench figures long_run=OUT

A robot tours a large office building and then drives the tour back and forth until the time is
up. Every sweep is cast at the true poses, because odometry without loop closure would drift too
far within an hour. Scans and updates run sequentially in sensor time, so that an update longer
than its period delays nothing. One of ``--every`` sweeps is used, with an update every
``--tick-s``, so that an hour takes minutes; a single call takes as long as in real time.
"""

from functools import partial
import time

import numpy as np

from fpnet_core.config import load_config
from fpnet_core.localizer import create_localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.localization.drives import resident_mb
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.speed.drive import FAMILY, ROOMS, SCAN_POINTS, SEED, TOUR

EARLY_MIN = 5.0
WINDOW_MIN = 2.0  # statistics cover this time before each mark


class LongRun:
    """A long run of one localizer with the durations of all calls."""

    def __init__(self, every, tick_s):
        config = load_config()
        self.every, self.period_ns = every, int(tick_s * NS_PER_S)
        self.recording = drive_through(FAMILY, 'beams64', SEED, rooms=ROOMS, limits=TOUR)
        self.localizer = create_localizer(config)
        self.localizer.set_plan(self.recording.floorplan)
        self.rng = np.random.default_rng(SEED)
        self.start_mb = resident_mb()
        self.adds, self.updates, self.memory = [], [], []  # rows: minute, wall ms, cpu ms

    def drive(self, minutes):
        """Run for ``minutes`` of sensor time."""
        period_s = self.recording.lidar.model.period_s
        next_update_ns = self.period_ns
        for number in range(0, int(minutes * 60.0 / period_s), self.every):
            stamp_ns = int((number + 1) * period_s * NS_PER_S)
            self.scan(self.index(number), stamp_ns)
            if stamp_ns >= next_update_ns:
                self.timed(self.updates, stamp_ns, partial(self.localizer.update, stamp_ns))
                self.memory.append((stamp_ns / 60e9, resident_mb()))
                next_update_ns += self.period_ns

    def index(self, number):
        """Return the tour's sweep index for a running number, back and forth along the tour."""
        last = len(self.recording) - 1
        place = number % (2 * last)
        return place if place <= last else 2 * last - place

    def scan(self, index, stamp_ns):
        """Cast a sweep, deskew it, and add it to the localizer."""
        scan = self.recording.deskewed(index)
        points = scan.points[np.sort(self.rng.permutation(len(scan.points))[:SCAN_POINTS])]
        add = partial(self.localizer.add_scan, points, scan.T_odom_sensor, stamp_ns)
        self.timed(self.adds, stamp_ns, add)

    @staticmethod
    def timed(rows, stamp_ns, call):
        """Call a function and record its time and duration."""
        wall, cpu = time.perf_counter(), time.process_time()
        call()
        took = time.perf_counter() - wall, time.process_time() - cpu
        rows.append((stamp_ns / 60e9, 1e3 * took[0], 1e3 * took[1]))

    def figures(self, until_min):
        """Return the statistics of the window that ends at a mark."""
        adds, updates = (
            np.array([row for row in rows if until_min - WINDOW_MIN < row[0] <= until_min])
            for rows in (self.adds, self.updates)
        )
        return {
            'minute': until_min,
            'tick_ms_p50': float(np.quantile(updates[:, 1], 0.5)),
            'tick_ms_p95': float(np.quantile(updates[:, 1], 0.95)),
            'tick_cpu_ms_p50': float(np.quantile(updates[:, 2], 0.5)),
            'tick_cpu_ms_p95': float(np.quantile(updates[:, 2], 0.95)),
            'add_scan_ms_p50': float(np.quantile(adds[:, 1], 0.5)),
            'add_scan_cpu_ms_p50': float(np.quantile(adds[:, 2], 0.5)),
            'rss_mb_max': max(mb for minute, mb in self.memory if minute <= until_min),
        }

    def report(self, minutes):
        """Return early and late statistics, their ratio, and the final state."""
        early, late = self.figures(min(EARLY_MIN, minutes)), self.figures(minutes)
        output = self.localizer.output
        return {
            'early': early,
            'late': late,
            'late_over_early_tick_cpu_p50': late['tick_cpu_ms_p50'] / early['tick_cpu_ms_p50'],
            'rss_mb_before': self.start_mb,
            'explored_m2': output.submap.free_area_m2 if output.submap else 0.0,
            'status': output.status.value,
            'is_localized': output.status is Status.LOCALIZED,
            'scan_points': SCAN_POINTS,
            'lap_s': self.recording.tour.duration_s,
        }


def main() -> None:
    """Run and print the report."""
    parser = script_parser(__doc__)
    parser.add_argument('--minutes', type=float, default=60.0)
    parser.add_argument('--every', type=int, default=5, help='use one of this many sweeps')
    parser.add_argument('--tick-s', type=float, default=5.0, help='sensor time between updates')
    arguments = parser.parse_args()
    run = LongRun(arguments.every, arguments.tick_s)
    run.drive(arguments.minutes)
    finish('long_run', arguments.json, run.report(arguments.minutes))


if __name__ == '__main__':
    main()
