# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulation of the submap that a robot builds on a walk through a world raster."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SubmapConfig
from fpnet_core.geometry import SE2
from fpnet_core.submaps.heights import HeightBands
from fpnet_core.submaps.raster import CountRaster
from fpnet_core.types import GridMap, Submap
from fpnet_lab.sim.config import ScanConfig
from fpnet_lab.sim.drives.drift import estimate_walk
from fpnet_lab.sim.pairs.perturb import WORLD_CELL_M, World
from fpnet_lab.sim.pairs.scan2d import EMPTY, cast_rays, clear_cells

GLASS_PASS = 0.85
"""Probability that a ray passes glass. Chosen."""

LINTEL_STANDOFF_M = 1.5
"""At shorter distances, lintels are above the scanner's field of view. Chosen."""

NARROW_FOV_RAD = (np.pi, 1.5 * np.pi)
"""Field of view of forward-looking scanners. Chosen."""

BEYOND_RANGE = 2.0
"""Returns up to this factor of the maximum range still clear space up to it. Chosen."""

_INTO_CELL = 0.25  # numerical: depth of a return inside the cell that a ray enters [cells]


@dataclass(frozen=True)
class Scanner:
    """
    A scanner; if ``is_planar``, it measures at one height only, otherwise lintels as well.

    ``rays`` are evenly spaced over ``fov_rad``, centred on the robot's heading.
    """

    is_planar: bool
    height_m: float
    max_range_m: float
    noise_m: float
    rays: int
    fov_rad: float = 2.0 * np.pi


def draw_scanner(rng: np.random.Generator, config: ScanConfig) -> Scanner:
    """Sample a scanner; planar ones are mounted lower, at the height of furniture legs."""
    is_planar = bool(rng.random() < config.planar)
    fov_rad = 2.0 * np.pi
    if is_planar and rng.random() < config.narrow:
        fov_rad = float(rng.uniform(*NARROW_FOV_RAD))
    return Scanner(
        is_planar=is_planar,
        height_m=float(rng.uniform(0.15, 0.7) if is_planar else rng.uniform(0.7, 1.4)),
        max_range_m=float(rng.uniform(*config.max_range_m)),
        noise_m=float(rng.uniform(*config.noise_m)),
        rays=round(config.rays * fov_rad / (2.0 * np.pi)),
        fov_rad=fov_rad,
    )


def scan_walk(
    world: World,
    xy: NDArray[np.float64],
    scanner: Scanner,
    rng: np.random.Generator,
    config: ScanConfig,
) -> tuple[Submap, SE2] | None:
    """
    Scan at every position (S, 2) of a walk and accumulate a submap with drifting odometry.

    The robot's counter traces the rays and classifies cells as free, wall or lintel.

    Returns
    -------
    The submap in a frame with random position and rotation, and ``T_submap_building``, the
    least-squares rigid transform from true to estimated positions. None if no ray returned.
    """
    estimated, yaw_error = estimate_walk(xy, rng, config)
    x, y = rng.uniform(-20.0, 20.0, 2)
    frame = SE2.from_xy_yaw(x, y, rng.uniform(-np.pi, np.pi))
    estimated, turn = frame.apply(estimated), yaw_error + frame.yaw
    cell_m = float(rng.choice(config.resolution_m))
    directions = _ray_directions(xy, scanner, rng)
    returns = _measure(world, xy, directions, scanner, rng)
    counted = _counted(estimated, _turned(directions, turn), returns, cell_m)
    if counted is None:
        return None
    return Submap(*counted, estimated), fit_rigid(xy, estimated, turn)


@dataclass(frozen=True, eq=False)
class _Returns:
    """
    Returns of the rays (S, A) at one height; ``seen`` is the length of proven free space [m].

    ``is_near`` marks returns within the maximum range; rays without a return have length 0.
    """

    seen: NDArray[np.float64]
    is_near: NDArray[np.bool_]


