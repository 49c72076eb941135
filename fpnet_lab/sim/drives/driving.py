# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Simulation of a differential-drive robot that follows paths and turns at their ends.

A controller with bounded speed, turn rate and accelerations follows the path, so that a robot can
perform the motion and scan matching can track it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from numba import njit
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation
import shapely

from fpnet_core.trajectory import path_length

Array = NDArray[np.float64]

SENSOR_HEIGHT_M = 0.9
BODY_RADIUS_M = 0.22
"""Robot radius: minimum distance between its path and walls or door frames. Chosen."""

_SWAY_S = 0.12  # correlation time of roll and pitch; chosen
_SPACING_M = 0.02  # numerical: point spacing of the resampled path
_LONGEST_LEG_S = 600.0  # numerical: stops a robot that circles around its goal

# Controller: heading error above which the robot turns on the spot [rad]; distance to the goal
# below which its direction is ignored [m]; tolerance of speed [m/s] and angle [rad]. Chosen.
_SLOW_RAD, _BLIND_M, _STOPPED = 0.9, 0.12, 0.02

_X, _Y, _YAW, _SPEED, _RATE = range(5)


@dataclass(frozen=True)
class MotionLimits:
    """Motion limits and controller gains of the robot; metres, radians, seconds."""

    speed_mps: float = 1.0
    acceleration_mps2: float = 0.8
    turn_rate_radps: float = float(np.deg2rad(55.0))
    turn_acceleration_radps2: float = float(np.deg2rad(90.0))
    turn_gain: float = 2.5
    """Ratio of turn rate to heading error [1/s]."""

    lookahead_m: float = 0.4
    standstill_s: float = 1.0
    """Pause before the first motion, so that odometry can build its first local map."""

    step_s: float = 0.01
    sway_rad: float = float(np.deg2rad(0.25))
    """Standard deviation of roll and pitch at full speed, due to uneven floors and tyres."""


MOTION = MotionLimits()
"""Limits of a wheeled robot."""

WALK = MotionLimits(
    speed_mps=1.5,
    acceleration_mps2=2.0,
    turn_rate_radps=float(np.deg2rad(430.0)),
    turn_acceleration_radps2=float(np.deg2rad(1700.0)),
    turn_gain=7.0,
    lookahead_m=0.5,
    sway_rad=float(np.deg2rad(2.0)),
)
"""Limits of a person carrying a handheld or backpack lidar. Chosen."""

PACES = {'robot': MOTION, 'walk': WALK}
"""Motion limits by name."""


