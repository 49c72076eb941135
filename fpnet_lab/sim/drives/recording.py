# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A simulated recording: a building, a tour, lidar sweeps, and an inexact floorplan.

The robot's floorplan shows no furniture, has walls of a different thickness, is stretched by a
few per cent in x and y, and has its own resolution, origin and rotation. Ground truth is stored
separately from the robot's data: the bag's clouds and the floorplan contain none of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet.bag_writer import BagWriter, Storage
from fpnet.recordings.opening import BAG_NAME
from fpnet.recordings.trajectories import write_tum
from fpnet.recordings.truth import RESOLUTION_KEY, TRUTH_NAME, TRUTH_POSES_NAME
from fpnet_core.errors import BagFormatError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.io.scans import Scan
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import GridMap
from fpnet_lab.sim.buildings.building import Building
from fpnet_lab.sim.buildings.meshes import TriangleMesh
from fpnet_lab.sim.drives.drift import wheel_odometry
from fpnet_lab.sim.drives.driving import Tour
from fpnet_lab.sim.drives.imu import gyro_rates
from fpnet_lab.sim.drives.laser_scans import check_planar, laser_readings
from fpnet_lab.sim.drives.scanning import SimulatedScan, cast_scan, scan_stamps_ns, sensor_poses_at
from fpnet_lab.sim.drives.visits import RecordingOptions, generated_visit, mesh_visit, traced_visit
from fpnet_lab.sim.lidars.lidar import LidarSimulator

__all__ = [
    'CLOUD_TOPIC',
    'IMU_TOPIC',
    'LASER_TOPIC',
    'LIDAR_FRAME',
    'ODOMETRY_TOPIC',
    'TRUTH_TOPIC',
    'Recording',
    'RecordingOptions',
    'make_recording',
    'write_recording',
]

Array = NDArray[np.float64]

CLOUD_TOPIC, LASER_TOPIC = '/points', '/scan'
ODOMETRY_TOPIC = '/wheels/odometry'
IMU_TOPIC = '/imu'
TRUTH_TOPIC = '/ground_truth/pose'
LIDAR_FRAME, ODOM_FRAME = 'lidar', 'odom'
BUILDING_FRAME = 'building'

FLOORPLAN_NAME = 'floorplan.yaml'

Progress = Callable[[int, int], None]
"""Callback with the number of finished scans and their total."""


@dataclass(frozen=True, eq=False)
class Recording:
    """
    A simulated recording with scans cast on demand; equal indices give equal scans in any order.

    ``floorplan`` is the robot's input; ``A_plan_building`` maps true metres to nominal metres
    of the floorplan's frame ``plan``.
    """

    seed: int
    building: Building
    tour: Tour
    floorplan: GridMap
    A_plan_building: Affine2D
    lidar: LidarSimulator

    def __len__(self) -> int:
        """Return the number of scans."""
        return len(self.stamps_ns)

    def __iter__(self) -> Iterator[SimulatedScan]:
        """Yield the scans in time order."""
        return (self.scan(index) for index in range(len(self)))

    @property
    def stamps_ns(self) -> NDArray[np.int64]:
        """Time stamps ``(S,)`` [ns] of all scans: the ends of their sweeps."""
        return scan_stamps_ns(self.tour, self.lidar.model.period_s)

    def truth(self) -> Array:
        """Return ``T_building_sensor (S, 4, 4)`` at the stamps of all scans."""
        return sensor_poses_at(self.tour, self.stamps_ns)

    def wheel_odometry(self) -> Array:
        """Return drifting poses ``T_odom_sensor (S, 4, 4)`` at the stamps of all scans."""
        rng = np.random.default_rng((self.seed, len(self)))  # scans use the seeds up to here
        return wheel_odometry(self.truth(), rng)

    def gyro_rates(self) -> tuple[NDArray[np.int64], Array]:
        """Return stamps ``(K,)`` [ns] and rates ``(K, 3)`` [rad/s] of the lidar's gyroscope."""
        return gyro_rates(self.tour, np.random.default_rng((self.seed, len(self) + 1)))

    def summary(self) -> dict[str, Any]:
        """Return the recording's contents and its floorplan's distortion as a dict for JSON."""
        plan = self.building.plan
        return {
            'seed': self.seed,
            'family': plan.family,
            'rooms': len(plan.rooms),
            'doors': len(plan.doors),
            'tour_rooms': list(self.tour.rooms),
            'scans': len(self),
            'duration_s': round(self.tour.duration_s, 3),
            'path_m': round(self.tour.path_m, 3),
            'A_plan_building': self.A_plan_building.matrix[:2].tolist(),
            'truth_topic': TRUTH_TOPIC,
        }

    def scan(self, index: int) -> SimulatedScan:
        """
        Cast scan ``index``.

        Raises
        ------
        IndexError
            If there is no such scan.
        """
        if not 0 <= index < len(self):
            raise IndexError(f'scan {index} of a recording with {len(self)} scans')
        rng = np.random.default_rng((self.seed, index))
        return cast_scan(self.lidar, self.tour, index, rng)

    def deskewed(self, index: int) -> Scan:
        """
        Cast scan ``index`` and deskew it with ground truth poses.

        Its points are relative to the pose at its stamp; ``T_odom_sensor`` is that pose in
        ``building``.
        """
        scan = self.scan(index)
        T = scan.T_truth_sensor
        assert T is not None, 'a simulated scan has a pose'
        assert scan.time_s is not None, 'a simulated scan has point times'
        R, origin = self.tour.sensor_poses(index * self.lidar.model.period_s + scan.time_s)
        in_building = np.einsum('pij,pj->pi', R, scan.points.astype(np.float64)) + origin
        points = (in_building - T[:3, 3]) @ T[:3, :3]
        return Scan(scan.stamp_ns, points.astype(np.float32), T_odom_sensor=T)


