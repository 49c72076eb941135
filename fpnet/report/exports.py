# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Export of a run: trajectories for evo, maps for map_server, a bag for Foxglove."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from fpnet.bag_writer import BagWriter
from fpnet.recordings.trajectories import write_covariances, write_tum
from fpnet.report.moments import shown_updates
from fpnet_core.geometry import SE2
from fpnet_core.io.maps import write_map
from fpnet_core.io.topic_names import TF_TOPIC
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.raster.warping import warped_grid
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import GridMap, LocalizerOutput, Submap

_MAP, _ODOM, _SENSOR = 'map', 'odom', 'sensor'
_TWIN = '/floorplan_pose_with_covariance'


def write_run_exports(
    folder: Path,
    plan: GridMap,
    outputs: tuple[LocalizerOutput, ...],
    published: PlanarTrajectory,
    covariances: NDArray[np.float64],
    odometry: PlanarTrajectory,
) -> None:
    """
    Write a run's trajectories, maps and bag into ``folder``.

    ``poses.tum`` holds all published poses in the plan frame and nominal metres,
    ``covariances.csv`` their covariances, ``odometry.tum`` the sensor's path. ``map.yaml`` is the
    floorplan at the scale of the last placement, ``submap.yaml`` the last submap, in the same
    frame if the robot is localized at the end. ``run.mcap`` holds all of it over time, of long
    runs only the submaps in the report. Existing files are replaced.

    Parameters
    ----------
    folder : output folder, created if missing
    plan : the floorplan that was used
    outputs : all updates in time order
    published : published poses, plan frame, nominal metres
    covariances : (S, 3, 3) of their x, y [m] and yaw [rad]
    odometry : the sensor's path in ``odom``
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_tum(folder / 'poses.tum', published.stamps_ns, published.xy, published.yaw)
    write_covariances(folder / 'covariances.csv', published.stamps_ns, covariances)
    write_tum(folder / 'odometry.tum', odometry.stamps_ns, odometry.xy, odometry.yaw)
    frame = final_map_frame(plan, outputs)
    scaled = warped_grid(plan, frame.A_map_plan)
    write_map(scaled, folder / 'map.yaml')
    last = next((o for o in reversed(outputs) if o.submap is not None), None)
    if last is not None and last.submap is not None:
        write_map(placed_submap(last, last.submap, frame), folder / 'submap.yaml')
    with TemporaryDirectory(dir=folder) as scratch:
        bag = Path(scratch) / 'run'
        stamped = zip(_rigid(published.mapped(frame.A_map_plan)), covariances, strict=True)
        _write_bag(bag, replace(scaled, frame=_MAP), outputs, stamped, odometry, frame)
        next(bag.glob('*.mcap')).replace(folder / 'run.mcap')


def final_map_frame(plan: GridMap, outputs: tuple[LocalizerOutput, ...]) -> MapFrame:
    """Return the frame ``map`` with the scale of the last accepted placement."""
    frame = MapFrame(plan)
    accepted = [o.A_plan_odom for o in outputs if o.A_plan_odom is not None]
    if accepted:
        frame = frame.followed(accepted[-1])
    return frame


def placed_submap(output: LocalizerOutput, submap: Submap, frame: MapFrame) -> GridMap:
    """Return the submap's grid in ``map`` if the update is localized, else in ``odom``."""
    grid = _in_odom(submap)
    if output.A_plan_odom is None:
        return grid
    T_map_odom = frame.T_map_odom(output.A_plan_odom, grid.T_frame_grid.translation)
    return replace(grid, T_frame_grid=T_map_odom @ grid.T_frame_grid, frame=_MAP)


def _write_bag(
    path: Path,
    scaled: GridMap,
    outputs: tuple[LocalizerOutput, ...],
    stamped: Iterable[tuple[tuple[int, NDArray[np.float64]], NDArray[np.float64]]],
    odometry: PlanarTrajectory,
    frame: MapFrame,
) -> None:
    """Write the bag; ``stamped`` are stamps, poses in ``map`` and covariances on the plan."""
    first = [*odometry.stamps_ns[:1].tolist(), *(output.stamp_ns for output in outputs[:1])]
    with BagWriter(path, storage='mcap') as bag:
        bag.write_grid('/map', min(first, default=0), scaled)
        for stamp_ns, T_odom_sensor in _rigid(odometry):
            bag.write_odometry('/odometry', stamp_ns, _ODOM, _SENSOR, T_odom_sensor)
            bag.write_transform(TF_TOPIC, stamp_ns, _ODOM, _SENSOR, T_odom_sensor)
        for (stamp_ns, T_map_sensor), cov_plan in stamped:
            cov = frame.covariance(cov_plan)
            bag.write_pose('/floorplan_pose', stamp_ns, _MAP, T_map_sensor)
            bag.write_uncertain_pose(_TWIN, stamp_ns, _MAP, T_map_sensor, cov)
        with_submap = set(shown_updates(outputs))
        for index, output in enumerate(outputs):
            _write_state(bag, output, frame)
            if index in with_submap and output.submap is not None:
                grid = _in_odom(output.submap)
                bag.write_grid('/localizer/submap', output.stamp_ns, grid)


def _write_state(bag: BagWriter, output: LocalizerOutput, frame: MapFrame) -> None:
    bag.write_text('/localizer/status', output.stamp_ns, output.status.value)
    bag.write_number('/localizer/probability', output.stamp_ns, output.probability)
    if 'total' in output.timings_ms:
        bag.write_number('/localizer/tick_ms', output.stamp_ns, output.timings_ms['total'])
    if output.A_plan_odom is not None and output.submap is not None:
        robot = _in_odom(output.submap).T_frame_grid.translation
        if len(output.submap.path_xy):
            robot = output.submap.T_odom_submap.apply(output.submap.path_xy[-1])
        T_map_odom = frame.T_map_odom(output.A_plan_odom, robot)
        bag.write_transform(TF_TOPIC, output.stamp_ns, _MAP, _ODOM, T_map_odom.as_matrix4())


def _in_odom(submap: Submap) -> GridMap:
    T_odom_grid: SE2 = submap.T_odom_submap @ submap.grid.T_frame_grid
    return replace(submap.grid, T_frame_grid=T_odom_grid, frame=_ODOM)


def _rigid(trajectory: PlanarTrajectory) -> list[tuple[int, NDArray[np.float64]]]:
    """Return stamps with (4, 4) transforms."""
    return [
        (int(stamp_ns), SE2.from_xy_yaw(float(x), float(y), float(yaw)).as_matrix4())
        for stamp_ns, (x, y), yaw in zip(
            trajectory.stamps_ns, trajectory.xy, trajectory.yaw, strict=True
        )
    ]
