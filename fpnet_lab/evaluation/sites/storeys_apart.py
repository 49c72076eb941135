# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Path after which storeys become distinguishable: once the submap shows walls they do not share.

Until then similar storeys explain all observations as well as the true one, so that no method
without prior knowledge can decide between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.differences.finding import APART_M
from fpnet_core.geometry import SE2
from fpnet_core.localizer import ReplayResult
from fpnet_core.pose import MapEvidence, map_evidence
from fpnet_core.scoring.competing import NOISE_M
from fpnet_core.scoring.kernels import look_up
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.sim.drawn.distort import DrawnPlan
from fpnet_lab.sim.drawn.storeys import DrawnStorey, Likeness

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Parting:
    """
    Walls that distinguish two drawings of one building, as samples in its frame [m].

    ``own (P, 2)`` are walls of the true storey that the other lacks, ``other (Q, 2)`` walls of the
    other that the true one lacks; each sample represents ``metres`` of wall.
    """

    own: Array
    other: Array
    metres: float

    @classmethod
    def of(cls, true: DrawnPlan, other: DrawnPlan) -> Parting:
        """Return the walls in which two drawings differ."""
        sides = map_evidence(true.grid), map_evidence(other.grid)
        placed = true.A_plan_building, other.A_plan_building
        own, others = (A.inv().apply(side.walls) for A, side in zip(placed, sides, strict=True))
        return cls(
            own[_wall_distance(sides[1], placed[1].apply(own)) > APART_M],
            others[_wall_distance(sides[0], placed[0].apply(others)) > APART_M],
            sides[0].wall_length_m / max(len(own), 1),
        )

    def seen_m(self, sub: MapEvidence, T_submap_building: SE2) -> float:
        """Return the observed length: own walls present, other's walls seen to be absent [m]."""
        own, other = (T_submap_building.apply(each) for each in (self.own, self.other))
        is_gone = _wall_distance(sub, other) > APART_M
        is_gone &= look_up(sub.A_rc_xy[None], other, sub.observed, np.False_)[0]
        is_there = _wall_distance(sub, own) <= APART_M
        return float(is_there.sum() + is_gone.sum()) * self.metres


def parted_at_m(
    storeys: Sequence[DrawnStorey], run: ReplayResult, truth: PlanarTrajectory
) -> float | None:
    """
    Return the path length at the first update whose submap excludes all similar storeys, or None.

    It must observe a metre of differing walls for each similar storey: less is within the noise.
    """
    (true,) = (each for each in storeys if each.likeness is Likeness.TRUE)
    alike = [each for each in storeys if each.likeness in (Likeness.ALIKE, Likeness.EQUAL)]
    partings = [Parting.of(true.drawn, each.drawn) for each in alike]
    for output in run.outputs:
        if (submap := output.submap) is None:
            continue
        T_odom_building = (
            _pose(run.odometry, output.stamp_ns) @ _pose(truth, output.stamp_ns).inv()
        )
        T_submap_building = submap.T_odom_submap.inv() @ T_odom_building
        sub = map_evidence(submap.grid)
        if all(each.seen_m(sub, T_submap_building) >= NOISE_M for each in partings):
            return run.odometry.path_length_m(output.stamp_ns)
    return None


def _pose(path: PlanarTrajectory, stamp_ns: int) -> SE2:
    at, _ = path.at(np.array([stamp_ns]))
    x, y = at.xy[0]
    return SE2.from_xy_yaw(float(x), float(y), float(at.yaw[0]))


def _wall_distance(side: MapEvidence, xy: Array) -> NDArray[Any]:
    """Return the distances ``(P,)`` from points ``(P, 2)`` to the nearest wall [m]."""
    return np.asarray(look_up(side.A_rc_xy[None], xy, side.wall_distance, np.float32(np.inf))[0])
