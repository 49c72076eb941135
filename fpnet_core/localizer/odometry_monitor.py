# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detection of odometry resets: whether a scan continues the odometry frame of the last one."""

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
"""Given: a scan without returns."""

_WITHIN_M = 20.0  # numerical: walls farther from the robot are not visible
_CELL_M = 0.1  # numerical: of the raster of known walls
_SHORTEST_S = 0.1  # numerical: messages in bursts have closer stamps


@dataclass(frozen=True, eq=False)
class OdometryReset:
    """
    Reason why a scan does not continue the last one.

    ``T_old_new`` maps the new odometry frame to the old one: by the walls, with
    ``probability``, or else by assuming that the robot has hardly moved; None if
    it is unknown.
    """

    reason: str
    T_old_new: SE2 | None = None
    probability: float = 0.0


class OdometryMonitor:
    """Monitors stamps, poses and returns of the scans of one odometry frame."""

    def __init__(self, config: LocalizerConfig) -> None:
        self._config = config
        self.forget()

    def forget(self) -> None:
        """Restart: the next scan cannot be a reset."""
        self.last: tuple[int, Array] | None = None  # stamp and T_odom_sensor
        self._clock = ClockGuard(self._config.stale_scans_before_restart)
        self._is_replaced = False

    def follow(self, config: LocalizerConfig) -> None:
        """Set another speed limit; the limit for old stamps changes with the next restart."""
        self._config = config

    def go_on_from(self, stamp_ns: int, T_odom_sensor: Array) -> None:
        """Set the last scan that was used."""
        self.last = stamp_ns, T_odom_sensor

    def expect_new_frame(self) -> None:
        """Report that the next scan has a new odometry frame; ignored before the first scan."""
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
        Return the reset between the last scan and this one; None if the frame continues.

        ``returns (P, 2)`` are those at body height, placed by odometry [m], and ``walls``
        the known walls there; ``knows_all``: they include those of rooms not observed yet.

        Raises
        ------
        OdometryError
            If the scan is not newer than the last one; many in a row count as a clock reset.
        """
        if self.last is None:
            return None
        last_ns, last_pose = self.last
        if not self._is_replaced:  # a new frame may have another clock
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
    """Known walls near the robot: those of the last metres and, while localized, the plan's."""

    def __init__(self) -> None:
        self._made_of: tuple[object, ...] = ()
        self._evidence: MapEvidence | None = None

    def around(
        self, xy: Array, recent: Array, drawn: Array | None, A_plan_odom: Affine2D | None
    ) -> MapEvidence | None:
        """
        Return the walls as evidence in ``odom``, None without any; cached while unchanged.

        Parameters
        ----------
        xy : (2,) last position of the robot, odom [m]
        recent : (P, 2) returns over the last metres, odom [m]
        drawn : (Q, 2) walls of the floorplan, nominal metres
        A_plan_odom : placement on the floorplan; None while not localized
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
