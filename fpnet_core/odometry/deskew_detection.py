# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection of motion skew in sweeps without point times.

A simulated sweep is instantaneous. A real one takes about 0.1 s; if the driver drops the times,
its walls are skewed by the motion. The order of the points then gives their times: one turn
column by column, or each row in turn. These times and the motion give a shift for each point.
Least squares estimate the fraction of this shift that best aligns a sweep with the walls of an
earlier one, jointly with a rigid correction of the sweep. When the robot turns, the fraction is
near 0 for instantaneous sweeps and near 1 for others, within a few sweeps.
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
"""If azimuths go back by more than this [turns], the order of points gives no times. Chosen."""

_FEWEST_TURNS = 0.3
"""Nor if they cover less than this [turns]. Chosen: allows sectors of about 100 degrees."""

_FEWEST_ROWS = 2  # given: a single row, or columns, make one turn
_TOGETHER = 0.7
"""Rows start at one azimuth if the mean of their unit vectors is longer than this. Chosen."""

_RETURNS, _POINTS = 8000, 1500
"""Returns used of a sweep, and upright ones that are compared. Chosen: for 10 ms."""

_SWEEPS = 11
"""Sweeps in the buffer: they are compared over a second, so that motion changes. Chosen."""

_NEIGHBOURS, _NEAR_M = 6, 0.8
"""Returns that define a wall patch, and their largest distance [m]. Chosen."""

_THICK_M, _LONG_M = 0.05, 0.1
"""Largest standard deviation across a wall patch and smallest one along it [m]. Chosen."""

_FEWEST = 100
"""A sweep with fewer returns from walls is not used. Chosen."""

_SHIFT_M = 0.01
"""Two sweeps with a smaller RMS shift of points [m] are not used. Chosen: noise of ranges."""

_ENOUGH_M2 = 0.03
"""
Evidence for a decision: sum over sweeps of the mean squared shift [m^2] that no rigid motion of
the sweep explains. Chosen: one to four seconds of turns.
"""


_DOUBT_M2 = 0.003
"""Prior evidence for instantaneous sweeps, in the same unit [m^2]. Chosen."""

_FARTHEST_M = 0.4
"""Returns farther from a wall patch [m] belong to another wall. Chosen."""

_ROUNDS, _RIDGE = 3, 1e-9  # numerical: of weighted least squares
_MAD = 1.4826  # given: standard deviation over median absolute deviation, normal distribution

_SKEWED = (
    'sweeps without times are skewed by the motion during a sweep; they are deskewed by the order '
    'of their points'
)
_INSTANT = 'sweeps without times are not skewed by the motion: they are treated as instantaneous'


def turn_shares(points: Array) -> Array | None:
    """
    Return for each point the fraction of a turn, 0 to 1, at which it was measured, ``(P,)``.

    Inferred from the order of points: column by column through one turn, or row by row with a turn
    each. None if the order is neither. Points that are zero or not finite get 0.
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
    Detects whether sweeps without times are skewed by the motion.

    Before the decision, ``part`` follows the evidence so far, so that the map is built from
    deskewed sweeps as early as possible.

    Parameters
    ----------
    is_decided
        Treat sweeps as instantaneous from the start, without detection.
    """

    def __init__(self, is_decided: bool = False) -> None:
        self._sum, self._information = 0.0, 0.0
        self._seen: deque[_Walls] = deque(maxlen=_SWEEPS)
        self.is_decided = is_decided

    @property
    def part(self) -> float:
        """Fraction of the motion to undo: 0, 1, or -1 if the order of points is reversed."""
        found = self._sum / (self._information + _DOUBT_M2)
        return float(np.clip(np.round(found), -1.0, 1.0))

    def look(self, sweep: Array, shares: Array, T_odom_sensor: Array, motion: Array) -> None:
        """
        Add the evidence of one sweep.

        Parameters
        ----------
        sweep : (P, 3)
            Raw points, sensor frame [m].
        shares : (P,)
            Share of the motion since the sweep's middle, by the order of points: -0.5 to 0.5.
        T_odom_sensor : (4, 4)
            Registered pose.
        motion : (4, 4)
            Motion of the sensor since the last sweep.
        """
        seen = _Walls.of(sweep, shares, T_odom_sensor, motion)
        self._seen.append(seen)
        before = self._seen[0]
        if len(self._seen) < _SWEEPS or max(seen.shift_m, before.shift_m) < _SHIFT_M:
            return
        distance, slopes = _wall_distances(seen, before)
        if len(distance) < _FEWEST:
            return
        part, information = _fit_part(distance, slopes)
        self._sum += part * information
        self._information += information
        if self._information > _ENOUGH_M2:
            self.is_decided = True
            self._seen.clear()
            _log.info(_SKEWED if self.part else _INSTANT)


@dataclass(frozen=True, eq=False)
class _Walls:
    """
    Upright returns ``middle (P, 3)`` of a sweep, odometry frame, with half of the shift undone.

    Half treats the two outcomes, none and all, alike. ``shift (P, 3)`` [m] is the full shift,
    ``origin (3,)`` the position of the sensor.
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
        """RMS of the shift about its mean [m]."""
        return float(np.linalg.norm(self.shift.std(axis=0))) if len(self.shift) else 0.0


def _wall_distances(seen: _Walls, before: _Walls) -> tuple[Array, Array]:
    """
    Return distances of a sweep's returns from the walls of an earlier one, with their Jacobian.

    Each sweep is shifted by its own motion; only the difference of the two shifts is evidence.

    Returns
    -------
    distance : (N,)
        Along the walls' normals [m].
    slopes : (N, 4)
        Derivatives with respect to x, y and yaw of the sensor, and the fraction of the shift.
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


def _fit_part(distance: Array, slopes: Array) -> tuple[float, float]:
    """
    Return the fraction of the shift that fits best, and its information [m^2].

    Robust least squares over planar pose and fraction; information excludes the pose's share.
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