@dataclass(frozen=True, eq=False)
class Tour:
    """
    True motion of the robot in the frame ``building``.

    ``time_s (S,)`` starts at 0 in equal steps; ``xy (S, 2)`` [m]; ``yaw_rad (S,)`` is unwrapped;
    ``tilt_rad (S, 2)`` is roll and pitch. ``rooms`` are the visited rooms (plan indices) in
    order, without traversed corridors. The sensor is ``sensor_height_m`` above z = 0.
    """

    time_s: Array
    xy: Array
    yaw_rad: Array
    tilt_rad: Array
    rooms: tuple[int, ...]
    sensor_height_m: float = SENSOR_HEIGHT_M

    @property
    def duration_s(self) -> float:
        """Duration of the tour [s]."""
        return float(self.time_s[-1])

    @property
    def path_m(self) -> float:
        """Distance driven [m]."""
        return path_length(self.xy)

    def line(self) -> shapely.LineString:
        """Return the driven path as a line [m]."""
        return shapely.LineString(self.xy).simplify(0.01)

    def sensor_poses(self, time_s: Array) -> tuple[Array, Array]:
        """
        Interpolate the sensor's pose at times ``(K,)`` [s].

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
class Leg:
    """A polyline ``path (V, 2)`` [m] to drive, and the rotation at its end [rad]."""

    path: Array
    look_rad: float


def drive_legs(
    legs: Sequence[Leg],
    rooms: Sequence[int],
    rng: np.random.Generator,
    motion: MotionLimits = MOTION,
) -> Tour:
    """
    Drive a sequence of legs, starting at rest with a random heading.

    Parameters
    ----------
    legs : at least one; each starts at the end of the previous one
    rooms : visited rooms, stored in the tour
    rng : random generator of the initial heading, roll and pitch
    motion : motion limits
    """
    first = legs[0].path[1] - legs[0].path[0]
    yaw = float(np.arctan2(first[1], first[0]) + rng.uniform(-1.0, 1.0) * np.pi / 2.0)
    state = np.array([*legs[0].path[0], yaw, 0.0, 0.0])
    limits = np.array(
        [
            motion.speed_mps,
            motion.acceleration_mps2,
            motion.turn_rate_radps,
            motion.turn_acceleration_radps2,
            motion.step_s,
            motion.turn_gain,
        ]
    )
    tracks = [np.tile(state[:3], (1 + round(motion.standstill_s / motion.step_s), 1))]
    ahead = round(motion.lookahead_m / _SPACING_M)
    for leg in legs:
        points = _resample(leg.path, _SPACING_M)
        tracks.append(_follow(points, _SPACING_M, ahead, state, limits))
        tracks.append(_turn(leg.look_rad, state, limits))
    xy_yaw = np.concatenate(tracks)
    speed = np.linalg.norm(np.gradient(xy_yaw[:, :2], motion.step_s, axis=0), axis=1)
    return Tour(
        time_s=motion.step_s * np.arange(len(xy_yaw), dtype=np.float64),
        xy=xy_yaw[:, :2],
        yaw_rad=xy_yaw[:, 2],
        tilt_rad=_sway(speed / motion.speed_mps, rng, motion),
        rooms=tuple(rooms),
    )


def _sway(speed_share: Array, rng: np.random.Generator, motion: MotionLimits) -> Array:
    """Return roll and pitch ``(S, 2)`` [rad]: smooth noise that grows with speed."""
    noise = rng.standard_normal((len(speed_share), 2))
    smooth = gaussian_filter1d(noise, _SWAY_S / motion.step_s, axis=0)
    unit = smooth / smooth.std(axis=0)
    share = gaussian_filter1d(speed_share, _SWAY_S / motion.step_s)
    sway: Array = motion.sway_rad * share[:, None] * unit
    return sway


# The compiled functions below modify ``state (5,)``: x, y, unwrapped yaw, speed, turn rate.
# ``limits (6,)``: speed, acceleration, turn rate, turn acceleration, time step, turn gain.


@njit(cache=True)
def _step(state: Any, limits: Any, speed: float, error: float) -> None:
    """Advance one time step towards the target speed and heading, within the limits."""
    most, gain, dt = limits[2], limits[5] * abs(error), limits[4]
    rate = min(gain, np.sqrt(limits[3] * abs(error)), most)
    rate = rate if error >= 0.0 else -rate
    turn, push = dt * limits[3], dt * limits[1]
    state[_RATE] += min(max(rate - state[_RATE], -turn), turn)
    state[_SPEED] += min(max(speed - state[_SPEED], -push), push)
    state[_YAW] += state[_RATE] * dt
    state[_X] += state[_SPEED] * dt * np.cos(state[_YAW])
    state[_Y] += state[_SPEED] * dt * np.sin(state[_YAW])


@njit(cache=True)
def _follow(points: Any, spacing: float, ahead: int, state: Any, limits: Any) -> Any:
    """
    Follow points (V, 2) by pure pursuit, stop at their end and return the track (S, 3).

    Only the next ``ahead`` points are considered, because the path may cross itself later.
    """
    most = int(_LONGEST_LEG_S / limits[4])
    track = np.empty((most, 3))
    nearest, last = 0, len(points) - 1
    for count in range(most):
        best, least = nearest, 1e18
        for k in range(nearest, min(nearest + ahead, last + 1)):
            away = (points[k, 0] - state[_X]) ** 2 + (points[k, 1] - state[_Y]) ** 2
            if away < least:
                best, least = k, away
        nearest = best
        left_m = (last - nearest) * spacing
        error = 0.0
        if left_m > _BLIND_M:
            goal = points[min(nearest + ahead, last)]
            error = np.arctan2(goal[1] - state[_Y], goal[0] - state[_X]) - state[_YAW]
            error = np.arctan2(np.sin(error), np.cos(error))
        cruise = min(limits[0], np.sqrt(2.0 * limits[1] * left_m))
        _step(state, limits, cruise * max(0.0, 1.0 - abs(error) / _SLOW_RAD), error)
        track[count] = state[:3]
        if left_m < _BLIND_M and state[_SPEED] < _STOPPED:
            break
    return track[: count + 1]


@njit(cache=True)
def _turn(angle: float, state: Any, limits: Any) -> Any:
    """Turn on the spot and return the track (S, 3)."""
    goal = state[_YAW] + angle
    most = int(_LONGEST_LEG_S / limits[4])
    track = np.empty((most, 3))
    count = 0
    while count < most and (abs(goal - state[_YAW]) > _STOPPED or abs(state[_RATE]) > _STOPPED):
        _step(state, limits, 0.0, goal - state[_YAW])
        track[count] = state[:3]
        count += 1
    return track[:count]


def _resample(path: Array, spacing_m: float) -> Array:
    """Return equally spaced points along a polyline (V, 2), including its end."""
    line = shapely.LineString(path)
    count = max(2, int(np.ceil(line.length / spacing_m)) + 1)
    places = np.linspace(0.0, line.length, count)
    points: Array = shapely.get_coordinates(shapely.line_interpolate_point(line, places))
    return points
