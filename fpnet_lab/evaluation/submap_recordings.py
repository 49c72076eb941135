# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Short simulated drives, registered by the product's own odometry and kept on disk.

The submap benchmark needs what a robot would have: deskewed sweeps with the poses that KISS-ICP
gave them, drift included. Registration costs most of the benchmark's time, so its result is kept
as millimetres in a folder and read back on the next run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import hashlib
from pathlib import Path
from typing import Any
import zipfile

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2
from fpnet_core.odometry import KissOdometry
from fpnet_lab.sim.explore import fit_rigid
from fpnet_lab.sim.recording import Recording, RecordingOptions, make_recording
from fpnet_lab.sim.sensors import sensor_named
from fpnet_lab.sim.tours import TourLimits
from fpnet_lab.sim.types import BuildingPlan

Array = NDArray[np.float64]

SENSOR_NAMES = ('beams16', 'beams32', 'beams64', 'dome', 'planar')
"""Sensor models that drives are made with; ``dome`` does not repeat its pattern."""

# Chosen, not measured:
# Every sweep is registered; each of so many is kept for the submap.
_KEEP_EVERY = 3
_MM_PER_M = 1000.0  # physical: by definition
_LIMITS = TourLimits(rooms=4, shortest_s=30.0, longest_s=60.0)
_ROOMS = (10, 30)
_ARRAYS = ('points_mm', 'counts', 'T_odom_sensor', 'stamps_ns')


@dataclass(frozen=True, eq=False)
class Drive:
    """
    A registered drive and the building it went through.

    ``points_mm (P, 3) int16`` holds the sweeps one after another in their sensor frames,
    ``counts (S,)`` how many points each has; ``T_odom_sensor (S, 4, 4)`` is the odometry's,
    ``T_building_odom`` takes its path to the true one best: where the odometry's frame lies is no
    property of the map, and what bends the map inside of it still counts.
    """

    plan: BuildingPlan
    T_building_odom: SE2
    points_mm: NDArray[np.int16]
    counts: NDArray[np.int64]
    T_odom_sensor: Array
    stamps_ns: NDArray[np.int64]

    def __iter__(self) -> Iterator[tuple[NDArray[np.float32], Array, int]]:
        """Yield points (P, 3) float32 [m], ``T_odom_sensor (4, 4)`` and stamp of each sweep."""
        sweeps = np.split(self.points_mm, np.cumsum(self.counts)[:-1])
        for points, pose, stamp_ns in zip(
            sweeps, self.T_odom_sensor, self.stamps_ns.tolist(), strict=True
        ):
            yield points.astype(np.float32) / np.float32(_MM_PER_M), pose, stamp_ns


def registered_drive(seed: int, sensor: str, config: FpnetConfig, work: Path | None) -> Drive:
    """
    Return the drive of ``seed`` with a sensor, from ``work`` if it is there.

    Parameters
    ----------
    seed : equal seeds give the same building, furniture and tour for every sensor
    sensor : one of ``SENSOR_NAMES``
    config : odometry settings
    work : folder that keeps registered drives; None keeps nothing

    Raises
    ------
    ConfigError
        If no building with such a tour comes out of the seed.
    """
    options = RecordingOptions(rooms=_ROOMS, lidar=sensor_named(sensor), limits=_LIMITS)
    recording = make_recording(seed, options, threads=1)
    drive = None
    path = None if work is None else work / f'{_fingerprint(recording, config)}.npz'
    if path is not None and path.exists():
        drive = _read(path, recording)
    if drive is None:
        drive = _register(recording, KissOdometry(config.odometry))
        if path is not None:
            _write(path, drive)
    return drive


def _fingerprint(recording: Recording, config: FpnetConfig) -> str:
    """Return a name that differs where building, tour, sensor or odometry settings do."""
    digest = hashlib.sha256(f'{recording.lidar.model} {config.odometry} {_KEEP_EVERY}'.encode())
    for part in recording.building.parts:
        digest.update(part.vertices.astype(np.float32).tobytes())
    digest.update(recording.truth().astype(np.float32).tobytes())
    return digest.hexdigest()[:16]


def _read(path: Path, recording: Recording) -> Drive | None:
    """Return a kept drive, None where an interrupted run left half of it."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            arrays = {name: kept[name] for name in _ARRAYS}
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile):
        return None
    start = _placement(recording, arrays['T_odom_sensor'])
    return Drive(plan=recording.building.plan, T_building_odom=start, **arrays)


def _write(path: Path, drive: Drive) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, Any] = {name: getattr(drive, name) for name in _ARRAYS}
    np.savez(path, **arrays)


def _placement(recording: Recording, T_odom_sensor: Array) -> SE2:
    """Return ``T_building_odom`` from the poses (S, 4, 4) of the kept sweeps."""
    truth = recording.truth()[::_KEEP_EVERY][: len(T_odom_sensor)]
    yaw_true, yaw = (np.arctan2(T[:, 1, 0], T[:, 0, 0]) for T in (truth, T_odom_sensor))
    return fit_rigid(T_odom_sensor[:, :2, 3], truth[:, :2, 3], yaw_true - yaw)


def _register(recording: Recording, odometry: KissOdometry) -> Drive:
    points: list[NDArray[np.int16]] = []
    poses: list[Array] = []
    stamps: list[int] = []
    for index, scan in enumerate(recording):
        sweep = odometry.register_scan(scan)
        if index % _KEEP_EVERY == 0:
            points.append(np.rint(sweep.points * _MM_PER_M).astype(np.int16))
            poses.append(sweep.T_odom_sensor)
            stamps.append(scan.stamp_ns)
    return Drive(
        plan=recording.building.plan,
        T_building_odom=_placement(recording, np.array(poses)),
        points_mm=np.concatenate(points),
        counts=np.array([len(sweep) for sweep in points], dtype=np.int64),
        T_odom_sensor=np.array(poses),
        stamps_ns=np.array(stamps, dtype=np.int64),
    )
