# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Global Monte Carlo localization on the plan, as in AMCL's global localization.

Particles drawn uniformly over the plan's free space move with the odometry and are weighted by
a planar slice of each scan on the plan's likelihood field (Thrun, Burgard, Fox: Probabilistic
Robotics, sections 6.4 and 8.3). KLD sampling (Fox 2003) adapts their number. The plan is assumed
to be metric: the state has no scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2, angle_between, wrap_to_pi
from fpnet_core.pose import MapEvidence
from fpnet_core.raster.rays import nearest_cell

Array = NDArray[np.float64]

SLICE_HALF_M = 0.25
"""Half height of the slice at sensor height that emulates a planar scanner. Chosen."""

_SECTORS, _SECTORS_PER_BEAM = 360, 6  # numerical
_RANGE_M = 15.0  # chosen


@dataclass(frozen=True)
class MonteCarloSettings:
    """Numbers of particles, model parameters, and the particle share required to accept."""

    max_particles: int = 20_000
    min_particles: int = 500
    update_m: float = 0.25
    update_rad: float = 0.2
    sigma_hit_m: float = 0.2
    share_hit: float = 0.95
    noise_per_m: float = 0.1
    noise_rad_per_m: float = 0.1
    noise_per_rad: float = 0.1
    bin_m: float = 0.5
    bin_rad: float = float(np.deg2rad(10.0))
    kld_error: float = 0.05
    kld_z: float = 2.33
    cluster_m: float = 1.0
    cluster_rad: float = float(np.deg2rad(20.0))
    claim_share: float = 0.8


@dataclass(frozen=True, eq=False)
class CloudMean:
    """
    Mean pose of the densest cluster in ``plan``, its particle share, and acceptance.

    ``cov (3, 3)`` of x, y [m] and yaw [rad] is that of all particles about the mean.
    """

    T_plan_base: SE2
    share: float
    is_accepted: bool
    cov: Array


