# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
From one scan to the next: has the odometry measured the robot's motion, or has it broken?

Three hypotheses compete. The odometry is right; it broke, and the robot is where robots get to in
the time; it broke, and the robot is at a place that the scans before have not seen. Their odds are
how likely an odometry breaks meanwhile, how likely a robot moves so, and how many returns of the
scan lie on walls that are known: seen over the last metres, or drawn around a claim. A frame that
turns or jumps, an odometry that was blind for some seconds and a robot that was carried off
contradict these walls at once; furniture and people that come and go do not.
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

_BREAKS_PER_S2 = 0.02
"""
Chosen: the odds that an odometry breaks between two scans, over the square of the time: so the
error of a motion grows that nobody measures.
"""

_TOP_SPEEDS = 3.0  # chosen: standard deviations of a robot's speed in its top speed
_TURN_RADPS = 5.0  # physical: standard deviation of turns; some make half a turn in 0.2 s
_LEAST_M, _LEAST_RAD = 0.05, 0.05  # physical: what odometry is off by between any two scans
_NATS = 0.3  # chosen: what one return tells by lying on a known wall; eight share its surprises
_KNOWN = 0.5  # chosen: the share of returns on known walls at which a place may as well be new
_ALIKE = 0.75  # chosen: the same at the best of all places that were tried: rooms look alike
_REACH_M = 8.0  # numerical: farther from the last place nobody looks
_STEP_M, _STEP_RAD = 0.4, 0.1  # numerical: from place to place
_FEW, _MANY, _TRIED = 100, 400, 12  # numerical: returns at first and in the end, best places
_NEAR_M = 0.5  # numerical: what moves returns by less is the same place


@dataclass(frozen=True)
class StepOutcome:
    """
    The probability ``on`` that the odometry is right, and where its frame is if it is not.

    ``T_old_new`` maps its frame now to that of the last scan, with ``probability``; None where the
    robot is rather at a new place.
    """

    on: float
    T_old_new: SE2 | None
    probability: float = 0.0


class ScanStep:
    """
    The motion between two scans by an odometry that may have broken.

    Parameters
    ----------
    last, now : ``T_odom_sensor (4, 4)`` of both scans
    elapsed_s : the time between them
    top_mps : how fast robots drive
    """

    def __init__(self, last: Array, now: Array, elapsed_s: float, top_mps: float) -> None:
        self._last_xy, self._xy = last[:2, 3], now[:2, 3]
        # By the turn of all axes: mounted upright, a sensor has no yaw of its own.
        self.standing = SE2.from_matrix4(last @ np.linalg.inv(now))
        speed_mps = top_mps / _TOP_SPEEDS
        self._sigma_m = speed_mps * elapsed_s + _LEAST_M
        self._sigma_rad = _TURN_RADPS * elapsed_s + _LEAST_RAD
        odds = _BREAKS_PER_S2 * elapsed_s**2
        self._log_right, self._log_break = -math.log1p(odds), math.log(odds) - math.log1p(odds)

    def in_words(self, T_old_new: SE2) -> str:
        """Say what an odometry did whose frame is now ``T_old_new``."""
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
        Weigh the hypotheses by the ``returns (P, 2)``, odom, on known ``walls``; None: none.

        Where these are not all that there are (``knows_all``), none contradicts an odometry.
        """
        here = Placements.of([SE2.identity()])
        returns = evenly_drawn(returns, _MANY)
        walls = walls if len(returns) else None
        nats = 0.0 if walls is None else _NATS * len(returns)
        log_on, log_new = -math.inf, self._log_break + _KNOWN * nats
        if not is_known_broken:
            log_on = self._log_right + float(self._log_motion(here)[0])
            if walls is not None:
                least = 0.0 if knows_all else _KNOWN
                log_on += nats * max(float(wall_support(walls, returns, here)[0]), least)
        if walls is None or log_on > self._log_break + nats + math.log(len(returns) + 1.0):
            total = np.logaddexp(log_on, log_new)
            return StepOutcome(math.exp(log_on - total), self.standing)
        places, log_p = self._places(walls, returns, nats)
        on = math.exp(log_on - logsumexp([log_on, log_new, *log_p]))
        others = [log_on, self._log_break + _ALIKE * nats]
        if not len(places) or log_p[0] < max(others):
            return StepOutcome(on, None)
        x, y = places.translation[0].tolist()
        T_old_new = SE2.from_xy_yaw(x, y, float(places.heading[0]))
        return StepOutcome(on, T_old_new, math.exp(log_p[0] - logsumexp([*others, *log_p])))

    def _places(self, walls: MapEvidence, returns: Array, nats: float) -> tuple[Placements, Array]:
        """Return likely frames of a broken odometry, ``T_old_new``, best first, with log odds."""
        tried = self._grid()
        log_motion = self._log_motion(tried)
        all_of_them = float(logsumexp(log_motion))
        few = evenly_drawn(returns, _FEW)
        at_first = log_motion + nats * wall_support(walls, few, tried, COARSE_SIGMA_M)
        best = np.argsort(-at_first, kind='stable')[:_TRIED]
        alignment_prior = AlignmentPrior(RIGID_STRAIN, np.eye(2))
        found = refine(walls, returns, tried.take(best), alignment_prior, AGAIN)
        log_p = self._log_motion(found) - all_of_them
        log_p = self._log_break + log_p + nats * wall_support(walls, returns, found)
        order = np.argsort(-log_p, kind='stable')
        found, log_p = found.take(order), log_p[order]
        placed = np.concatenate([found.apply(few), few[None]])

        def is_same(one: int, others: NDArray[np.int64]) -> NDArray[np.bool_]:
            apart = np.linalg.norm(placed[others] - placed[one], axis=-1)
            return np.asarray(apart.mean(axis=-1) < _NEAR_M)

        other = ~is_same(len(found), np.arange(len(found)))  # than where the odometry says
        kept = first_distinct(len(found), is_same)
        kept = kept[other[kept]]
        return found.take(kept), log_p[kept]

    def _grid(self) -> Placements:
        """Return frames in which the robot has moved as far as it may have, ``T_old_new``."""
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
        """Return how likely a robot moves as in each frame, against standing still, in logs."""
        moved = np.linalg.norm(
            frames.linear @ self._xy + frames.translation - self._last_xy, axis=1
        )
        turned = wrap_to_pi(frames.heading - self.standing.yaw)
        squares = (moved / self._sigma_m) ** 2 + (turned / self._sigma_rad) ** 2
        return np.asarray(-0.5 * squares)
