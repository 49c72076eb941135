# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A robot's own tracker that behaves as Nav2's AMCL does towards who initializes it.

It has no pose before the first initial pose. Each one replaces all particles by a Gaussian of its
covariance, carried on by odometry since its stamp. It publishes a pose at the next scan, then only
after 0.25 m or 0.2 rad of motion. It never searches the whole map again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2
from fpnet_core.geometry.pose_track import PoseTrack
from fpnet_core.pose import MapEvidence
from fpnet_lab.baselines.monte_carlo import (
    CloudMean,
    MonteCarlo,
    MonteCarloSettings,
    planar_slice,
)

Array = NDArray[np.float64]

PARTICLES = MonteCarloSettings(max_particles=2000, min_particles=500)
"""Given: AMCL's defaults."""


class Amcl:
    """
    Particle filter on a plan that starts at initial poses.

    Parameters
    ----------
    plan : evidence of the plan
    rng : numpy.random.Generator
            Draws the particles and their motion.
    """

    def __init__(self, plan: MapEvidence, rng: np.random.Generator) -> None:
        self._cloud = MonteCarlo(plan, rng, PARTICLES)
        self._odometry = PoseTrack()
        self._start: tuple[int, SE2, Array] | None = None  # not used yet
        self.starts = 0
        """Number of initial poses taken."""

    def take_initial_pose(self, T_plan_base: SE2, cov: Array, stamp_ns: int) -> None:
        """Start from a pose at a stamp with ``cov (3, 3)`` of x, y [m] and yaw [rad]."""
        self._start = stamp_ns, T_plan_base, cov

    def add_scan(
        self, points: NDArray[np.float32], T_odom_base: Array, stamp_ns: int
    ) -> CloudMean | None:
        """
        Return the pose to publish, None if there is none.

        ``points (P, 3)`` are in the base frame [m], ``T_odom_base (4, 4)`` is the odometry.
        """
        self._odometry.add(stamp_ns, T_odom_base)
        T_odom_now = SE2.from_matrix4(T_odom_base)
        if self._start is not None:
            then_ns, T_plan_then, cov = self._start
            T_odom_then = self._odometry.at(then_ns)
            if T_odom_then is not None:
                moved = SE2.from_matrix4(T_odom_then).inv() @ T_odom_now
                self._cloud.start_at(T_plan_then @ moved, cov)
                self._start, self.starts = None, self.starts + 1
        if not self.starts or not self._cloud.add_scan(
            planar_slice(points, T_odom_base), T_odom_now
        ):
            return None
        return self._cloud.estimate()
