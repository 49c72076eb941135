# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""State and observation of an update: plain values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.localizer.cached_search import CachedSearch
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.kidnap import KidnapState
from fpnet_core.localizer.prepared_maps import RobotXY
from fpnet_core.localizer.storeys import OtherStorey, to_try, weights_of_word, with_priors
from fpnet_core.localizer.tracking import TrackState
from fpnet_core.pose_covariance import PoseCovariance
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.types import Submap


@dataclass(frozen=True, eq=False)
class UpdateState:
    """
    State passed from one update to the next.

    Parameters
    ----------
    plan
        Current floorplan with its scale; on a site, the storey of the next
        update.
    others
        Other storeys of the site.
    segmenter
        Segmentation state of the submap.
    track, kidnap_state
        History of the updates, and the check against walls near the robot.
    tracked
        ``A_plan_odom`` of the last update's placements, working metres.
    searched
        The last search while updates may reuse it; None: the next update searches.
    hint
        Hint about the robot's pose, working metres.
    covariance
        Of the accepted pose, working metres; None while not localized.
    is_elsewhere
        The robot has left the place where its submap continues; a new submap is required.
    """

    plan: Floorplan | None = None
    segmenter: SubmapSegmenter = field(default_factory=SubmapSegmenter)
    track: TrackState = field(default_factory=TrackState)
    kidnap_state: KidnapState = field(default_factory=KidnapState)
    tracked: Placements = field(default_factory=Placements.empty)
    searched: CachedSearch | None = None
    hint: PoseHint | None = None
    covariance: PoseCovariance | None = None
    is_elsewhere: bool = False
    others: tuple[OtherStorey, ...] = ()

    @property
    def storeys(self) -> tuple[Floorplan, ...]:
        """Floorplans of all storeys, the current one first; empty without one."""
        here = () if self.plan is None else (self.plan,)
        return (*here, *(other.plan for other in self.others))

    def on(self, *plans: Floorplan) -> UpdateState:
        """Return the initial state on other floorplans, one per storey; the submap is kept."""
        others = tuple(map(OtherStorey, plans[1:]))
        return UpdateState(plans[0], self.segmenter, others=others)

    def unlocalized(self) -> UpdateState:
        """Return the state without placements; plan and submap are kept."""
        return replace(self.without_submap(), segmenter=self.segmenter)

    def without_submap(self) -> UpdateState:
        """Return the initial state on the same floorplan."""
        return UpdateState(self.plan, others=tuple(each.forgotten() for each in self.others))

    def with_hint(self, hint: PoseHint) -> UpdateState:
        """Return the state with a hint, nominal metres; the status is kept until it is weighed."""
        state = self
        if self.plan is not None and self.others:
            storey = hint.storey or self.plan.name
            names = [plan.name for plan in self.storeys]
            state = self.about(storey).weighed(weights_of_word(storey, names))
        if state.plan is not None:
            hint = replace(hint, T_plan_base=state.plan.to_working(hint.T_plan_base))
        tracked = Placements.of([hint.A_plan_odom]).joined(state.tracked)
        return replace(state, hint=hint, tracked=tracked, searched=None)

    def about(self, storey: str, left: OtherStorey | None = None) -> UpdateState:
        """Return the state with another current storey; ``left`` are the results on this one."""
        chosen = next((each for each in self.others if each.plan.name == storey), None)
        if chosen is None or self.plan is None:
            return self
        left = left or OtherStorey(self.plan, self.tracked)
        others = tuple(left if each is chosen else each for each in self.others)
        track = TrackState(was_localized=self.track.was_localized)
        return UpdateState(
            chosen.plan, self.segmenter, track, tracked=chosen.tracked, others=others
        )

    def starting(self, starts: Mapping[str, Affine2D]) -> UpdateState:
        """Return the state with placements to try first, nominal metres, by storey name."""
        if self.plan is None:
            return self
        others = tuple(replace(each, tracked=to_try(each.plan, starts)) for each in self.others)
        return replace(self, tracked=to_try(self.plan, starts), others=others)

    def weighed(self, weights: Mapping[str, float]) -> UpdateState:
        """Return the state with new priors of the storeys, which need not sum to one."""
        if self.plan is None:
            return self
        others = tuple(replace(each, plan=with_priors(each.plan, weights)) for each in self.others)
        return replace(self, plan=with_priors(self.plan, weights), others=others)


@dataclass(frozen=True, eq=False)
class Observation:
    """
    Input of an update.

    ``submap`` contains all observations, ``T_odom_sensor (4, 4)`` is that of its newest scan; None
    before the first. ``now_ns`` stamps the output until then. ``is_upside_down``: the scans
    indicate an inverted scanner.
    """

    now_ns: int
    submap: Submap | None = None
    T_odom_sensor: NDArray[np.float64] | None = None
    is_upside_down: bool = False

    @property
    def robot_xy(self) -> RobotXY:
        """Position of the robot in the submap."""
        if self.submap is None or self.T_odom_sensor is None:
            return None
        return self.submap.T_odom_submap.inv().apply(self.T_odom_sensor[:2, 3])
