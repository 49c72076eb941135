# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a drive through a large office costs: scans, rooms cut again, ticks that search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import load_config
from fpnet_core.localizer import Localizer, create_localizer
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.types import LocalizerOutput
from fpnet_lab.evaluation.speed.timing import Clocked, Figure, clocked, quantile_of
from fpnet_lab.sim.recording import Recording, RecordingOptions, make_recording
from fpnet_lab.sim.sensors import sensor_named
from fpnet_lab.sim.tours import TourLimits

# Chosen: about 930 m2 in seven minutes.
SEED, FAMILY, ROOMS = 5, 'racetrack', (40, 80)
# Chosen, with it:
_TOUR = TourLimits(rooms=24, shortest_s=280.0, longest_s=420.0)
_SCAN_POINTS = 25_000  # given: what the aim for a scan is stated for
_STEP = 5  # chosen: every so many sweeps is added: two a second
_TICK = 2  # chosen: scans between two ticks: one a second
_WARM_TICKS = 3  # numerical: ticks that are not counted

Array = NDArray[np.float64]


@dataclass
class _Times:
    """Durations [s] of calls, and of ticks by stage."""

    scans: list[Clocked] = field(default_factory=list)
    ticks: list[Clocked] = field(default_factory=list)
    segment: list[Clocked] = field(default_factory=list)
    segmenter: SubmapSegmenter = field(default_factory=SubmapSegmenter)
    explored_m2: float = 0.0

    def note(self, output: LocalizerOutput, took: Clocked) -> None:
        """Keep a tick's time where it looked for something, and that of cutting its submap."""
        if 'segment' not in output.timings_ms or output.submap is None:
            return
        self.ticks.append(took)
        submap = output.submap
        self.explored_m2 = submap.free_area_m2
        (_, self.segmenter), took = clocked(lambda: self.segmenter.update(submap))
        self.segment.append(took)


def drive_figures(seconds: float | None = None) -> tuple[list[Figure], float]:
    """
    Drive with true odometry, each tick searching the whole plan.

    Parameters
    ----------
    seconds : how much of the tour is driven; None: all of it

    Returns
    -------
    figures of ``add_scan``, of cutting the submap into rooms again and of whole ticks, and the
    explored area [m2]
    """
    recording = make_recording(
        SEED,
        RecordingOptions(family=FAMILY, rooms=ROOMS, lidar=sensor_named('beams64'), limits=_TOUR),
    )
    config = load_config(None, {'localizer.search_every_ticks': 1})
    localizer = create_localizer(config)
    localizer.set_plan(recording.floorplan)
    times = _driven(recording, localizer, seconds)
    figures = [
        quantile_of('add_scan, 25,000 points, p50', 0.005, times.scans, 0.5),
        quantile_of('cut the submap again, p50', None, times.segment, 0.5),
        quantile_of('cut the submap again, p95', 0.060, times.segment, 0.95),
        quantile_of('searching tick while exploring, p50', 0.030, times.ticks, 0.5),
        quantile_of('searching tick while exploring, p95', 0.100, times.ticks, 0.95),
    ]
    return figures, times.explored_m2


def _driven(recording: Recording, localizer: Localizer, seconds: float | None) -> _Times:
    times = _Times()
    for number, (points, pose, stamp_ns) in enumerate(_scans(recording, seconds)):
        _, took = clocked(partial(localizer.add_scan, points, pose, stamp_ns))
        times.scans.append(took)
        if number % _TICK == 0:
            times.note(*clocked(partial(localizer.tick, stamp_ns)))
    for listed in (times.scans, times.ticks, times.segment):
        del listed[:_WARM_TICKS]
    return times


def _scans(
    recording: Recording, seconds: float | None
) -> Iterator[tuple[NDArray[np.float32], Array, int]]:
    """Yield deskewed scans: points (P, 3), the true pose (4, 4) and the stamp."""
    rng = np.random.default_rng(SEED)
    period_s = recording.lidar.model.period_s
    last = len(recording) if seconds is None else min(len(recording), int(seconds / period_s))
    for index in range(0, last, _STEP):
        scan = recording.scan(index)
        assert scan.time_s is not None  # this sensor sweeps
        R, origin = recording.tour.sensor_poses(index * period_s + scan.time_s)
        world = np.einsum('pij,pj->pi', R, scan.points) + origin
        pose = np.asarray(scan.T_truth_sensor, dtype=np.float64)
        points = (world - pose[:3, 3]) @ pose[:3, :3]
        kept = np.sort(rng.permutation(len(points))[:_SCAN_POINTS])
        yield points[kept].astype(np.float32), pose, scan.stamp_ns