def planar_slice(points: NDArray[np.float32], T_odom_sensor: Array) -> NDArray[np.float32]:
    """
    Return the scan of a planar scanner at the sensor's pose.

    Parameters
    ----------
    points : (P, 3) sensor frame, metres
    T_odom_sensor : (4, 4) sensor pose in a gravity-aligned frame

    Returns
    -------
    (B, 2) float32, B <= 60: nearest return at sensor height in every sixth one-degree sector, in
    the levelled sensor frame; sectors without returns at that height are left out.
    """
    yaw = np.arctan2(T_odom_sensor[1, 0], T_odom_sensor[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    level = points @ (np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ T_odom_sensor[:3, :3]).T
    reach = np.hypot(level[:, 0], level[:, 1])
    share = np.arctan2(level[:, 1], level[:, 0]) / (2.0 * np.pi)
    sector = np.floor(share * _SECTORS).astype(np.int64)
    kept = (np.abs(level[:, 2]) < SLICE_HALF_M) & (reach < _RANGE_M)
    kept &= sector % _SECTORS_PER_BEAM == 0
    xy, reach, sector = level[kept, :2], reach[kept], sector[kept]
    order = np.lexsort((reach, sector))
    _, first = np.unique(sector[order], return_index=True)
    return np.asarray(xy[order[first]], dtype=np.float32)


class MonteCarlo:
    """
    Monte Carlo localizer of one recording on one plan.

    Parameters
    ----------
    plan : evidence of the plan
    rng : numpy.random.Generator
            Draws the particles and their motion.
    settings : MonteCarloSettings
    """

    def __init__(
        self, plan: MapEvidence, rng: np.random.Generator, settings: MonteCarloSettings
    ) -> None:
        self._plan, self._rng, self._settings = plan, rng, settings
        self._last: SE2 | None = None
        self._is_forced = False
        count = settings.max_particles
        spots = plan.free[rng.integers(len(plan.free), size=count)]
        self._xy = spots + rng.uniform(-0.2, 0.2, size=(count, 2))
        self._yaw = rng.uniform(-np.pi, np.pi, size=count)

    def start_at(self, T_plan_base: SE2, cov: Array) -> None:
        """
        Draw all particles from a Gaussian; the next scan weights them without motion.

        Like AMCL, ignore the terms of ``cov (3, 3)`` between position and heading.
        """
        count = self._settings.max_particles
        self._xy = self._rng.multivariate_normal(T_plan_base.translation, cov[:2, :2], count)
        self._yaw = T_plan_base.yaw + self._rng.normal(0.0, np.sqrt(cov[2, 2]), count)
        self._last, self._is_forced = None, True

    def add_scan(self, beams: NDArray[np.float32], T_odom_base: SE2) -> bool:
        """Move, weight and resample if the robot moved enough; return whether it did."""
        if self._last is None:
            self._last = T_odom_base
        step = self._last.inv() @ T_odom_base
        far = np.hypot(step.x, step.y) >= self._settings.update_m
        if not (self._is_forced or far or abs(step.yaw) >= self._settings.update_rad):
            return False
        self._is_forced = False
        self._last = T_odom_base
        self._move(step)
        weights = self._weights(beams)
        self._resample(weights)
        return True

    def estimate(self) -> CloudMean:
        """Return the mean of the densest cluster; accepted if it holds enough of the particles."""
        settings = self._settings
        _, bin_of, counts = np.unique(
            self._bins(), axis=0, return_inverse=True, return_counts=True
        )
        xy, yaw = self._mean(bin_of.ravel() == counts.argmax())
        gaps = np.linalg.norm(self._xy - xy, axis=1)
        turns = angle_between(self._yaw, yaw)
        is_near = (gaps < settings.cluster_m) & (turns < settings.cluster_rad)
        share = float(is_near.mean())
        xy, yaw = self._mean(is_near)
        T_plan_base = SE2.from_xy_yaw(xy[0], xy[1], yaw)
        off = np.column_stack([self._xy - xy, wrap_to_pi(self._yaw - yaw)])
        cov = off.T @ off / len(off)
        return CloudMean(T_plan_base, share, share >= settings.claim_share, cov)

    def _mean(self, chosen: NDArray[np.bool_]) -> tuple[Array, float]:
        """Return the mean position (2,) and heading of the chosen particles."""
        direction = np.exp(1j * self._yaw[chosen]).mean()
        return np.asarray(self._xy[chosen].mean(axis=0)), float(np.angle(direction))

    def _bins(self) -> NDArray[np.int64]:
        """Return the cells (N, 3) of the particles in a coarse grid over position and heading."""
        settings = self._settings
        cells = np.column_stack(
            [self._xy / settings.bin_m, wrap_to_pi(self._yaw) / settings.bin_rad]
        )
        return np.floor(cells).astype(np.int64)

    def _move(self, step: SE2) -> None:
        """Apply an odometry step to every particle, with noise proportional to the step."""
        settings, count = self._settings, len(self._xy)
        length = float(np.hypot(step.x, step.y))
        moved = step.translation + self._rng.normal(
            0.0, settings.noise_per_m * length, size=(count, 2)
        )
        c, s = np.cos(self._yaw), np.sin(self._yaw)
        self._xy[:, 0] += c * moved[:, 0] - s * moved[:, 1]
        self._xy[:, 1] += s * moved[:, 0] + c * moved[:, 1]
        sigma = settings.noise_per_rad * abs(step.yaw) + settings.noise_rad_per_m * length
        self._yaw += step.yaw + self._rng.normal(0.0, sigma, size=count)

    def _weights(self, beams: NDArray[np.float32]) -> Array:
        settings = self._settings
        weights = _likelihoods(
            self._xy, self._yaw, beams.astype(np.float64), self._plan.wall_distance,
            self._plan.outside_depth, self._plan.A_rc_xy, settings.sigma_hit_m,
            settings.share_hit,
        )  # fmt: skip
        return np.asarray(weights / weights.sum())

    def _resample(self, weights: Array) -> None:
        """Draw a new set of particles; the spread over bins determines its size."""
        count = self._needed(weights)
        places = (np.arange(count) + self._rng.random()) / count
        chosen = np.minimum(np.searchsorted(np.cumsum(weights), places), len(weights) - 1)
        self._xy, self._yaw = self._xy[chosen].copy(), self._yaw[chosen].copy()

    def _needed(self, weights: Array) -> int:
        """Return the number of particles for the KLD error with probability 0.99 (Fox 2003)."""
        settings = self._settings
        drawn = self._rng.choice(len(weights), size=len(weights), p=weights)
        k = len(np.unique(self._bins()[drawn], axis=0))
        if k < 2:
            return settings.min_particles
        a = 2.0 / (9.0 * (k - 1))
        needed = (
            (k - 1) / (2.0 * settings.kld_error) * (1.0 - a + np.sqrt(a) * settings.kld_z) ** 3
        )
        return int(np.clip(needed, settings.min_particles, settings.max_particles))


@numba.njit(cache=True, nogil=True)
def _likelihoods(
    xy: Array,
    yaw: Array,
    beams: Array,
    wall_distance: NDArray[np.float32],
    outside_depth: NDArray[np.float32],
    A_rc_xy: Array,
    sigma: float,
    share_hit: float,
) -> Array:
    """
    Return the weight of each particle, ``(N,)``: one plus the sum of cubed beam likelihoods.

    Cubes instead of a product keep one pose from dominating while most beams hit furniture. A
    particle inside a wall or off the plan has almost no weight.
    """
    weights = np.empty(len(xy))
    inv2 = -0.5 / (sigma * sigma)
    rows, cols = wall_distance.shape
    for n in range(len(xy)):
        c, s = np.cos(yaw[n]), np.sin(yaw[n])
        total = 1e-6
        row, col = nearest_cell(A_rc_xy, xy[n, 0], xy[n, 1])
        if 0 <= row < rows and 0 <= col < cols and outside_depth[row, col] <= sigma:
            total = 1.0
            for b in range(len(beams)):
                x = xy[n, 0] + c * beams[b, 0] - s * beams[b, 1]
                y = xy[n, 1] + s * beams[b, 0] + c * beams[b, 1]
                row, col = nearest_cell(A_rc_xy, x, y)
                p = (1.0 - share_hit) / _RANGE_M
                if 0 <= row < rows and 0 <= col < cols:
                    d = wall_distance[row, col]
                    p += share_hit * np.exp(inv2 * d * d)
                total += p * p * p
        weights[n] = total
    return weights
