# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pose hint from a user or node: it selects between placements but does not confirm one."""

from __future__ import annotations

from dataclasses import dataclass, replace
import logging

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2, Affine2D, Placements, angle_between
from fpnet_core.scoring.scorer import WORD

_log = logging.getLogger(__name__)

# Chosen, not measured:
# A pose set by hand is used within this many standard deviations, and never more precisely than a
# person can click on a drawing.
_SIGMAS = 3.0
_LEAST_RADIUS_M = 2.0
_LEAST_YAW_RAD = np.deg2rad(30.0)


@dataclass(frozen=True, eq=False)
class PoseHint:
    """
    Hint that the robot at ``T_odom_base`` is at ``T_plan_base``, with standard deviations.

    ``is_doubted`` once an update found no placement near it: then it only
    selects between placements. ``storey`` is the one whose plan it refers to; empty: the current
    one. ``log_odds`` are those of the hint being correct.
    """

    T_plan_base: SE2
    T_odom_base: SE2
    position_sigma_m: float = 0.0
    yaw_sigma_rad: float = 0.0
    is_doubted: bool = False
    storey: str = ''
    log_odds: float = WORD

    @property
    def radius_m(self) -> float:
        """Largest position error of the hint [m]."""
        return max(_SIGMAS * self.position_sigma_m, _LEAST_RADIUS_M)

    @property
    def A_plan_odom(self) -> SE2:
        """Placement that corresponds to the hint."""
        T_plan_odom: SE2 = self.T_plan_base @ self.T_odom_base.inv()
        return T_plan_odom

    def agrees(self, A_plan_odom: Affine2D) -> bool:
        """Return whether a placement agrees with the hint about the robot's pose."""
        at = A_plan_odom.apply(self.T_odom_base.translation)
        yaw = A_plan_odom.apply_yaw(self.T_odom_base.yaw)
        distance_m = float(np.linalg.norm(at - self.T_plan_base.translation))
        turn_rad = abs(angle_between(yaw, self.T_plan_base.yaw))
        return distance_m <= self.radius_m and bool(
            turn_rad <= max(_SIGMAS * self.yaw_sigma_rad, _LEAST_YAW_RAD)
        )

    def agreeing(self, estimates: Placements, A_submap_odom: SE2) -> NDArray[np.bool_]:
        """Return which of ``C`` estimates agree, ``(C,)``."""
        agrees = [self.agrees(e.A_plan_submap @ A_submap_odom) for e in estimates]
        return np.array(agrees, dtype=np.bool_)

    def after(self, is_heeded: bool) -> PoseHint:
        """Return the hint after an update; logs once that no placement fits near it."""
        if is_heeded == (not self.is_doubted):
            return self
        if not is_heeded:
            _log.warning('no placement fits near the pose hint; searching the whole plan')
        return replace(self, is_doubted=not is_heeded)
