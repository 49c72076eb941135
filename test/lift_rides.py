# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A drive on one storey, a ride in a closed lift, and a drive on another storey.

The cabin stands at the end of the first tour and at the start of the second, with its opening
where the robot comes from and goes to. While it is shut the lidar sees nothing but the cabin, and
the robot turns in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.errors import ConfigError
from fpnet_core.geometry import SE2
from fpnet_core.types import OCCUPIED, GridMap
from fpnet_lab.sim.buildings.building import Building
from fpnet_lab.sim.buildings.meshes import extrude_polygon, horizontal_sheet, merge_meshes
from fpnet_lab.sim.drawn.render import fill_polygons
from fpnet_lab.sim.drives.driving import BODY_RADIUS_M, MOTION, Tour
from fpnet_lab.sim.drives.recording import Recording
from fpnet_lab.sim.drives.scanning import SimulatedScan
from fpnet_lab.sim.lidars.lidar import LidarSimulator

_INSIDE_M, _WALL_M = 1.8, 0.1
"""Physical: a lift for beds and trolleys, in square."""

_OPENING_M, _LINTEL_M, _CEILING_M = 1.1, 2.1, 2.4
"""Physical: of such a lift."""

_LEAVES_WITHIN_M = 1.2
"""Physical: by then the robot is out of the cabin; its way so far is the door's direction."""

_STANDS_S = 2.0
"""Chosen: before and after the robot turns in the cabin."""


@dataclass(frozen=True, eq=False)
class LiftRide:
    """
    Two drives and the ride between them.

    ``storeys`` are the drives on the storey that the robot leaves and on that where it gets out,
    with the cabin in their buildings and drawings; ``cabin`` is the ride. ``at`` are the cabin's
    places (2,) in the two floorplans [m].
    """

    storeys: tuple[Recording, Recording]
    cabin: Recording
    at: tuple[NDArray[np.float64], NDArray[np.float64]]

    @property
    def parts(self) -> tuple[Recording, Recording, Recording]:
        """The drive, the ride and the other drive."""
        return self.storeys[0], self.cabin, self.storeys[1]

    def __len__(self) -> int:
        """Count the scans."""
        return sum(map(len, self.parts))

    def __iter__(self) -> Iterator[tuple[int, SimulatedScan]]:
        """Yield the number of the part and each scan, whose stamps go on from part to part."""
        past_ns = 0
        for number, part in enumerate(self.parts):
            for scan in part:
                yield number, replace(scan, stamp_ns=scan.stamp_ns + past_ns)
            past_ns += len(part) * round(1e9 * part.lidar.model.period_s)


def lift_ride(left: Recording, entered: Recording) -> LiftRide:
    """
    Join two recordings of one lidar by a lift.

    Raises
    ------
    ConfigError
        If a tour comes by where the cabin would stand; take other recordings.
    """
    came, goes = left.tour, entered.tour
    T_left_cabin = _cabin_at(came.xy[::-1])
    T_entered_cabin = _cabin_at(goes.xy)
    turn = (
        float(came.yaw_rad[-1] - T_left_cabin.yaw),
        float(goes.yaw_rad[0] - T_entered_cabin.yaw),
    )
    return LiftRide(
        (_with_cabin(left, T_left_cabin), _with_cabin(entered, T_entered_cabin)),
        _shut_in(left, turn),
        (
            left.A_plan_building.apply(T_left_cabin.translation),
            entered.A_plan_building.apply(T_entered_cabin.translation),
        ),
    )


def _cabin_at(xy: NDArray[np.float64]) -> SE2:
    """Return ``T_building_cabin`` around the first of places (S, 2), open where they lead to."""
    away_m = np.linalg.norm(xy - xy[0], axis=1)
    out = xy[int(np.argmax(away_m >= _LEAVES_WITHIN_M))] - xy[0]
    return SE2.from_xy_yaw(float(xy[0, 0]), float(xy[0, 1]), float(np.arctan2(out[1], out[0])))


def _shapes() -> tuple[shapely.Polygon, shapely.Polygon]:
    """Return the cabin's walls and its opening, towards +x of the cabin's frame."""
    half, outer = 0.5 * _INSIDE_M, 0.5 * _INSIDE_M + _WALL_M
    opening = shapely.box(half, -0.5 * _OPENING_M, outer, 0.5 * _OPENING_M)
    ring = shapely.box(-outer, -outer, outer, outer) - shapely.box(-half, -half, half, half)
    return ring - opening, opening


def _placed(shape: shapely.Polygon, T_building_cabin: SE2) -> shapely.Polygon:
    return shapely.transform(shape, T_building_cabin.apply)


def _with_cabin(recording: Recording, T_building_cabin: SE2) -> Recording:
    """Return a recording with the open cabin in its building and on its drawing."""
    walls, opening = (_placed(shape, T_building_cabin) for shape in _shapes())
    if recording.tour.line().buffer(BODY_RADIUS_M).intersects(walls):
        raise ConfigError(
            f'the tour of seed {recording.seed} comes by where the lift would stand; take another'
        )
    building = recording.building
    lift = [
        extrude_polygon(walls, 0.0, _CEILING_M),
        extrude_polygon(opening, _LINTEL_M, _CEILING_M),
    ]
    building = replace(building, walls=merge_meshes([building.walls, *lift]))
    ring = recording.A_plan_building.apply(shapely.get_coordinates(walls.exterior)[:-1])
    return replace(
        recording,
        building=building,
        floorplan=_drawn_on(recording.floorplan, ring),
        lidar=LidarSimulator(building, recording.lidar.model, threads=1),
    )


def _drawn_on(sheet: GridMap, ring: NDArray[np.float64]) -> GridMap:
    cells = sheet.cells.copy()
    fill_polygons(cells, [sheet.xy_to_rc(ring)[:, ::-1] + 0.5], OCCUPIED, keep_thin=True)
    return replace(sheet, cells=cells)


def _shut_in(left: Recording, turn: tuple[float, float]) -> Recording:
    """Return the ride: in the frame of the cabin, from one heading to another [rad]."""
    walls, opening = _shapes()
    area = shapely.box(*(walls | opening).bounds)
    building = Building(
        left.building.plan,
        walls=merge_meshes([extrude_polygon(each, 0.0, _CEILING_M) for each in (walls, opening)]),
        shell=merge_meshes(
            [horizontal_sheet(area, 0.0, faces_up=True), horizontal_sheet(area, _CEILING_M, False)]
        ),
        contents=merge_meshes([]),
    )
    return replace(
        left,
        building=building,
        tour=_turning(turn, left.tour.sensor_height_m),
        lidar=LidarSimulator(building, left.lidar.model, threads=1),
    )


def _turning(turn: tuple[float, float], sensor_height_m: float) -> Tour:
    """Return a tour that stands, turns the shorter way, and stands again."""
    by = (turn[1] - turn[0] + np.pi) % (2.0 * np.pi) - np.pi
    turning_s = max(abs(by) / (0.5 * MOTION.turn_rate_radps), MOTION.step_s)
    time_s = MOTION.step_s * np.arange(
        round((2.0 * _STANDS_S + turning_s) / MOTION.step_s), dtype=np.float64
    )
    yaw = np.interp(time_s, [_STANDS_S, _STANDS_S + turning_s], [turn[0], turn[0] + by])
    still = np.zeros((len(time_s), 2))
    return Tour(time_s, still, yaw.astype(np.float64), still.copy(), (), sensor_height_m)
