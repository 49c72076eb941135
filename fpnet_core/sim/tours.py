# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Tours: a robot with a differential drive visits rooms and looks around in each.

The path is planned once and then *driven* by a small controller with bounded speed, turn rate
and accelerations, so that the motion is one that a robot can make and scan matching can follow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation
import shapely

from fpnet_core.errors import ConfigError
from fpnet_core.geometry import wrap_to_pi
from fpnet_core.sim.openings import walkable_area
from fpnet_core.sim.routes import Place, Router
from fpnet_core.sim.types import BuildingPlan

Array = NDArray[np.float64]

SENSOR_HEIGHT_M = 0.9
BODY_RADIUS_M = 0.22
"""The robot's half width: its path keeps this far from all walls and door frames."""


VISIT_DEPTH_M = (1.2, 2.5)
"""How far into a room the robot drives, measured from its door."""

_MOST_STARTS = 12
_NEARNESS_M = 5.0  # rooms much farther than this from the nearest one are rarely next
_LOOK_RAD = (0.4, 1.0)
_LINGER_S = 4.0  # typical time to stop, look around and turn back
_PACE = 0.75  # mean speed on a path over the highest speed


@dataclass(frozen=True)
class Drive:
    """How the robot moves; metres, radians, seconds."""

    speed_mps: float = 1.0
    acceleration_mps2: float = 0.8
    turn_rate_radps: float = float(np.deg2rad(55.0))
    turn_acceleration_radps2: float = float(np.deg2rad(90.0))
    lookahead_m: float = 0.4
    standstill_s: float = 1.0
    """Pause before the first move, in which an odometry builds its first map."""

    step_s: float = 0.01
    sway_rad: float = float(np.deg2rad(0.25))
    """Standard deviation of roll and pitch at full speed: floors and tyres are not perfect."""


@dataclass(frozen=True)
class TourLimits:
    """What a tour must contain: distinct rooms (the first one included) and time."""

    rooms: int = 5
    shortest_s: float = 60.0
    longest_s: float = 100.0


@dataclass(frozen=True, eq=False)
class Tour:
    """
    The robot's true motion in the frame ``building``.

    ``time_s (S,)`` starts at 0 in equal steps; ``xy (S, 2)`` [m]; ``yaw_rad (S,)`` is unwrapped;
    ``tilt_rad (S, 2)`` is roll and pitch. ``rooms`` are the visited rooms (plan indices) in
    order, corridors on the way left out.
    """

    time_s: Array
    xy: Array
    yaw_rad: Array
    tilt_rad: Array
    rooms: tuple[int, ...]
    sensor_height_m: float = SENSOR_HEIGHT_M

    @property
    def duration_s(self) -> float:
        """Length of the tour [s]."""
        return float(self.time_s[-1])

    @property
    def path_m(self) -> float:
        """Distance driven [m]."""
        return float(np.linalg.norm(np.diff(self.xy, axis=0), axis=1).sum())

    def line(self) -> shapely.LineString:
        """Return the driven path as a line [m]."""
        return shapely.LineString(self.xy).simplify(0.01)

    def sensor_poses(self, time_s: Array) -> tuple[Array, Array]:
        """
        Interpolate the sensor's pose at times ``(K,)``.

        Returns rotations building <- sensor ``(K, 3, 3)`` and positions ``(K, 3)`` [m].
        """
        tracks = np.column_stack([self.yaw_rad, self.tilt_rad[:, ::-1], self.xy])
        yaw_pitch_roll_xy = np.stack(
            [np.interp(time_s, self.time_s, track) for track in tracks.T], axis=1
        )
        R = Rotation.from_euler('ZYX', yaw_pitch_roll_xy[:, :3]).as_matrix()
        height = np.full(len(R), self.sensor_height_m)
        return R, np.column_stack([yaw_pitch_roll_xy[:, 3:], height])


@dataclass(frozen=True, eq=False)
class _Leg:
    """A polyline to drive, and how far to turn at its end before the next one [rad]."""

    path: Array
    look_rad: float