def _ray_directions(
    xy: NDArray[np.float64], scanner: Scanner, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return unit ray directions (S, A, 2), centred on the robot's heading along its walk."""
    ahead = np.gradient(xy, axis=0) if len(xy) > 1 else np.array([[1.0, 0.0]])
    heading = np.arctan2(ahead[:, 1], ahead[:, 0])
    place = np.arange(scanner.rays) + rng.random((len(xy), scanner.rays))
    angles = heading[:, None] + scanner.fov_rad * (place / scanner.rays - 0.5)
    return np.stack([np.cos(angles), np.sin(angles)], axis=2)


def _turned(directions: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the directions (S, A, 2), rotated per scan by ``turn (S,)`` [rad]."""
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    x, y = directions[..., 0], directions[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=2)


def _measure(
    world: World,
    xy: NDArray[np.float64],
    directions: NDArray[np.float64],
    scanner: Scanner,
    rng: np.random.Generator,
) -> list[_Returns]:
    """Cast all rays at body height and, unless the scanner is planar, at lintel height."""
    starts = world.to_cells(xy)
    reach = BEYOND_RANGE * scanner.max_range_m / WORLD_CELL_M
    passes = rng.random(directions.shape[:2], dtype=np.float32) < GLASS_PASS
    layers = [(world.body, 0.0), (world.high, LINTEL_STANDOFF_M)][: 1 if scanner.is_planar else 2]
    worlds = np.stack([raster for raster, _ in layers])
    clear = clear_cells((worlds == EMPTY).all(axis=0))
    found = cast_rays(worlds, clear, starts, directions, reach, passes)
    returns = []
    for ranges, codes, (_, standoff_m) in zip(*found, layers, strict=True):
        metres = (ranges + _INTO_CELL) * WORLD_CELL_M
        metres += scanner.noise_m * rng.standard_normal(metres.shape, dtype=np.float32)
        is_return = (codes != EMPTY) & (metres >= standoff_m)
        seen = np.where(is_return, np.clip(metres, 0.0, scanner.max_range_m), 0.0)
        returns.append(_Returns(seen, is_return & (metres <= scanner.max_range_m)))
    return returns


def _counted(
    xy: NDArray[np.float64],
    directions: NDArray[np.float64],
    returns: Sequence[_Returns],
    cell_m: float,
) -> tuple[GridMap, NDArray[np.bool_]] | None:
    """
    Trace the rays from ``xy (S, 2)`` with the robot's counter and return its submap.

    Lintel rays rise by 1 m per metre here, so that they reach lintel height at the standoff
    distance.
    """
    bands = HeightBands(-np.inf, LINTEL_STANDOFF_M, LINTEL_STANDOFF_M, np.inf, np.inf)
    seen = np.concatenate([met.seen for met in returns], axis=1)
    is_near = np.concatenate([met.is_near for met in returns], axis=1)
    rise = np.repeat([0.0, 1.0][: len(returns)], directions.shape[1])
    ahead = np.concatenate([directions] * len(returns), axis=1)
    x, y = (xy[:, k, None] + seen * ahead[..., k] for k in (0, 1))
    ends = np.stack([x, y, rise * seen], axis=2)
    starts = np.column_stack([xy, np.zeros(len(xy))])
    raster = CountRaster(SubmapConfig(resolution_m=cell_m))
    raster.reserve(starts[0], np.array([[x.min(), y.min(), 0.0], [x.max(), y.max(), 0.0]]))
    for start, end, used, near in zip(starts, ends, seen > 0.0, is_near, strict=True):
        raster.carve(start, end[used], near[used], bands)
    return raster.read()


def fit_rigid(
    true_xy: NDArray[np.float64], estimated_xy: NDArray[np.float64], turn: NDArray[np.float64]
) -> SE2:
    """
    Return the least-squares rigid transform from true to estimated positions (S, 2).

    Each pose adds two points, 1 m ahead and 1 m to the left, rotated by ``turn (S,)`` [rad], so
    that a single pose also determines the rotation.
    """
    ahead = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    beside = np.stack([-np.sin(turn), np.cos(turn)], axis=1)
    x_axis, y_axis = np.eye(2)
    source = np.concatenate([true_xy, true_xy + x_axis, true_xy + y_axis])
    target = np.concatenate([estimated_xy, estimated_xy + ahead, estimated_xy + beside])
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    yaw = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    R = SE2.from_xy_yaw(0.0, 0.0, float(yaw))
    shift = target.mean(axis=0) - R.apply(source.mean(axis=0))
    return SE2.from_xy_yaw(float(shift[0]), float(shift[1]), float(yaw))
