# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Whether sweeps without times are of one instant or bent by the motion: the map tells.

A simulator's sweep is of one instant; that of a driver that keeps the times to itself took a
tenth of a second, and its walls are bent by the motion. When each point was seen is then in the
order of the points: one turn column by column, or row by row. By that order the motion shifts
each point, and least squares tell which part of the shift brings a sweep to the walls of the map,
together with a motion of the sweep as a whole. In turns it is near 0 for sweeps of an instant and
near 1 for others, within a few sweeps.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
import logging

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fpnet_core.geometry.motion import carried
from fpnet_core.odometry.registration import upright

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

_BACK_TURNS = 0.1
"""Clouds whose azimuths go back by more [turns] have no order that tells times. Chosen."""

_FEWEST_TURNS = 0.3
"""Those that turn by less have none either. Chosen: sectors of a hundred degrees do turn."""

_FEWEST_ROWS = 2  # given: one row, or columns, turn once
_TOGETHER = 0.7
"""Rows begin together where the mean of the unit vectors there is longer than this. Chosen."""

_RETURNS, _POINTS = 8000, 1500
"""Returns of a sweep that are looked at, and upright ones that are compared. Chosen: for 10 ms."""

_SWEEPS = 11
"""Sweeps from one to the one that it is compared to: a second, in which motion changes. Chosen."""

_NEIGHBOURS, _NEAR_M = 6, 0.8
"""Returns that make a wall, and how near all of them are [m]. Chosen."""

_THICK_M, _LONG_M = 0.05, 0.1
"""Standard deviations of those across and along a wall, at most and at least [m]. Chosen."""

_FEWEST = 100
"""With fewer returns at walls a sweep tells nothing. Chosen."""

_SHIFT_M = 0.01
"""Nor do two whose points are shifted by less in the mean square [m]. Chosen: ranges' noise."""

_ENOUGH_M2 = 0.03
"""
Sum over sweeps of the mean square that no motion of the whole sweep explains [m^2], with which it
is decided. Chosen: one to four seconds of turns.
"""


_DOUBT_M2 = 0.003
"""As much of that speaks for sweeps of an instant from the beginning [m^2]. Chosen."""

_FARTHEST_M = 0.4
"""Returns that are farther from a wall [m] are of another. Chosen."""

_ROUNDS, _RIDGE = 3, 1e-9  # numerical: of weighted least squares
_MAD = 1.4826  # given: standard deviations of a normal distribution in its median deviation

_BENT = (
    'sweeps without times are bent by the motion during a sweep, which is undone by the order of '
    'their points'
)
_INSTANT = 'sweeps without times are not bent by the motion: each is taken for one instant'


def turn_shares(points: Array) -> Array | None:
    """
    Return which part of a turn, 0 to 1, was done when each of a cloud's points was seen ``(P,)``.

    By their order: column by column through one turn, or row by row, each through all of it; None
    where it is neither. Points in the sensor or not finite have no part, which is 0.
    """
    is_seen = np.isfinite(points).all(axis=1) & points[:, :2].any(axis=1)
    if np.count_nonzero(is_seen) < _FEWEST:
        return None
    found = _shares_in_order(points[is_seen])
    if found is None:
        return None
    shares = np.zeros(len(points))
    shares[is_seen] = found
    return shares


def _shares_in_order(points: Array) -> Array | None:
    turns = np.arctan2(points[:, 1], points[:, 0]) / (2.0 * np.pi)
    steps = np.diff(turns)
    turned = np.concatenate([[0.0], np.cumsum(steps - np.round(steps))])
    if turned[-1] < 0.0:
        turned, turns = -turned, -turns
    back = float(np.max(np.maximum.accumulate(turned) - turned))
    if back > _BACK_TURNS or turned[-1] < _FEWEST_TURNS:
        return None
    rows = round(float(turned[-1]))
    if rows < _FEWEST_ROWS:
        shares: Array = np.maximum(turned, 0.0) / max(1.0, float(turned.max()))
        return shares
    elevation = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))
    begins = 1 + np.argpartition(np.abs(np.diff(elevation)), 1 - rows)[1 - rows :]
    seam = np.exp(2j * np.pi * turns[begins]).mean()
    if abs(seam) < _TOGETHER:
        return None
    return np.asarray((turns - np.angle(seam) / (2.0 * np.pi)) % 1.0)


