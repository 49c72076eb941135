# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Search over heading and turn rate of a sweep, for the initial guess of the registration.

Registration starts from a constant motion. A handheld lidar can change its turn rate by a hundred
degrees per second from one sweep to the next: the guess is off by ten degrees, the sweep is
deskewed with the wrong motion, and the map receives it like that. The search finds the heading
and turn rate for which the deskewed sweep fits best in the likelihood field (Thrun et al.,
Probabilistic Robotics, 6.4) of the walls of the last sweeps.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
import logging
import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet_core.geometry.motion import carried

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

_REJECTED = (
    logging.WARNING,
    'the rotation of the gyroscope does not fit the scans and is ignored until it does: are its '
    'rates in rad/s, and is its orientation on /tf_static right?',
)
_ACCEPTED = logging.INFO, 'the rotation of the gyroscope fits the scans and is used from now on'

_CELL_M, _HALF = 0.1, 160  # numerical: of the likelihood field, 16 m to each side
_SIGMA_M = 0.15
"""Standard deviation of returns from the walls of recent sweeps [m]. Chosen: noise and drift."""

_SWEEPS = 5
"""Sweeps whose walls form the field. Chosen: half a second."""

_RETURNS, _FEWEST = 400, 50
"""Largest and smallest number of returns that are matched. Chosen: for 5 ms of a core."""

_OFF_RAD, _CHANGE_RAD = math.radians(1.0), math.radians(8.0)
"""
Prior standard deviations of the heading at the start of a sweep, and of the turn rate's change in
a period [rad]: one of them costs ``_PRIOR`` of the mean likelihood. Chosen on simulated walks.
"""

_PRIOR = 0.005
_GAIN = 0.01
"""Least gain of the mean likelihood to replace a guess. Chosen: less does not help robots."""

_MISFIT, _NEWEST = 0.05, 0.05
"""
Misfit of a wrong gyroscope: the mean likelihood that its rotation loses against the best one, in a
sweep; and weight of the newest sweep in the mean. Chosen on simulated walks, where the misfit is
0.005 in nine of ten sweeps and 0.02 in the mean at most, and 0.06 with rates a half too small.
"""

_PROVEN, _BROKEN = 0.03, 0.1
"""
Mean misfits below and above which a gyroscope is accepted and rejected. Chosen: starting from
``_MISFIT``, both take about ten informative sweeps.
"""

# Numerical: stages of the search around the best candidate so far: step [rad], and number of steps
# to both sides in heading and in turn rate.
_GRIDS = ((math.radians(3.0), 5, 10), (math.radians(1.0), 2, 3), (math.radians(0.4), 2, 3))

_INFORMATIVE_RAD = math.radians(3.0)
"""Difference of gyroscope and guess at which a sweep has full weight [rad]. Chosen."""


@dataclass(frozen=True, eq=False)
class Guess:
    """
    Candidate pose of a sensor at the stamp of a sweep, with its motion.

    ``T_odom_sensor (4, 4)`` is the pose, ``T_start_end (4, 4)`` the motion during one period, to
    deskew the sweep.
    """

    T_odom_sensor: Array
    T_start_end: Array

    @classmethod
    def of(cls, T_odom_sensor: Array, motion: Array) -> Guess:
        """Return a guess with a re-orthonormalized rotation, else KISS-ICP may abort."""
        motion = motion.copy()
        motion[:3, :3] = Rotation.from_matrix(motion[:3, :3]).as_matrix()
        return cls(T_odom_sensor, motion)

    @classmethod
    def moved(cls, T_last: Array, motion: Array) -> Guess:
        """Return the guess that a motion ``(4, 4)`` from the last pose gives."""
        return cls.of(T_last @ motion, motion)

    def apart_rad(self, other: Guess) -> float:
        """Return the angle between the rotations of two guesses [rad]."""
        turn = self.T_start_end[:3, :3].T @ other.T_start_end[:3, :3]
        return float(Rotation.from_matrix(turn).magnitude())


