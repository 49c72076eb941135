# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated robot explores until it is localized: by guidance, or by baseline strategies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2
from fpnet_core.localizer import Localizer
from fpnet_core.localizer.guidance import next_look
from fpnet_core.localizer.ways import WayGrid, Ways, way_grid_around
from fpnet_core.raster.morphology import grown
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import LocalizerOutput, Status
from fpnet_lab.sim.drives.recording import Recording

Array = NDArray[np.float64]

# Chosen, not measured:
_STEP_M = 0.3  # length of a step, with a scan before and after it
_TICK_M = 1.5  # between updates
_CLEAR_M = 0.2  # clearance of the robot to obstacles beside and ahead of it
_STANDING_M = 0.15  # above the floor; lower points are floor
_LEAST_WAY_M = 1.0  # nearer goals are not chosen: the robot has observed from there
_PERIOD_NS = NS_PER_S // 10


@dataclass(frozen=True)
class Exploration:
    """
    Result of an exploration: path until localized, None without, and the error, both in metres.

    ``advised`` is the share of decisions that followed the guidance.
    """

    found_after_m: float | None
    off_m: float
    advised: float


Policy = Callable[[Localizer, Array, np.random.Generator], Array | None]
"""Returns the path to follow, (P, 2) in odom, for a robot at ``T_odom_base (4, 4)``."""


def by_advice(localizer: Localizer, T_odom_base: Array, _: np.random.Generator) -> Array | None:
    """Follow the localizer's guidance; None if there is none."""
    snapshot = localizer.snapshot
    if snapshot.plan is None:
        return None
    look = next_look(snapshot.plan.nominal.evidence, snapshot.output, T_odom_base)
    return None if look is None else look.way_odom


def at_random(localizer: Localizer, T_odom_base: Array, rng: np.random.Generator) -> Array | None:
    """Go to a random frontier cell."""
    return _to_frontier(localizer.output, T_odom_base, lambda lengths: rng.integers(len(lengths)))


def to_nearest(localizer: Localizer, T_odom_base: Array, _: np.random.Generator) -> Array | None:
    """Go to the nearest frontier cell (Yamauchi, 1997)."""
    return _to_frontier(localizer.output, T_odom_base, np.argmin)


POLICIES: dict[str, Policy] = {'advice': by_advice, 'nearest': to_nearest, 'random': at_random}


def explore(
    recording: Recording, localizer: Localizer, policy: Policy, most_m: float, seed: int
) -> Exploration:
    """
    Let a robot with true odometry choose its path, up to a length of ``most_m``.

    It starts at the recording's start; ``localizer`` has the floorplan. If a policy returns no
    path, the robot goes to the nearest frontier.
    """
    rng = np.random.default_rng((recording.seed, seed))
    robot = _Robot(recording, localizer, rng)
    driven_m, choices, advised = 0.0, 0, 0
    while driven_m < most_m:
        if robot.update().status is Status.LOCALIZED:
            return Exploration(driven_m, robot.off_m(), advised / max(choices, 1))
        way = policy(localizer, robot.T_odom_base, rng)
        choices, advised = choices + 1, advised + (way is not None)
        if way is None:
            way = to_nearest(localizer, robot.T_odom_base, rng)
        driven_m += max(_STEP_M, robot.follow(way))
    return Exploration(None, math.nan, advised / max(choices, 1))


class _Robot:
    """Robot in a recording's building; its start is the origin of odom."""

    def __init__(
        self, recording: Recording, localizer: Localizer, rng: np.random.Generator
    ) -> None:
        self._recording, self._localizer, self._rng = recording, localizer, rng
        self._T_building_odom = recording.truth()[0]
        self._pose = SE2.identity()
        self._stamp_ns = int(recording.stamps_ns[0])
        self._way: Array | None = None
        self._scan()

    @property
    def T_odom_base(self) -> Array:
        """Pose of the robot, (4, 4)."""
        return self._pose.as_matrix4()

    def update(self) -> LocalizerOutput:
        """Run an update of the localizer."""
        return self._localizer.update(self._stamp_ns)

    def off_m(self) -> float:
        """Return the error of the published position in floorplan metres."""
        claimed = self._localizer.output.pose(self.T_odom_base)
        assert claimed is not None, 'the status is localized'
        true = (self._T_building_odom @ self.T_odom_base)[:2, 3]
        on_plan = self._recording.A_plan_building.apply(true)
        return float(np.linalg.norm(claimed.translation - on_plan))

    def follow(self, way: Array | None) -> float:
        """Follow a path until the next update or an obstacle; return the driven metres."""
        driven_m = 0.0
        for goal in [] if way is None else way[1:]:
            while (left := float(np.linalg.norm(goal - self._pose.translation))) > 0.5 * _STEP_M:
                if driven_m >= _TICK_M:
                    return driven_m
                x, y = goal - self._pose.translation
                step = min(_STEP_M, left)
                if not self._go(math.atan2(y, x), step):
                    return driven_m
                driven_m += step
        return driven_m

    def _go(self, yaw: float, step_m: float) -> bool:
        """Turn, move ahead and scan; return False if an obstacle blocks the way."""
        x, y = self._pose.translation
        self._pose = SE2.from_xy_yaw(float(x), float(y), yaw)
        points = self._scan()
        x, y, z = points.T
        stands = (z > _STANDING_M - self._T_building_odom[2, 3]) & (x > 0.0)
        if (stands & (x < step_m + _CLEAR_M) & (np.abs(y) < _CLEAR_M)).any():
            return False
        ahead = self._pose.apply(np.array([step_m, 0.0]))
        self._pose = SE2.from_xy_yaw(float(ahead[0]), float(ahead[1]), yaw)
        self._scan()
        return True

    def _scan(self) -> NDArray[np.float32]:
        """Cast a scan at the robot's pose, add it to the localizer, and return its points."""
        lidar = self._recording.lidar
        T = self._T_building_odom @ self.T_odom_base
        columns = len(lidar.model.column_times_s)
        R, origin = np.tile(T[:3, :3], (columns, 1, 1)), np.tile(T[:3, 3], (columns, 1))
        points = lidar.sweep(R, origin, 0.0, self._rng).points
        self._stamp_ns += _PERIOD_NS
        self._localizer.add_scan(points, self.T_odom_base, self._stamp_ns)
        return points


def _to_frontier(
    output: LocalizerOutput, T_odom_base: Array, choose: Callable[[Array], np.integer | int]
) -> Array | None:
    """Return the path to a frontier cell, chosen by path length."""
    submap = output.submap
    if submap is None:
        return None
    base = submap.T_odom_submap.inv() @ SE2.from_matrix4(T_odom_base)
    ground = way_grid_around(submap, base.translation)
    ways = ground.ways(base.translation)
    edge = _edge(ground, ways)
    if not len(edge):
        return None
    cell = int(edge[int(choose(ways.length_m[edge]))])
    return submap.T_odom_submap.apply(ground.xy(ways.to(cell)))


def _edge(ground: WayGrid, ways: Ways) -> NDArray[np.int64]:
    """Return reachable cells next to unobserved ones; without any, all reachable cells."""
    is_far = np.isfinite(ways.length_m) & (ways.length_m > _LEAST_WAY_M)
    at_edge = grown(~ground.is_seen, 1).ravel() & is_far
    return np.flatnonzero(at_edge if at_edge.any() else is_far)
