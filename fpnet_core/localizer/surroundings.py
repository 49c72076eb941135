# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What the walls around the robot say of a claim that rests on the whole submap.

They correct where it puts the robot, and they contradict it when the robot is elsewhere: lifted
and carried off, or lost by its odometry. The submap goes on agreeing with the plan for minutes.
"""

from __future__ import annotations

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.judging.reasons import CONTRADICTED
from fpnet_core.localizer.anchor import FEWEST_POINTS, Anchor
from fpnet_core.localizer.belief import Belief
from fpnet_core.localizer.sides import RobotXY
from fpnet_core.pose import MapEvidence, wall_support
from fpnet_core.pose.verify import WALL_SIGMA_M
from fpnet_core.types import Status, Submap


class Surroundings:
    """Judges one claim after another by what was seen last."""

    def __init__(self, config: FpnetConfig) -> None:
        self._config = config.localizer
        self._sigma_m = WALL_SIGMA_M
        self._anchor = Anchor(config)
        self.reset()

    def reset(self) -> None:
        """Forget the claim."""
        self._anchor.reset()
        self._doubts = 0

    @property
    def is_elsewhere(self) -> bool:
        """Tell whether the robot is surely not where the submap goes on."""
        return self._doubts >= self._config.doubt_ticks

    def judge(
        self, plan: MapEvidence, submap: Submap, belief: Belief, robot_xy: RobotXY
    ) -> tuple[Belief, Affine2D | None]:
        """
        Return the belief, and ``A_plan_odom`` around the robot where something is claimed.

        A claim is withheld as LOST while the newest scans contradict it; one that falls meanwhile
        was wrong. ``robot_xy (2,)`` is in the submap; all is in the plan's working metres.
        """
        if belief.status is not Status.LOCALIZED or belief.best is None:
            self._anchor.reset()
            self._doubts = self._config.doubt_ticks if self._doubts else 0
            return belief, None
        assert robot_xy is not None  # a submap comes from scans, and they have poses
        T = submap.T_odom_submap
        A_plan_odom = self._anchor.follow(
            plan, T.apply(submap.recent_xy), belief.best.A_plan_submap @ T.inv(), T.apply(robot_xy)
        )
        if self._fits(plan, submap, A_plan_odom @ T, belief.best.score):
            self._doubts = 0
            return belief, A_plan_odom
        self._doubts += 1
        return Belief(Status.LOST, None, 0.0, CONTRADICTED), None

    def _fits(
        self, plan: MapEvidence, submap: Submap, A_plan_submap: Affine2D, score: float
    ) -> bool:
        """Tell whether the newest scans' walls lie on drawn ones, nearly as all others do."""
        seen = submap.newest_xy
        if len(seen) < FEWEST_POINTS:
            return True
        support = wall_support(plan, seen, Placements.of([A_plan_submap]), self._sigma_m)
        return float(support[0]) >= self._config.doubt_share * score
