# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What the walls around the robot say of a claim that rests on the whole submap.

They correct where it puts the robot, and they contradict it when the robot is elsewhere: lifted
and carried off, or lost by its odometry. The submap goes on agreeing with the plan for minutes.

Two signs speak of that. The newest returns lie on drawn walls less than those before them did,
where the drawing is the same; and they lie where the robot itself has seen free space, which no
fault of the drawing explains. Neither is enough: new rooms are drawn worse than others, and who
comes back with odometry that has drifted sees its own walls double.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.localizer.pose_filter import FEWEST_POINTS, LocalPoseFilter, PoseEstimate
from fpnet_core.localizer.prepared_maps import RobotXY
from fpnet_core.localizer.tracking import LocalizationState
from fpnet_core.pose import MapEvidence, wall_support
from fpnet_core.raster.morphology import grown
from fpnet_core.scoring.reasons import CONTRADICTED
from fpnet_core.types import FREE, OCCUPIED, Status, Submap

_WEIGHTS = (5.4, -9.6, 7.7)
"""
Log odds of being elsewhere: without signs, for the support beside its usual one, for the share of
returns in what was free. Fitted by ``python benchmarks/carried_evidence.py --drives 8`` to 28
generated drives, of whose looks 16 of 1,650 before and 44 of 45 after the lift are doubted; twelve
of the 16 are of two stretches of the long drives, on which odometry drifts.
"""

_FREE_OF_WALLS_M = 0.3  # physical: a wall seen again lies within this, by noise and some drift
_LEAST_USUAL = 0.05  # numerical: no division by nothing
_MEMORY = 0.8  # chosen: of what is usual, from tick to tick


@dataclass(frozen=True, eq=False)
class KidnapState:
    """
    What ticks go on from: the claim's last ``fix``, and ``doubts`` in a row about it.

    ``usual`` is the support that the newest returns have had; None before the first tick, for
    which the claim's score stands in. ``before`` is the last submap that nobody doubted.
    """

    fix: PoseEstimate | None = None
    doubts: int = 0
    usual: float | None = None
    before: Submap | None = None


@dataclass(frozen=True, eq=False)
class KidnapDetector:
    """Judges one claim after another by what was seen last."""

    config: LocalizerConfig

    def is_elsewhere(self, kidnap_state: KidnapState) -> bool:
        """Tell whether the robot is surely not where the submap goes on."""
        return kidnap_state.doubts >= self.config.doubt_updates

    def update(
        self,
        kidnap_state: KidnapState,
        plan: MapEvidence,
        submap: Submap,
        estimate: LocalizationState,
        robot_xy: RobotXY,
    ) -> tuple[KidnapState, LocalizationState, Affine2D | None]:
        """
        Return the belief, and ``A_plan_odom`` around the robot where something is claimed.

        A claim is withheld as LOST while the newest scans contradict it; one that falls meanwhile
        was wrong. ``robot_xy (2,)`` is in the submap; all is in the plan's working metres.
        """
        if estimate.status is not Status.LOCALIZED or estimate.best is None:
            doubts = self.config.doubt_updates if kidnap_state.doubts else 0
            return KidnapState(doubts=doubts), estimate, None
        assert robot_xy is not None  # a submap comes from scans, and they have poses
        T = submap.T_odom_submap
        anchor, robot_odom = LocalPoseFilter(self.config), T.apply(robot_xy)
        fix, A_plan_odom = anchor.follow(
            kidnap_state.fix,
            plan,
            T.apply(submap.recent_xy),
            estimate.best.A_plan_submap @ T.inv(),
            robot_odom,
        )
        support = self._support(plan, submap, A_plan_odom @ T)
        usual = estimate.best.score if kidnap_state.usual is None else kidnap_state.usual
        if self._is_doubtful(support, usual, kidnap_state, submap):
            lost = LocalizationState(Status.LOST, None, 0.0, CONTRADICTED)
            doubted = replace(kidnap_state, fix=fix, doubts=kidnap_state.doubts + 1)
            return doubted, lost, None
        if support is not None:
            usual = _MEMORY * usual + (1.0 - _MEMORY) * support
        if fix is not None:
            A_plan_odom = anchor.at_last(plan, T.apply(submap.newest_xy), A_plan_odom, robot_odom)
        return KidnapState(fix, 0, usual, submap), estimate, A_plan_odom

    def _support(self, plan: MapEvidence, submap: Submap, A_plan_submap: Affine2D) -> float | None:
        """Return how well the newest returns lie on drawn walls; None where they are too few."""
        if len(submap.newest_xy) < FEWEST_POINTS:
            return None
        at = Placements.of([A_plan_submap])
        return float(wall_support(plan, submap.newest_xy, at)[0])

    def _is_doubtful(
        self, support: float | None, usual: float, kidnap_state: KidnapState, submap: Submap
    ) -> bool:
        """
        Tell whether the newest returns say that the robot is elsewhere.

        Who has been carried off stays there: a doubt is given up only for as good a reason as
        it takes to have one.
        """
        if support is None:
            return False
        features = signs_of(support, usual, kidnap_state.before, submap)
        elsewhere = float(expit(np.dot(_WEIGHTS, (1.0, *features))))
        wanted = self.config.doubt_probability
        return elsewhere > (1.0 - wanted if kidnap_state.doubts else wanted)


def signs_of(
    support: float, usual: float, before: Submap | None, submap: Submap
) -> tuple[float, float]:
    """Return the support beside its usual one, and the share of returns in what was free."""
    in_free = 0.0 if before is None else share_in_free_space(before, submap)
    return support / max(usual, _LEAST_USUAL), in_free


def share_in_free_space(before: Submap, submap: Submap) -> float:
    """
    Return the share of the newest returns that lie where ``before`` has seen free space only.

    Both submaps go on in one frame, ``odom``; cells within 0.3 m of a wall do not count as free,
    nor does furniture, over which a submap is free, as nothing but walls.
    """
    grid = before.grid
    xy = (before.T_odom_submap.inv() @ submap.T_odom_submap).apply(submap.newest_walls_xy)
    rc = np.round(grid.xy_to_rc(xy)).astype(np.int64)
    inside = rc[((rc >= 0) & (rc < grid.shape)).all(axis=1)]
    if not len(inside):
        return 0.0
    reach = round(_FREE_OF_WALLS_M / grid.resolution)
    low = np.maximum(inside.min(axis=0) - reach, 0)
    window = tuple(map(slice, low, inside.max(axis=0) + reach + 1))
    cells = grid.cells[window]
    is_free = (cells == FREE) & ~grown(cells == OCCUPIED, reach)
    count = np.count_nonzero(is_free[tuple((inside - low).T)])
    return float(count) / len(submap.newest_xy)