def plan_tour(
    plan: BuildingPlan,
    rng: np.random.Generator,
    limits: TourLimits | None = None,
    drive: Drive | None = None,
) -> Tour:
    """
    Plan and drive a tour that starts in a random room and visits others near by.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
        Draws the start, the order of the rooms, where to stand in them and how to look around.
    limits : TourLimits
    drive : Drive

    Raises
    ------
    ConfigError
        If no tour through that many rooms, in the time allowed and clear of walls, was found.
    """
    limits, drive = limits or TourLimits(), drive or Drive()
    router, area = Router(plan), walkable_area(plan)
    candidates = [i for i, room in enumerate(plan.rooms) if room.kind == 'room']
    starts = rng.permutation(candidates)[:_MOST_STARTS].tolist()
    for start in starts if len(candidates) >= limits.rooms else []:
        rooms, legs = _choose_rooms(plan, router, start, rng, limits, drive)
        if len(rooms) >= limits.rooms:
            tour = _drive_legs(legs, rooms, rng, drive)
            in_time = limits.shortest_s <= tour.duration_s <= limits.longest_s
            if in_time and _is_clear(tour, area):
                return tour
    raise ConfigError(
        f'{plan.family} plan with {len(candidates)} rooms has no tour through {limits.rooms} of '
        f'them in {limits.shortest_s:.0f} to {limits.longest_s:.0f} s; ask for fewer rooms or '
        'a longer tour, or take another seed'
    )


def _is_clear(tour: Tour, area: shapely.Geometry) -> bool:
    """Say whether the driven path keeps off the walls: the controller cuts corners a little."""
    return bool(shapely.covers(area.buffer(-BODY_RADIUS_M), tour.line()))


def _choose_rooms(
    plan: BuildingPlan,
    router: Router,
    start: int,
    rng: np.random.Generator,
    limits: TourLimits,
    drive: Drive,
) -> tuple[list[int], list[_Leg]]:
    """Add rooms until both number and time suffice; stop where the next would take too long."""
    here = router.inner_point(start, rng, VISIT_DEPTH_M)
    rooms, legs, clock_s = [start], [], 0.0
    closed = {i for i, room in enumerate(plan.rooms) if room.kind != 'room'}
    middle_s = 0.5 * (limits.shortest_s + limits.longest_s)
    while len(rooms) < limits.rooms or clock_s < middle_s:
        room = _next_room(router, here, closed.union(rooms), rng)
        if room is None:
            break
        place = router.inner_point(room, rng, VISIT_DEPTH_M, near=router.entrance(here, room))
        path = router.path(here, place)
        if path is None:
            closed.add(room)
            continue
        length_m = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        clock_s += length_m / (_PACE * drive.speed_mps) + _LINGER_S
        if clock_s > limits.longest_s:
            break
        legs.append(_Leg(path, float(rng.choice([-1.0, 1.0]) * rng.uniform(*_LOOK_RAD))))
        rooms.append(room)
        here = place
    return rooms, legs


def _next_room(
    router: Router, here: Place, closed: set[int], rng: np.random.Generator
) -> int | None:
    """Draw a room that is not closed to the tour, near ones more often; None if there is none."""
    lengths = router.distances(here)
    fresh = sorted(set(lengths) - closed)
    if not fresh:
        return None
    ways = np.array([lengths[room] for room in fresh])
    weights = np.exp(-(ways - ways.min()) / _NEARNESS_M)
    return int(rng.choice(fresh, p=weights / weights.sum()))


def _drive_legs(
    legs: list[_Leg], rooms: list[int], rng: np.random.Generator, drive: Drive
) -> Tour:
    first = legs[0].path[1] - legs[0].path[0]
    yaw = float(np.arctan2(first[1], first[0]) + rng.uniform(-1.0, 1.0) * np.pi / 2.0)
    robot = _Robot(legs[0].path[0], yaw, drive)
    robot.wait(drive.standstill_s)
    for leg in legs:
        robot.follow(leg.path)
        robot.turn(leg.look_rad)
    xy_yaw = np.array(robot.track)
    speed = np.linalg.norm(np.gradient(xy_yaw[:, :2], drive.step_s, axis=0), axis=1)
    return Tour(
        time_s=drive.step_s * np.arange(len(xy_yaw), dtype=np.float64),
        xy=xy_yaw[:, :2],
        yaw_rad=xy_yaw[:, 2],
        tilt_rad=_sway(speed / drive.speed_mps, rng, drive),
        rooms=tuple(rooms),
    )


_SWAY_S = 0.12  # correlation time of roll and pitch