class YawSearch:
    """Finds heading and turn rate of each sweep by matching the walls of the last ones."""

    def __init__(self) -> None:
        self._walls: deque[Array] = deque(maxlen=_SWEEPS)
        self._misfit = _MISFIT  # mean loss of likelihood with the gyroscope's rotation
        self._is_accepted: bool | None = None  # undecided

    def note(self, walls: Array) -> None:
        """Add the walls of a registered sweep ``(P, 3)``, odometry frame [m]."""
        self._walls.append(walls)

    def best(
        self, guess: Guess, by_gyro: Guess | None, walls: Array, share: Array, stamp_share: float
    ) -> tuple[Guess, bool]:
        """
        Return the most likely guess, and whether the search has found it.

        Parameters
        ----------
        guess
            Start of the search, returned if the walls give no better one.
        by_gyro
            Guess with the gyroscope's rotation; preferred unless it does not fit the walls.
        walls : (P, 3)
            Upright raw returns of the sweep, sensor frame [m].
        share : (P,)
            Times of the returns relative to the stamp, in periods; empty: all at the stamp.
        stamp_share
            Time from the middle of the sweep to its stamp, in periods.
        """
        every = max(1, len(walls) // _RETURNS)
        walls, share = walls[::every], share[::every]
        if len(walls) < _FEWEST or not self._walls:
            return guess if by_gyro is None or not self._is_accepted else by_gyro, False
        centre = guess.T_odom_sensor[:2, 3]
        field = _likelihood_field(np.vstack(self._walls)[:, :2] - centre)
        projection = _Projection.of(guess, walls, share, stamp_share, centre)
        best, begun = np.zeros(2), float(projection.likelihood(field, np.zeros((1, 2)))[0])
        most = begun
        for step, headings, rates in _GRIDS:
            tried = best + step * _grid(headings, rates if len(share) else None)
            found = projection.likelihood(field, tried)
            if found.max() > most:
                best, most = tried[int(found.argmax())], float(found.max())
        if by_gyro is not None:
            projection = _Projection.of(by_gyro, walls, share, stamp_share, centre)
            misfit = most - float(projection.likelihood(field, np.zeros((1, 2)))[0])
            if self._accepts(misfit, guess.apart_rad(by_gyro)):
                return by_gyro, False
        if most - begun < _GAIN:
            return guess, False
        return _turned(guess, best[0] + stamp_share * best[1], best[1]), True

    def _accepts(self, misfit: float, apart_rad: float) -> bool:
        """
        Update the gyroscope's mean misfit and return whether its rotation is used.

        The misfit is only informative if the gyroscope's rotation differs from the guess.
        """
        weight = _NEWEST * min(1.0, apart_rad / _INFORMATIVE_RAD)
        self._misfit += weight * (misfit - self._misfit)
        was_accepted = self._is_accepted
        if self._misfit < _PROVEN or self._misfit > _BROKEN:
            self._is_accepted = self._misfit < _PROVEN
        if self._is_accepted is not was_accepted:
            _log.log(*(_ACCEPTED if self._is_accepted else _REJECTED))
        return misfit < _MISFIT and self._is_accepted is True


@dataclass(frozen=True, eq=False)
class _Projection:
    """
    A sweep projected to the plane at a guess.

    ``arm (P, 2)`` are vectors from the sensor to the returns and ``origin (2,)`` is the sensor,
    both in axes of the odometry frame [m]. ``time (P,)`` is relative to the sweep's middle, and
    ``since`` the time from the last pose to the middle, both in periods.
    """

    arm: NDArray[np.float32]
    origin: Array
    time: NDArray[np.float32]
    since: float

    @classmethod
    def of(
        cls, guess: Guess, walls: Array, share: Array, stamp_share: float, centre: Array
    ) -> _Projection:
        T = guess.T_odom_sensor
        deskewed = carried(walls, guess.T_start_end, share) if len(share) else walls
        time = share + stamp_share if len(share) else np.zeros(len(walls))
        arm = (deskewed @ T[:3, :3].T)[:, :2]
        since = 1.0 - stamp_share if len(share) else 1.0
        return cls(arm.astype(np.float32), T[:2, 3] - centre, time.astype(np.float32), since)

    def likelihood(self, field: NDArray[np.float32], tried: Array) -> Array:
        """
        Return the mean likelihood ``(N,)`` minus prior cost of changes ``tried (N, 2)``.

        The changes are of the heading in the sweep's middle [rad] and the turn rate [rad/period].
        """
        heading, rate = tried.T
        angle = (heading[:, None] + rate[:, None] * self.time).astype(np.float32)
        c, s = np.cos(angle), np.sin(angle)
        x = c * self.arm[:, 0] - s * self.arm[:, 1] + self.origin[0]
        y = s * self.arm[:, 0] + c * self.arm[:, 1] + self.origin[1]
        mean = field[_cells(y), _cells(x)].mean(axis=1)
        begins_off = heading - self.since * rate
        prior = (begins_off / _OFF_RAD) ** 2 + (rate / _CHANGE_RAD) ** 2
        return np.asarray(mean - _PRIOR * prior, dtype=np.float64)


def _likelihood_field(walls: Array) -> NDArray[np.float32]:
    """Return the likelihood field around the origin for walls ``(P, 2)`` [m]."""
    is_inside = (np.abs(walls) < _HALF * _CELL_M).all(axis=1)
    raster = np.full((2 * _HALF, 2 * _HALF), 1, dtype=np.uint8)
    raster[_cells(walls[is_inside, 1]), _cells(walls[is_inside, 0])] = 0
    away_m = cv2.distanceTransform(raster, cv2.DIST_L2, 3) * _CELL_M
    likelihood = np.exp(-0.5 * np.square(away_m / _SIGMA_M, dtype=np.float64))
    return np.asarray(likelihood, dtype=np.float32)


def _cells(metres: NDArray[np.floating]) -> NDArray[np.int32]:
    """Return rows or columns of the field, clipped to its edge."""
    cells: NDArray[np.int32] = np.floor(metres / _CELL_M).astype(np.int32) + _HALF
    return np.clip(cells, 0, 2 * _HALF - 1)


def _grid(headings: int, rates: int | None) -> Array:
    """Return integer pairs ``(N, 2)`` around 0: all, or if ``rates`` is None equal pairs."""
    if rates is None:
        return np.repeat(np.arange(-headings, headings + 1.0), 2).reshape(-1, 2)
    heading, rate = np.mgrid[-headings : headings + 1, -rates : rates + 1]
    return np.stack([heading.ravel(), rate.ravel()], axis=1).astype(np.float64)


def _turned(guess: Guess, heading: float, rate: float) -> Guess:
    """Rotate a guess about the odometry's z: heading at the stamp, and turn rate."""
    T, motion = guess.T_odom_sensor.copy(), guess.T_start_end.copy()
    R = guess.T_odom_sensor[:3, :3]
    T[:3, :3] = _about_z(heading) @ R
    motion[:3, :3] = R.T @ _about_z(rate) @ R @ motion[:3, :3]
    return Guess.of(T, motion)


def _about_z(angle: float) -> Array:
    return np.asarray(Rotation.from_euler('z', angle).as_matrix())
