# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a tick goes on from, and what it looks at: plain values."""

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
    Everything that a tick goes on from, and leaves to the next one.

    Parameters
    ----------
    plan
        The floorplan in force, and what is known of its scale; of a site, the storey that the next
        tick is about.
    others
        The site's other storeys.
    segmenter
        The rooms of the submap so far.
    standing, vicinity
        What the claim rests on: the ticks so far, and the walls around the robot.
    tracked
        ``A_plan_odom`` of the last tick's placements, working metres.
    searched
        The last search, as long as ticks may go on from it; None: the next tick searches.
    hint
        Someone's word on where the robot is, working metres.
    covariance
        How far off the claimed pose may be, working metres; None without a claim.
    is_elsewhere
        The robot is not where its submap goes on: that must begin anew.
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
        """Return the floorplans of all storeys, that in force first; none without one."""
        here = () if self.plan is None else (self.plan,)
        return (*here, *(other.plan for other in self.others))

    def on(self, *plans: Floorplan) -> UpdateState:
        """Return the beginning on other floorplans, of all of a site; the submap stays."""
        others = tuple(map(OtherStorey, plans[1:]))
        return UpdateState(plans[0], self.segmenter, others=others)

    def unlocalized(self) -> UpdateState:
        """Return the state without placements and claims; plan and submap stay."""
        return replace(self.without_submap(), segmenter=self.segmenter)

    def without_submap(self) -> UpdateState:
        """Return the beginning on the same floorplan."""
        return UpdateState(self.plan, others=tuple(each.forgotten() for each in self.others))

    def with_hint(self, hint: PoseHint) -> UpdateState:
        """Return the state with a word, in nominal metres; a claim stands until it is weighed."""
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
        """Return the state with another storey in force; ``left`` is what was found on this."""
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
        """Return the state with placements to try first, nominal metres, by the storeys' names."""
        if self.plan is None:
            return self
        others = tuple(replace(each, tracked=to_try(each.plan, starts)) for each in self.others)
        return replace(self, tracked=to_try(self.plan, starts), others=others)

    def weighed(self, weights: Mapping[str, float]) -> UpdateState:
        """Return the state with other priors of the storeys, which need not add up to one."""
        if self.plan is None:
            return self
        others = tuple(replace(each, plan=with_priors(each.plan, weights)) for each in self.others)
        return replace(self, plan=with_priors(self.plan, weights), others=others)


@dataclass(frozen=True, eq=False)
class Observation:
    """
    What a tick looks at.

    ``submap`` is everything seen so far, ``T_odom_sensor (4, 4)`` of its newest scan; None before
    the first. ``now_ns`` stamps the output meanwhile. ``is_upside_down``: the scans say so of the
    scanner.
    """

    now_ns: int
    submap: Submap | None = None
    T_odom_sensor: NDArray[np.float64] | None = None
    is_upside_down: bool = False

    @property
    def robot_xy(self) -> RobotXY:
        """Where the robot is in the submap."""
        if self.submap is None or self.T_odom_sensor is None:
            return None
        return self.submap.T_odom_submap.inv().apply(self.T_odom_sensor[:2, 3])
