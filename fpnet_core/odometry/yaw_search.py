# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How a sensor turned during a sweep, by a search over heading and turn rate.

Registration begins where the last motion leads to. A person with a lidar in the hand changes the
turn rate by a hundred degrees a second from one sweep to the next: the guess is ten degrees off,
the sweep is deskewed by a wrong motion, and the map takes it so. The likelihood field (Thrun et
al., Probabilistic Robotics, 6.4) of the walls that the last sweeps saw tells both at once: heading
and turn rate are those with which a deskewed sweep lies on them.
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
    'the turns of the gyroscope do not fit the scans and are ignored until they do: are its rates '
    'in rad/s, and is its orientation on /tf_static right?',
)
_ACCEPTED = logging.INFO, 'the turns of the gyroscope fit the scans and are used from now on'

_CELL_M, _HALF = 0.1, 160  # numerical: of the likelihood field, 16 m to each side
_SIGMA_M = 0.15
"""Standard deviation of returns around the walls of a few sweeps [m]. Chosen: noise and drift."""

_SWEEPS = 5
"""Sweeps whose walls make the field. Chosen: half a second."""

_RETURNS, _FEWEST = 400, 50
"""Returns that are laid on the field, at most and at least. Chosen: for 5 ms of a core."""

_OFF_RAD, _CHANGE_RAD = math.radians(1.0), math.radians(8.0)
"""
Prior of the heading where a sweep begins, and of the turn rate's change in a period [rad]: one
standard deviation costs ``_PRIOR`` of the mean likelihood. Chosen on simulated walks.
"""

_PRIOR = 0.005
_GAIN = 0.01
"""By less of the mean likelihood no guess is left. Chosen: below it a robot's are as good."""

_MISFIT, _NEWEST = 0.05, 0.05
"""
So much more likely is the best turn than that of a gyroscope that is wrong: in one sweep, and in
the mean over sweeps, of which the newest has this weight. Chosen on simulated walks, where it is
0.005 in nine of ten sweeps and 0.02 in the mean at most, and 0.06 with rates a half too small.
"""

_PROVEN, _BROKEN = 0.03, 0.1
"""
Means below and above which a gyroscope is accepted, and rejected. Chosen: from ``_MISFIT``, where
it begins, both take some ten sweeps that tell.
"""

# Numerical: steps of the search [rad], each over so many of them to either side in heading and in
# turn rate, around the best before.
_GRIDS = ((math.radians(3.0), 5, 10), (math.radians(1.0), 2, 3), (math.radians(0.4), 2, 3))

_TOLD_RAD = math.radians(3.0)
"""A gyroscope's turn that is so far from the guess tells whether it works [rad]. Chosen."""


@dataclass(frozen=True, eq=False)
class Guess:
    """
    Where a sensor may be at the stamp of a sweep, and how it moved.

    ``T_odom_sensor (4, 4)`` is its pose, ``T_start_end (4, 4)`` the motion during one period that
    deskews the sweep.
    """

    T_odom_sensor: Array
    T_start_end: Array

    @classmethod
    def of(cls, T_odom_sensor: Array, motion: Array) -> Guess:
        """Return a guess; KISS-ICP ends the process at a rotation that rounding has bent."""
        motion = motion.copy()
        motion[:3, :3] = Rotation.from_matrix(motion[:3, :3]).as_matrix()
        return cls(T_odom_sensor, motion)

    @classmethod
    def moved(cls, T_last: Array, motion: Array) -> Guess:
        """Return where a motion ``(4, 4)`` leads to from the last pose."""
        return cls.of(T_last @ motion, motion)

    def apart_rad(self, other: Guess) -> float:
        """Return the angle between the turns of two guesses [rad]."""
        turn = self.T_start_end[:3, :3].T @ other.T_start_end[:3, :3]
        return float(Rotation.from_matrix(turn).magnitude())


