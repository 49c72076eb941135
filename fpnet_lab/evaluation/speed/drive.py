# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cost of a recording in a large office: scans, segmentation, updates with a search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from fpnet_core.config import load_config
from fpnet_core.io.scans import Scan
from fpnet_core.localizer import Localizer, create_localizer
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.types import LocalizerOutput
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.speed.timing import Clocked, Figure, clocked, quantile_of
from fpnet_lab.sim.drives.recording import Recording
from fpnet_lab.sim.drives.tours import TourLimits

# Chosen: about 930 m2 in seven minutes.
SEED, FAMILY, ROOMS = 5, 'racetrack', (40, 80)
# Chosen, for that recording:
TOUR = TourLimits(rooms=24, shortest_s=280.0, longest_s=420.0)
SCAN_POINTS = 25_000  # given: points per scan for which the aim is stated
_STEP = 5  # chosen: stride of the added sweeps: two a second
_TICK = 2  # chosen: scans per update: one update a second
_WARM_TICKS = 3  # numerical: first calls that are not counted


@dataclass
class _Times:
    """Durations [s] of scans, updates and segmentations."""

    scans: list[Clocked] = field(default_factory=list)
    updates: list[Clocked] = field(default_factory=list)
    segment: list[Clocked] = field(default_factory=list)
    segmenter: SubmapSegmenter = field(default_factory=SubmapSegmenter)
    explored_m2: float = 0.0

    def note(self, output: LocalizerOutput, took: Clocked) -> None:
        """Store the duration of a searching update, and time the segmentation of its submap."""
        if 'segment' not in output.timings_ms or output.submap is None:
            return
        self.updates.append(took)
        submap = output.submap
        self.explored_m2 = submap.free_area_m2
        (_, self.segmenter), took = clocked(lambda: self.segmenter.update(submap))
        self.segment.append(took)


def drive_figures(seconds: float | None = None) -> tuple[list[Figure], float]:
    """
    Replay a recording with true odometry; each update searches the whole plan.

    Parameters
    ----------
    seconds : duration of the part of the tour to replay; None: all of it

    Returns
    -------
    figures of ``add_scan``, of segmenting the submap and of whole updates, and the explored area
    [m2]
    """
    recording = drive_through(FAMILY, 'beams64', SEED, rooms=ROOMS, limits=TOUR)
    config = load_config(None, {'localizer.search_every_updates': 1})
    localizer = create_localizer(config)
    localizer.set_plan(recording.floorplan)
    times = _driven(recording, localizer, seconds)
    figures = [
        quantile_of('add_scan, 25,000 points, p50', 0.005, times.scans, 0.5),
        quantile_of('cut the submap again, p50', None, times.segment, 0.5),
        quantile_of('cut the submap again, p95', 0.060, times.segment, 0.95),
        quantile_of('searching tick while exploring, p50', 0.030, times.updates, 0.5),
        quantile_of('searching tick while exploring, p95', 0.100, times.updates, 0.95),
    ]
    return figures, times.explored_m2


def _driven(recording: Recording, localizer: Localizer, seconds: float | None) -> _Times:
    times = _Times()
    for number, scan in enumerate(_scans(recording, seconds)):
        assert scan.T_odom_sensor is not None, 'set by _scans'
        add = partial(localizer.add_scan, scan.points, scan.T_odom_sensor, scan.stamp_ns)
        times.scans.append(clocked(add)[1])
        if number % _TICK == 0:
            times.note(*clocked(partial(localizer.update, scan.stamp_ns)))
    for listed in (times.scans, times.updates, times.segment):
        del listed[:_WARM_TICKS]
    return times


def _scans(recording: Recording, seconds: float | None) -> Iterator[Scan]:
    """Yield scans with true odometry, of up to ``SCAN_POINTS`` points each."""
    rng = np.random.default_rng(SEED)
    period_s = recording.lidar.model.period_s
    last = len(recording) if seconds is None else min(len(recording), int(seconds / period_s))
    for index in range(0, last, _STEP):
        scan = recording.deskewed(index)
        kept = np.sort(rng.permutation(len(scan.points))[:SCAN_POINTS])
        yield replace(scan, points=scan.points[kept])
