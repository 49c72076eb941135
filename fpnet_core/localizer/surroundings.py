# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What the walls around the robot say of a claim that rests on the whole submap.

They correct where it puts the robot, and they contradict it when the robot is elsewhere: lifted
and carried off, or lost by its odometry. The submap goes on agreeing with the plan for minutes.
"""

from __future__ import annotations

from dataclasses import dataclass

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.judging.reasons import CONTRADICTED
from fpnet_core.localizer.anchor import FEWEST_POINTS, Anchor, Fix
from fpnet_core.localizer.belief import Belief
from fpnet_core.localizer.sides import RobotXY
from fpnet_core.pose import MapEvidence, wall_support
from fpnet_core.pose.verify import WALL_SIGMA_M
from fpnet_core.types import Status, Submap


@dataclass(frozen=True, eq=False)
class Vicinity:
    """What ticks go on from: the claim's last ``fix``, and ``doubts`` in a row about it."""

    fix: Fix | None = None
    doubts: int = 0


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Judges one claim after another by what was seen last."""

    config: LocalizerConfig

    def is_elsewhere(self, vicinity: Vicinity) -> bool:
        """Tell whether the robot is surely not where the submap goes on."""
        return vicinity.doubts >= self.config.doubt_ticks

    def judge(
        self,
        vicinity: Vicinity,
        plan: MapEvidence,
        submap: Submap,
        belief: Belief,
        robot_xy: RobotXY,
    ) -> tuple[Vicinity, Belief, Affine2D | None]:
        """
        Return the belief, and ``A_plan_odom`` around the robot where something is claimed.

        A claim is withheld as LOST while the newest scans contradict it; one that falls meanwhile
        was wrong. ``robot_xy (2,)`` is in the submap; all is in the plan's working metres.
        """
        if belief.status is not Status.LOCALIZED or belief.best is None:
            doubts = self.config.doubt_ticks if vicinity.doubts else 0
            return Vicinity(None, doubts), belief, None
        assert robot_xy is not None  # a submap comes from scans, and they have poses
        T = submap.T_odom_submap
        fix, A_plan_odom = Anchor(self.config).follow(
            vicinity.fix,
            plan,
            T.apply(submap.recent_xy),
            belief.best.A_plan_submap @ T.inv(),
            T.apply(robot_xy),
        )
        if self._fits(plan, submap, A_plan_odom @ T, belief.best.score):
            return Vicinity(fix), belief, A_plan_odom
        lost = Belief(Status.LOST, None, 0.0, CONTRADICTED)
        return Vicinity(fix, vicinity.doubts + 1), lost, None

    def _fits(
        self, plan: MapEvidence, submap: Submap, A_plan_submap: Affine2D, score: float
    ) -> bool:
        """Tell whether the newest scans' walls lie on drawn ones, nearly as all others do."""
        seen = submap.newest_xy
        if len(seen) < FEWEST_POINTS:
            return True
        support = wall_support(plan, seen, Placements.of([A_plan_submap]), WALL_SIGMA_M)
        return float(support[0]) >= self.config.doubt_share * score