class YawSearch:
    """Finds heading and turn rate of each sweep among the walls of the last ones."""

    def __init__(self) -> None:
        self._walls: deque[Array] = deque(maxlen=_SWEEPS)
        self._misfit = _MISFIT  # likelihood that the gyroscope's turns lack, in the mean
        self._is_accepted: bool | None = None  # nobody knows yet

    def note(self, walls: Array) -> None:
        """Take what a registered sweep saw of walls ``(P, 3)``, odometry frame [m]."""
        self._walls.append(walls)

    def best(
        self, guess: Guess, by_gyro: Guess | None, walls: Array, share: Array, stamp_share: float
    ) -> tuple[Guess, bool]:
        """
        Return the most likely guess, and whether the walls have told it.

        Parameters
        ----------
        guess
            From which the search begins, and which stays where the walls tell nothing.
        by_gyro
            Another one, which is used unless it does not fit the walls.
        walls : (P, 3)
            Upright returns of the sweep as they came, sensor frame [m].
        share : (P,)
            When they were seen, in periods from the stamp; empty: all at the stamp.
        stamp_share
            From the middle of the sweep to its stamp, in periods.
        """
        every = max(1, len(walls) // _RETURNS)
        walls, share = walls[::every], share[::every]
        if len(walls) < _FEWEST or not self._walls:
            return guess if by_gyro is None or not self._is_accepted else by_gyro, False
        centre = guess.T_odom_sensor[:2, 3]
        field = _likelihood_field(np.vstack(self._walls)[:, :2] - centre)
        laid = _Laid.of(guess, walls, share, stamp_share, centre)
        best, begun = np.zeros(2), float(laid.likelihood(field, np.zeros((1, 2)))[0])
        most = begun
        for step, headings, rates in _GRIDS:
            tried = best + step * _grid(headings, rates if len(share) else None)
            found = laid.likelihood(field, tried)
            if found.max() > most:
                best, most = tried[int(found.argmax())], float(found.max())
        if by_gyro is not None:
            laid = _Laid.of(by_gyro, walls, share, stamp_share, centre)
            misfit = most - float(laid.likelihood(field, np.zeros((1, 2)))[0])
            if self._accepts(misfit, guess.apart_rad(by_gyro)):
                return by_gyro, False
        if most - begun < _GAIN:
            return guess, False
        return _turned(guess, best[0] + stamp_share * best[1], best[1]), True

    def _accepts(self, misfit: float, apart_rad: float) -> bool:
        """
        Tell whether the gyroscope's turn is used, given its misfit to the walls.

        Where it equals that of the guess, the misfit tells nothing about the gyroscope.
        """
        weight = _NEWEST * min(1.0, apart_rad / _TOLD_RAD)
        self._misfit += weight * (misfit - self._misfit)
        was_accepted = self._is_accepted
        if self._misfit < _PROVEN or self._misfit > _BROKEN:
            self._is_accepted = self._misfit < _PROVEN
        if self._is_accepted is not was_accepted:
            _log.log(*(_ACCEPTED if self._is_accepted else _REJECTED))
        return misfit < _MISFIT and self._is_accepted is True


@dataclass(frozen=True, eq=False)
class _Laid:
    """
    A sweep where a guess lays it, in the plane.

    ``arm (P, 2)`` is from the sensor to the returns and ``origin (2,)`` the sensor, both in axes
    of the odometry frame [m]; ``time (P,)`` is in periods from the sweep's middle, and ``since``
    those from the last pose to there.
    """

    arm: NDArray[np.float32]
    origin: Array
    time: NDArray[np.float32]
    since: float

    @classmethod
    def of(
        cls, guess: Guess, walls: Array, share: Array, stamp_share: float, centre: Array
    ) -> _Laid:
        T = guess.T_odom_sensor
        still = carried(walls, guess.T_start_end, share) if len(share) else walls
        time = share + stamp_share if len(share) else np.zeros(len(walls))
        arm = (still @ T[:3, :3].T)[:, :2]
        since = 1.0 - stamp_share if len(share) else 1.0
        return cls(arm.astype(np.float32), T[:2, 3] - centre, time.astype(np.float32), since)

    def likelihood(self, field: NDArray[np.float32], tried: Array) -> Array:
        """
        Return the mean likelihood ``(N,)`` of changes ``tried (N, 2)``, less their prior.

        Of the heading in the sweep's middle [rad] and of the turn rate [rad/period].
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
    """Return how likely a return is in each cell around the origin, for walls ``(P, 2)`` [m]."""
    is_inside = (np.abs(walls) < _HALF * _CELL_M).all(axis=1)
    raster = np.full((2 * _HALF, 2 * _HALF), 1, dtype=np.uint8)
    raster[_cells(walls[is_inside, 1]), _cells(walls[is_inside, 0])] = 0
    away_m = cv2.distanceTransform(raster, cv2.DIST_L2, 3) * _CELL_M
    likelihood = np.exp(-0.5 * np.square(away_m / _SIGMA_M, dtype=np.float64))
    return np.asarray(likelihood, dtype=np.float32)


def _cells(metres: NDArray[np.floating]) -> NDArray[np.int32]:
    """Return rows or columns of the field; those outside are at its edge."""
    cells: NDArray[np.int32] = np.floor(metres / _CELL_M).astype(np.int32) + _HALF
    return np.clip(cells, 0, 2 * _HALF - 1)


def _grid(headings: int, rates: int | None) -> Array:
    """Return pairs ``(N, 2)`` of whole numbers to both sides of 0: all, or equal ones for None."""
    if rates is None:
        return np.repeat(np.arange(-headings, headings + 1.0), 2).reshape(-1, 2)
    heading, rate = np.mgrid[-headings : headings + 1, -rates : rates + 1]
    return np.stack([heading.ravel(), rate.ravel()], axis=1).astype(np.float64)


def _turned(guess: Guess, heading: float, rate: float) -> Guess:
    """Return a guess with another heading at the stamp and turn rate, about the odometry's z."""
    T, motion = guess.T_odom_sensor.copy(), guess.T_start_end.copy()
    R = guess.T_odom_sensor[:3, :3]
    T[:3, :3] = _about_z(heading) @ R
    motion[:3, :3] = R.T @ _about_z(rate) @ R @ motion[:3, :3]
    return Guess.of(T, motion)


def _about_z(angle: float) -> Array:
    return np.asarray(Rotation.from_euler('z', angle).as_matrix())