def make_recording(
    seed: int,
    options: RecordingOptions | None = None,
    threads: int = 0,
    *,
    floorplan: GridMap | None = None,
    mesh: TriangleMesh | None = None,
) -> Recording:
    """
    Generate a building, a tour and a floorplan; scans are cast on demand.

    Parameters
    ----------
    seed : int
        Equal arguments give byte-identical recordings.
    options : RecordingOptions
    threads : int
        Threads for ray casting; no influence on the result. 0 uses all cores.
    floorplan : GridMap
        A user's drawing, whose building is extruded instead of a generated one.
    mesh : TriangleMesh
        A building's mesh, in metres with z up. ``floorplan`` shows it in the same x and y;
        without it, the floorplan is the mesh's free space.

    Raises
    ------
    ConfigError, MapFormatError
        If the family is unknown, the floorplan has no rooms, the mesh has no indoor space, or no
        tour is found.
    """
    options = options or RecordingOptions()
    if mesh is not None:
        visit = mesh_visit(seed, options, mesh, floorplan)
    elif floorplan is not None:
        visit = traced_visit(seed, options, floorplan)
    else:
        visit = generated_visit(seed, options)
    lidar = LidarSimulator(visit.building, options.lidar, threads)
    return Recording(
        seed, visit.building, visit.tour, visit.floorplan, visit.A_plan_building, lidar
    )


def write_recording(
    recording: Recording,
    out_dir: Path | str,
    *,
    storage: Storage = 'sqlite3',
    with_wheels: bool = False,
    with_imu: bool = False,
    laser_scans: bool = False,
    progress: Progress | None = None,
) -> None:
    """
    Write a recording to a folder.

    The folder contains ``bag`` (clouds on ``/points`` in frame ``lidar``, ground truth on
    ``/ground_truth/pose`` in frame ``building``), ``floorplan.yaml`` with its image, ``truth.tum``
    (planar sensor poses in ``building``; those in the bag include roll and pitch) and
    ``truth.json``, see :meth:`Recording.summary`.

    Parameters
    ----------
    recording : Recording
    out_dir : Path
        Created if missing; must not contain a bag.
    storage : 'sqlite3' or 'mcap'
    with_wheels : bool
        Adds wheel odometry on ``/wheels/odometry``, frames ``odom`` and ``lidar``; readers then
        use it instead of scan matching.
    with_imu : bool
        Adds the angular rates of a gyroscope in the lidar on ``/imu``.
    laser_scans : bool
        Writes LaserScans of a planar sensor on ``/scan`` instead of clouds.
    progress : callable
        Called after each scan with the number of written scans and their total.

    Raises
    ------
    BagFormatError
        If the folder contains a bag or is not writable.
    ConfigError
        If LaserScans are requested from a sensor that is not planar.
    """
    out_dir, model = Path(out_dir), recording.lidar.model
    planar = check_planar(model) if laser_scans else None
    if (out_dir / BAG_NAME).exists():
        raise BagFormatError(f'{out_dir / BAG_NAME} exists; remove it or choose another folder')
    out_dir.mkdir(parents=True, exist_ok=True)
    write_map(recording.floorplan, out_dir / FLOORPLAN_NAME)
    poses, height_m = recording.truth(), recording.tour.sensor_height_m
    yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    write_tum(out_dir / TRUTH_POSES_NAME, recording.stamps_ns, poses[:, :2, 3], yaw, height_m)
    topic = CLOUD_TOPIC if planar is None else LASER_TOPIC
    drawn = {'scan_topic': topic, RESOLUTION_KEY: recording.floorplan.resolution}
    text = json.dumps({**recording.summary(), **drawn}, indent=2) + '\n'
    (out_dir / TRUTH_NAME).write_text(text, encoding='utf-8')
    wheels = recording.wheel_odometry() if with_wheels else None
    rates = list(zip(*recording.gyro_rates(), strict=True)) if with_imu else []
    with BagWriter(out_dir / BAG_NAME, storage) as bag:
        for index, scan in enumerate(recording):
            while rates and rates[0][0] <= scan.stamp_ns:
                stamp_ns, rate = rates.pop(0)
                bag.write_imu(IMU_TOPIC, int(stamp_ns), LIDAR_FRAME, rate)
            if planar is None:
                _write_cloud(bag, scan, model.period_s)
            else:
                first_ns = scan.stamp_ns - round(model.period_s * NS_PER_S)
                readings = laser_readings(scan, planar)
                bag.write_laser_scan(LASER_TOPIC, first_ns, LIDAR_FRAME, readings)
            if scan.T_truth_sensor is not None:
                bag.write_pose(TRUTH_TOPIC, scan.stamp_ns, BUILDING_FRAME, scan.T_truth_sensor)
            if wheels is not None:
                bag.write_odometry(
                    ODOMETRY_TOPIC, scan.stamp_ns, ODOM_FRAME, LIDAR_FRAME, wheels[index]
                )
            if progress is not None:
                progress(index + 1, len(recording))


def _write_cloud(bag: BagWriter, scan: SimulatedScan, period_s: float) -> None:
    # The stamp is the end of the sweep, and point times are relative to the stamp.
    time_s = (scan.time_s - period_s).astype(np.float32) if scan.time_s is not None else None
    bag.write_cloud(
        CLOUD_TOPIC, scan.stamp_ns, LIDAR_FRAME, scan.points, scan.intensity, scan.ring, time_s
    )
