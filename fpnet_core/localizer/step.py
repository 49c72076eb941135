# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Odometry check between two scans, by the motion and by the known walls.

Three hypotheses compete: odometry is right; it was reset, and the robot is within reach of its
last pose; it was reset, and the robot is at a place not observed before. Their odds depend on the
probability of a reset in the elapsed time, the probability of the motion, and the number of
returns on known walls: those of the last metres, or the plan's while localized. A frame that turns
or jumps, odometry that was blind for some seconds and kidnapping contradict many of these walls at
once; furniture and people that move do not.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from fpnet_core.geometry import SE2, Placements, wrap_to_pi
from fpnet_core.geometry.distinct import evenly_drawn, first_distinct
from fpnet_core.pose import AGAIN, RIGID_STRAIN, AlignmentPrior, MapEvidence, refine, wall_support
from fpnet_core.pose.verify import COARSE_SIGMA_M

Array = NDArray[np.float64]

_RESETS_PER_S2 = 0.02
"""
Chosen: the odds of an odometry reset between two scans, per square of the elapsed time, since the
error of a motion that is not measured grows in this way.
"""

_TOP_SPEEDS = 3.0  # chosen: top speed in standard deviations of the speed
_TURN_RADPS = 5.0  # physical: standard deviation of turns; some make half a turn in 0.2 s
_LEAST_M, _LEAST_RAD = 0.05, 0.05  # physical: error of odometry between any two scans
_NATS = 0.3  # chosen: information of a return on a known wall; about eight are correlated
_KNOWN = 0.5  # chosen: share of returns on known walls below which a place is rather new
_ALIKE = 0.75  # chosen: the same for the best of all places tried, since rooms look alike
_REACH_M = 8.0  # numerical: search radius around the last pose
_STEP_M, _STEP_RAD = 0.4, 0.1  # numerical: grid of the search
_FEW, _MANY, _TRIED = 100, 400, 12  # numerical: returns at first and finally, places refined
_NEAR_M = 0.5  # numerical: places that move returns by less are the same


@dataclass(frozen=True)
class StepOutcome:
    """
    Probability ``on`` that odometry is right, and its new frame otherwise.

    ``T_old_new`` maps its current frame to that of the last scan, with ``probability``; None if
    the robot is more likely at a new place.
    """

    on: float
    T_old_new: SE2 | None
    probability: float = 0.0