class DeskewDetector:
    """
    Finds out whether the motion bends sweeps without times.

    Until it is decided, ``part`` is what the evidence so far says: with sweeps undone rightly the
    map is right as well.

    Parameters
    ----------
    is_decided
        From the beginning: sweeps are of one instant, whatever the map says.
    """

    def __init__(self, is_decided: bool = False) -> None:
        self._sum, self._information = 0.0, 0.0
        self._seen: deque[_Walls] = deque(maxlen=_SWEEPS)
        self.is_decided = is_decided

    @property
    def part(self) -> float:
        """Which part of the motion is to be undone: 0, 1, or -1 where the order runs backwards."""
        found = self._sum / (self._information + _DOUBT_M2)
        return float(np.clip(np.round(found), -1.0, 1.0))

    def look(self, sweep: Array, shares: Array, T_odom_sensor: Array, motion: Array) -> None:
        """
        Take the evidence of one sweep.

        Parameters
        ----------
        sweep : (P, 3)
            As it came, sensor frame [m].
        shares : (P,)
            Of the motion, from the sweep's middle on, by the order of points: -0.5 to 0.5.
        T_odom_sensor : (4, 4)
            Where it was registered.
        motion : (4, 4)
            Of the sensor since the last sweep.
        """
        seen = _Walls.of(sweep, shares, T_odom_sensor, motion)
        self._seen.append(seen)
        before = self._seen[0]
        if len(self._seen) < _SWEEPS or max(seen.shift_m, before.shift_m) < _SHIFT_M:
            return
        distance, slopes = _apart(seen, before)
        if len(distance) < _FEWEST:
            return
        part, information = _fitted(distance, slopes)
        self._sum += part * information
        self._information += information
        if self._information > _ENOUGH_M2:
            self.is_decided = True
            self._seen.clear()
            _log.info(_BENT if self.part else _INSTANT)


@dataclass(frozen=True, eq=False)
class _Walls:
    """
    Upright returns ``middle (P, 3)`` of a sweep, odometry frame, with half of the shift undone.

    None and all of it are judged alike from there. ``shift (P, 3)`` [m] is all of it, ``origin``
    ``(3,)`` where the sensor was.
    """

    middle: Array
    shift: Array
    origin: Array

    @classmethod
    def of(cls, sweep: Array, shares: Array, T: Array, motion: Array) -> _Walls:
        every = max(1, len(sweep) // _RETURNS)
        sweep, shares = sweep[::every], shares[::every]
        shift = (carried(sweep, motion, shares) - sweep) @ T[:3, :3].T
        middle = sweep @ T[:3, :3].T + T[:3, 3] + 0.5 * shift
        stands = upright(middle)
        return cls(middle[stands], shift[stands], T[:3, 3])

    @property
    def shift_m(self) -> float:
        """Root of the mean square of the shift, but for that of all together."""
        return float(np.linalg.norm(self.shift.std(axis=0))) if len(self.shift) else 0.0


def _apart(seen: _Walls, before: _Walls) -> tuple[Array, Array]:
    """
    Return how far a sweep's returns are from an earlier one's walls, and what that depends on.

    Both are shifted, each by its own motion: what bends both alike tells nothing.

    Returns
    -------
    distance : (N,)
        Along the walls' normals [m].
    slopes : (N, 4)
        Of that distance: to x, y and yaw of the sensor, and to the part of the shift.
    """
    if len(before.middle) < _FEWEST:
        return np.zeros(0), np.zeros((0, 4))
    chosen = slice(None, None, max(1, len(seen.middle) // _POINTS))
    at, shift = seen.middle[chosen], seen.shift[chosen]
    away, near = cKDTree(before.middle).query(at, k=_NEIGHBOURS, distance_upper_bound=_NEAR_M)
    has_wall = np.isfinite(away).all(axis=1)
    near, at, shift = near[has_wall], at[has_wall, :2], shift[has_wall, :2]
    patch = before.middle[near, :2]
    centre = patch.mean(axis=1)
    patch -= centre[:, None]
    spread, axes = np.linalg.eigh(np.einsum('nki,nkj->nij', patch, patch) / _NEIGHBOURS)
    normal = axes[:, :, 0]
    distance = np.einsum('ni,ni->n', normal, centre - at)
    arm = at - seen.origin[:2]
    turn = arm[:, 0] * normal[:, 1] - arm[:, 1] * normal[:, 0]
    shift = shift - before.shift[near, :2].mean(axis=1)
    slopes = np.column_stack([normal, turn, np.einsum('ni,ni->n', normal, shift)])
    is_wall = (spread[:, 0] < _THICK_M**2) & (spread[:, 1] > _LONG_M**2)
    is_wall &= np.abs(distance) < _FARTHEST_M
    return distance[is_wall], slopes[is_wall]


def _fitted(distance: Array, slopes: Array) -> tuple[float, float]:
    """
    Return the part of the shift that fits best, and the mean square [m^2] that it was told by.

    Robust least squares for the pose in the plane as well; what the pose explains tells nothing.
    """
    weight = np.ones(len(distance))
    for _ in range(_ROUNDS):
        normal = (slopes * weight[:, None]).T @ slopes + _RIDGE * np.eye(4)
        found = np.linalg.solve(normal, (slopes * weight[:, None]).T @ distance)
        rest = distance - slopes @ found
        sigma = _MAD * float(np.median(np.abs(rest))) + _RIDGE
        weight = np.exp(-0.5 * (rest / (2.0 * sigma)) ** 2)
    free = normal[3, 3] - normal[3, :3] @ np.linalg.solve(normal[:3, :3], normal[:3, 3])
    return 0.5 + float(found[3]), float(free / len(distance))
