# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Check of an accepted placement against the walls near the robot.

These walls correct the pose within the submap's placement. They contradict it if the robot is
elsewhere, kidnapped or lost by its odometry, while the submap still agrees with the plan for
minutes.

Two features detect this: the newest returns fit the plan worse than earlier ones on the same plan,
and they lie in observed free space, which no error of the plan explains. Neither is sufficient
alone: some rooms are drawn worse than others, and drift displaces the walls of a revisited place.
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
Log odds of being elsewhere: bias, weight of the support relative to its usual value, weight of the
share of returns in free space. Fitted by ``python benchmarks/carried_evidence.py --drives 8`` to
28 generated recordings: 16 of 1,650 updates before and 44 of 45 after the lift are doubted; twelve
of the 16 are on two stretches of the long recordings, on which odometry drifts.
"""

_FREE_OF_WALLS_M = 0.3  # physical: a revisited wall lies within this, given noise and drift
_LEAST_USUAL = 0.05  # numerical: avoids a division by zero
_MEMORY = 0.8  # chosen: weight of the past in the usual support, per update


@dataclass(frozen=True, eq=False)
class KidnapState:
    """
    State between updates: the last pose ``fix``, and consecutive ``doubts`` about the pose.

    ``usual`` is the average support of the newest returns; None before the first update,
    which uses the placement's score. ``before`` is the last submap without a doubt.
    """

    fix: PoseEstimate | None = None
    doubts: int = 0
    usual: float | None = None
    before: Submap | None = None


@dataclass(frozen=True, eq=False)
class KidnapDetector:
    """Checks accepted placements against the newest scans."""

    config: LocalizerConfig

    def is_elsewhere(self, kidnap_state: KidnapState) -> bool:
        """Return whether the robot has left the place where the submap continues."""
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
        Return the state, and ``A_plan_odom`` near the robot while localized.

        The pose is withheld as LOST while the newest scans contradict it; a placement released
        meanwhile was wrong. ``robot_xy (2,)`` is in the submap; units: the plan's working metres.
        """
        if estimate.status is not Status.LOCALIZED or estimate.best is None:
            doubts = self.config.doubt_updates if kidnap_state.doubts else 0
            return KidnapState(doubts=doubts), estimate, None
        assert robot_xy is not None  # a submap comes from scans, and they have poses
        T = submap.T_odom_submap
        local_filter, robot_odom = LocalPoseFilter(self.config), T.apply(robot_xy)
        fix, A_plan_odom = local_filter.follow(
            kidnap_state.fix,
            plan,
            T.apply(submap.recent_xy),
            estimate.best.A_plan_submap @ T.inv(),
            robot_odom,
        )
        support = self._support(plan, submap, A_plan_odom @ T)
        usual = estimate.best.score if kidnap_state.usual is None else kidnap_state.usual
        if self._is_doubtful(support, usual, kidnap_state, submap):
            lost = LocalizationState(Status.LOST, None, 0.0, CONTRADICTED, scored=estimate.scored)
            doubted = replace(kidnap_state, fix=fix, doubts=kidnap_state.doubts + 1)
            return doubted, lost, None
        if support is not None:
            usual = _MEMORY * usual + (1.0 - _MEMORY) * support
        if fix is not None:
            A_plan_odom = local_filter.at_last(
                plan, T.apply(submap.newest_xy), A_plan_odom, robot_odom
            )
        return KidnapState(fix, 0, usual, submap), estimate, A_plan_odom

    def _support(self, plan: MapEvidence, submap: Submap, A_plan_submap: Affine2D) -> float | None:
        """Return how well the newest returns fit the plan's walls; None if there are too few."""
        if len(submap.newest_xy) < FEWEST_POINTS:
            return None
        at = Placements.of([A_plan_submap])
        return float(wall_support(plan, submap.newest_xy, at)[0])

    def _is_doubtful(
        self, support: float | None, usual: float, kidnap_state: KidnapState, submap: Submap
    ) -> bool:
        """
        Return whether the newest returns indicate that the robot is elsewhere.

        Hysteresis: a kidnapped robot stays elsewhere, so clearing a doubt requires evidence as
        strong as raising it.
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
    """Return the support relative to its usual value, and the share of returns in free space."""
    in_free = 0.0 if before is None else share_in_free_space(before, submap)
    return support / max(usual, _LEAST_USUAL), in_free


def share_in_free_space(before: Submap, submap: Submap) -> float:
    """
    Return the share of the newest returns in free space observed by ``before``.

    Both submaps share the ``odom`` frame; cells within 0.3 m of a wall do not count as free.
    Furniture is excluded from the returns, because submaps contain walls only.
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