def _sway(speed_share: Array, rng: np.random.Generator, drive: Drive) -> Array:
    """Return roll and pitch ``(S, 2)``: smooth noise that grows with speed [rad]."""
    noise = rng.standard_normal((len(speed_share), 2))
    smooth = gaussian_filter1d(noise, _SWAY_S / drive.step_s, axis=0)
    unit = smooth / smooth.std(axis=0)
    share = gaussian_filter1d(speed_share, _SWAY_S / drive.step_s)
    sway: Array = drive.sway_rad * share[:, None] * unit
    return sway


class _Robot:
    """Integrates a differential drive and keeps its track of (x, y, unwrapped yaw)."""

    _GAIN = 2.5  # turn rate over heading error [1/s]
    _SLOW_RAD = 0.9  # heading error at which the robot stands and turns
    _SPACING_M = 0.02  # of the resampled path
    _BLIND_M = 0.12  # this near to the goal the direction to it means nothing
    _STOPPED = 0.02  # speed [m/s] and angle [rad] that count as reached

    def __init__(self, xy: Array, yaw_rad: float, drive: Drive) -> None:
        self._x, self._y, self._yaw = float(xy[0]), float(xy[1]), yaw_rad
        self._speed, self._rate = 0.0, 0.0
        self._drive = drive
        self.track: list[tuple[float, float, float]] = [(self._x, self._y, self._yaw)]

    def wait(self, duration_s: float) -> None:
        """Stand still."""
        for _ in range(round(duration_s / self._drive.step_s)):
            self._step(0.0, 0.0)

    def follow(self, path: Array) -> None:
        """Drive along a polyline (V, 2) by pure pursuit and stop at its end."""
        points = _resample(path, self._SPACING_M)
        ahead = round(self._drive.lookahead_m / self._SPACING_M)
        nearest, last = 0, len(points) - 1
        while True:
            nearest = self._advance_on(points, nearest, ahead)
            left_m = (last - nearest) * self._SPACING_M
            target = points[min(nearest + ahead, last)]
            error = self._bearing(target) if left_m > self._BLIND_M else 0.0
            brake = np.sqrt(2.0 * self._drive.acceleration_mps2 * left_m)
            cruise = min(self._drive.speed_mps, brake)
            self._step(cruise * max(0.0, 1.0 - abs(error) / self._SLOW_RAD), error)
            if left_m < self._BLIND_M and self._speed < self._STOPPED:
                return

    def turn(self, angle_rad: float) -> None:
        """Turn on the spot."""
        goal = self._yaw + angle_rad
        while abs(goal - self._yaw) > self._STOPPED or abs(self._rate) > self._STOPPED:
            self._step(0.0, goal - self._yaw)

    def _bearing(self, target: Array) -> float:
        direction = np.arctan2(target[1] - self._y, target[0] - self._x)
        return float(wrap_to_pi(direction - self._yaw))

    def _advance_on(self, points: Array, nearest: int, window: int) -> int:
        """Return the nearest of the next ``window`` points: the path may cross itself later."""
        ahead = points[nearest : nearest + window] - (self._x, self._y)
        return nearest + int(np.argmin(np.einsum('ij,ij->i', ahead, ahead)))

    def _step(self, speed_mps: float, error_rad: float) -> None:
        """Move one time step towards the wanted speed and heading, within the limits."""
        drive, dt = self._drive, self._drive.step_s
        stoppable = np.sqrt(drive.turn_acceleration_radps2 * abs(error_rad))
        rate = min(self._GAIN * abs(error_rad), stoppable, drive.turn_rate_radps)
        self._rate += _limit(
            np.copysign(rate, error_rad) - self._rate, dt * drive.turn_acceleration_radps2
        )
        self._speed += _limit(speed_mps - self._speed, dt * drive.acceleration_mps2)
        self._yaw += self._rate * dt
        self._x += self._speed * dt * float(np.cos(self._yaw))
        self._y += self._speed * dt * float(np.sin(self._yaw))
        self.track.append((self._x, self._y, self._yaw))


def _limit(value: float, bound: float) -> float:
    return float(min(max(value, -bound), bound))


def _resample(path: Array, spacing_m: float) -> Array:
    """Return points at equal spacing along a polyline (V, 2), its end included."""
    line = shapely.LineString(path)
    count = max(2, int(np.ceil(line.length / spacing_m)) + 1)
    places = np.linspace(0.0, line.length, count)
    points: Array = shapely.get_coordinates(shapely.line_interpolate_point(line, places))
    return points
