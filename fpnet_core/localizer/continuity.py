# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a scan goes on in the odometry frame of the one before, or a new frame has begun."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2
from fpnet_core.geometry.pose_track import impossible_turn_rad
from fpnet_core.stamps import NS_PER_S, ClockGuard


@dataclass(frozen=True, eq=False)
class Break:
    """
    Why a scan does not go on from the last one.

    ``T_old_new`` maps the new odometry frame to the old one if the robot has hardly moved, only
    its coordinates have; None where nothing is known.
    """

    reason: str
    T_old_new: SE2 | None = None


class Continuity:
    """Follows stamps and poses of the scans of one odometry frame."""

    def __init__(self, config: LocalizerConfig) -> None:
        self._config = config
        self.forget()

    def forget(self) -> None:
        """Begin anew: the next scan breaks nothing."""
        self.last: tuple[int, NDArray[np.float64]] | None = None  # stamp and T_odom_sensor
        self._clock = ClockGuard(self._config.stale_scans_before_restart)
        self._is_replaced = False

    def follow(self, config: LocalizerConfig) -> None:
        """Take another speed limit; the patience with old scans is that of the next beginning."""
        self._config = config

    def go_on_from(self, stamp_ns: int, T_odom_sensor: NDArray[np.float64]) -> None:
        """Take a scan that was used as the last one."""
        self.last = stamp_ns, T_odom_sensor

    def expect_new_frame(self) -> None:
        """Say that the next scan comes with a new odometry frame, if one has come at all."""
        self._is_replaced = self.last is not None

    def check(self, stamp_ns: int, T_odom_sensor: NDArray[np.float64]) -> Break | None:
        """
        Return what breaks between the last scan and this one, None where it goes on.

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
                return Break(f'the clock went back by {back_s:.3f} s')
        reason = 'was restarted' if self._is_replaced else self._jump(stamp_ns, T_odom_sensor)
        if not reason:
            return None
        T_old_new = SE2.from_matrix4(last_pose) @ SE2.from_matrix4(T_odom_sensor).inv()
        return Break(f'odometry {reason}', T_old_new)

    def _jump(self, stamp_ns: int, T_odom_sensor: NDArray[np.float64]) -> str:
        """Say how no robot moves between the last scan and this one; empty where one may."""
        assert self.last is not None  # there is nothing to jump from before
        last_ns, last_pose = self.last
        elapsed_s = max((stamp_ns - last_ns) / NS_PER_S, 0.1)
        step_m = float(np.linalg.norm(T_odom_sensor[:3, 3] - last_pose[:3, 3]))
        if step_m > self._config.max_speed_mps * elapsed_s:
            return f'jumped by {step_m:.2f} m'
        turn_rad = impossible_turn_rad(last_pose, T_odom_sensor, elapsed_s)
        return f'jumped by {math.degrees(turn_rad):.0f} degrees' if turn_rad else ''
