# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a scan goes on in the odometry frame of the one before, or a new frame has begun."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.localizer.step import ScanStep
from fpnet_core.pose import MapEvidence, map_evidence
from fpnet_core.scoring.reasons import CONTRADICTED
from fpnet_core.stamps import NS_PER_S, ClockGuard
from fpnet_core.types import FREE, OCCUPIED, GridMap

Array = NDArray[np.float64]

NO_RETURNS = np.zeros((0, 2))
"""Given: a scan that sees nothing."""

_WITHIN_M = 20.0  # numerical: walls farther from where the robot was are out of its sight
_CELL_M = 0.1  # numerical: of the raster of walls that are known
_SHORTEST_S = 0.1  # numerical: stamps of messages that come in bursts are nearer to one another


@dataclass(frozen=True, eq=False)
class OdometryReset:
    """
    Why a scan does not go on from the last one.

    ``T_old_new`` maps the new odometry frame to the old one, as the walls say with
    ``probability``, or else if the robot has hardly moved, only its coordinates have; None where
    nothing is known.
    """

    reason: str
    T_old_new: SE2 | None = None
    probability: float = 0.0


class OdometryMonitor:
    """Follows stamps, poses and returns of the scans of one odometry frame."""

    def __init__(self, config: LocalizerConfig) -> None:
        self._config = config
        self.forget()

    def forget(self) -> None:
        """Begin anew: the next scan breaks nothing."""
        self.last: tuple[int, Array] | None = None  # stamp and T_odom_sensor
        self._clock = ClockGuard(self._config.stale_scans_before_restart)
        self._is_replaced = False

    def follow(self, config: LocalizerConfig) -> None:
        """Take another speed limit; the patience with old scans is that of the next beginning."""
        self._config = config

    def go_on_from(self, stamp_ns: int, T_odom_sensor: Array) -> None:
        """Take a scan that was used as the last one."""
        self.last = stamp_ns, T_odom_sensor

    def expect_new_frame(self) -> None:
        """Say that the next scan comes with a new odometry frame, if one has come at all."""
        self._is_replaced = self.last is not None

    def check(
        self,
        stamp_ns: int,
        T_odom_sensor: Array,
        returns: Array = NO_RETURNS,
        walls: MapEvidence | None = None,
        knows_all: bool = False,
    ) -> OdometryReset | None:
        """
        Return what breaks between the last scan and this one, None where it goes on.

        ``returns (P, 2)`` are those at body height, where odometry puts them [m], and ``walls``
        what is known of walls there; ``knows_all``: those of new rooms as well.

        Raises
        ------
        OdometryError
            If the scan is no newer than the last one; many in a row are a clock that was reset.
        """
        if self.last is None:
            return None
        last_ns, last_pose = self.last
        if not self._is_replaced:  # a new frame may come with another clock
            back_s = self._clock.back_s(stamp_ns, last_ns)
            if back_s is not None:
                return OdometryReset(f'the clock went back by {back_s:.3f} s')
        elapsed_s = max((stamp_ns - last_ns) / NS_PER_S, _SHORTEST_S)
        step = ScanStep(last_pose, T_odom_sensor, elapsed_s, self._config.max_speed_mps)
        found = step.scored(walls, returns, knows_all, self._is_replaced)
        if found.on >= self._config.release_probability:
            return None
        if self._is_replaced:
            T_old_new = found.T_old_new or step.standing
            return OdometryReset('odometry was restarted', T_old_new, found.probability)
        if found.T_old_new is None:
            return OdometryReset(CONTRADICTED)
        jumped = step.in_words(found.T_old_new)
        return OdometryReset(f'odometry {jumped}', found.T_old_new, found.probability)


class KnownWalls:
    """The walls around the robot: seen over the last metres and, under a claim, drawn ones."""

    def __init__(self) -> None:
        self._made_of: tuple[object, ...] = ()
        self._evidence: MapEvidence | None = None

    def around(
        self, xy: Array, recent: Array, drawn: Array | None, A_plan_odom: Affine2D | None
    ) -> MapEvidence | None:
        """
        Return the walls as evidence in ``odom``, None without any; the same as long as they are.

        Parameters
        ----------
        xy : (2,) where the robot was last, odom [m]
        recent : (P, 2) returns over the last metres, odom [m]
        drawn : (Q, 2) walls of the floorplan, nominal metres
        A_plan_odom : where the robot is on it; None without a claim
        """
        made_of = recent, A_plan_odom
        if any(a is not b for a, b in zip_longest(made_of, self._made_of)):
            if drawn is not None and A_plan_odom is not None:
                recent = np.concatenate([recent, A_plan_odom.inv().apply(drawn)])
            near = recent[np.linalg.norm(recent - xy, axis=1) < _WITHIN_M]
            self._made_of = made_of
            self._evidence = _evidence_of(near) if len(near) else None
        return self._evidence


def _evidence_of(walls: Array) -> MapEvidence:
    low = walls.min(axis=0) - _CELL_M
    cells = np.full(np.ceil(np.ptp(walls, axis=0) / _CELL_M).astype(int)[::-1] + 3, FREE)
    col, row = np.floor((walls - low) / _CELL_M).astype(int).T
    cells[row, col] = OCCUPIED
    T_odom_grid = SE2.from_xy_yaw(float(low[0]), float(low[1]), 0.0)
    return map_evidence(GridMap(cells, _CELL_M, T_odom_grid, 'odom'))