class ScanStep:
    """
    Motion between two scans by an odometry that may have been reset.

    Parameters
    ----------
    last, now : ``T_odom_sensor (4, 4)`` of both scans
    elapsed_s : time between them
    top_mps : maximum speed of the robot
    """

    def __init__(self, last: Array, now: Array, elapsed_s: float, top_mps: float) -> None:
        self._last_xy, self._xy = last[:2, 3], now[:2, 3]
        # From the full rotations: a sensor mounted upright has no yaw of its own.
        self.standing = SE2.from_matrix4(last @ np.linalg.inv(now))
        speed_mps = top_mps / _TOP_SPEEDS
        self._sigma_m = speed_mps * elapsed_s + _LEAST_M
        self._sigma_rad = _TURN_RADPS * elapsed_s + _LEAST_RAD
        odds = _RESETS_PER_S2 * elapsed_s**2
        self._log_right, self._log_reset = -math.log1p(odds), math.log(odds) - math.log1p(odds)

    def in_words(self, T_old_new: SE2) -> str:
        """Return a description of the jump of an odometry whose frame is now ``T_old_new``."""
        off_m = float(np.linalg.norm(T_old_new.apply(self._xy) - self._xy))
        if abs(T_old_new.yaw) * self._sigma_m > off_m * self._sigma_rad:
            return f'jumped by {abs(math.degrees(T_old_new.yaw)):.0f} degrees'
        step_m = float(np.linalg.norm(self._xy - self._last_xy))
        return (
            f'jumped by {step_m:.2f} m' if step_m > self._sigma_m else f'is off by {off_m:.2f} m'
        )

    def scored(
        self,
        walls: MapEvidence | None,
        returns: Array,
        knows_all: bool = True,
        is_known_broken: bool = False,
    ) -> StepOutcome:
        """
        Return the posterior given ``returns (P, 2)``, odom, and known ``walls``; None: none known.

        Unless the walls are complete (``knows_all``), missing ones do not contradict odometry.
        """
        here = Placements.of([SE2.identity()])
        returns = evenly_drawn(returns, _MANY)
        walls = walls if len(returns) else None
        nats = 0.0 if walls is None else _NATS * len(returns)
        log_on, log_new = -math.inf, self._log_reset + _KNOWN * nats
        if not is_known_broken:
            log_on = self._log_right + float(self._log_motion(here)[0])
            if walls is not None:
                least = 0.0 if knows_all else _KNOWN
                log_on += nats * max(float(wall_support(walls, returns, here)[0]), least)
        if walls is None or log_on > self._log_reset + nats + math.log(len(returns) + 1.0):
            total = np.logaddexp(log_on, log_new)
            return StepOutcome(math.exp(log_on - total), self.standing)
        places, log_p = self._places(walls, returns, nats)
        on = math.exp(log_on - logsumexp([log_on, log_new, *log_p]))
        others = [log_on, self._log_reset + _ALIKE * nats]
        if not len(places) or log_p[0] < max(others):
            return StepOutcome(on, None)
        x, y = places.translation[0].tolist()
        T_old_new = SE2.from_xy_yaw(x, y, float(places.heading[0]))
        return StepOutcome(on, T_old_new, math.exp(log_p[0] - logsumexp([*others, *log_p])))

    def _places(self, walls: MapEvidence, returns: Array, nats: float) -> tuple[Placements, Array]:
        """Return likely frames ``T_old_new`` after a reset, best first, with log odds."""
        tried = self._grid()
        log_motion = self._log_motion(tried)
        all_of_them = float(logsumexp(log_motion))
        few = evenly_drawn(returns, _FEW)
        at_first = log_motion + nats * wall_support(walls, few, tried, COARSE_SIGMA_M)
        best = np.argsort(-at_first, kind='stable')[:_TRIED]
        alignment_prior = AlignmentPrior(RIGID_STRAIN, np.eye(2))
        found = refine(walls, returns, tried.take(best), alignment_prior, AGAIN)
        log_p = self._log_motion(found) - all_of_them
        log_p = self._log_reset + log_p + nats * wall_support(walls, returns, found)
        order = np.argsort(-log_p, kind='stable')
        found, log_p = found.take(order), log_p[order]
        placed = np.concatenate([found.apply(few), few[None]])

        def is_same(one: int, others: NDArray[np.int64]) -> NDArray[np.bool_]:
            apart = np.linalg.norm(placed[others] - placed[one], axis=-1)
            return np.asarray(apart.mean(axis=-1) < _NEAR_M)

        other = ~is_same(len(found), np.arange(len(found)))  # differs from the odometry's place
        kept = first_distinct(len(found), is_same)
        kept = kept[other[kept]]
        return found.take(kept), log_p[kept]

    def _grid(self) -> Placements:
        """Return the grid of frames ``T_old_new`` within reach of the robot."""
        reach_m, reach_rad = min(2.0 * self._sigma_m, _REACH_M), min(2.0 * self._sigma_rad, np.pi)
        steps, turns = int(reach_m / _STEP_M), int(reach_rad / _STEP_RAD)
        x, y, turn = np.meshgrid(
            np.arange(-steps, steps + 1) * _STEP_M,
            np.arange(-steps, steps + 1) * _STEP_M,
            np.arange(-turns, turns + 1) * _STEP_RAD,
        )
        near = np.hypot(x, y) <= reach_m
        moved, yaw = np.stack([x[near], y[near]], axis=1), self.standing.yaw + turn[near]
        c, s = np.cos(yaw), np.sin(yaw)
        linear = np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=1)
        return Placements(linear, self._last_xy + moved - linear @ self._xy)

    def _log_motion(self, frames: Placements) -> Array:
        """Return the log likelihood of the motion in each frame, relative to standing still."""
        moved = np.linalg.norm(
            frames.linear @ self._xy + frames.translation - self._last_xy, axis=1
        )
        turned = wrap_to_pi(frames.heading - self.standing.yaw)
        squares = (moved / self._sigma_m) ** 2 + (turned / self._sigma_rad) ** 2
        return np.asarray(-0.5 * squares)
