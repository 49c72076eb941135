# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Localizer for sites with several storeys: storey hints, and detection of lifts and stairs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import HintError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.localizer import Localizer
from fpnet_core.matching import RegionMatcher
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.sites.cabin import CABIN_M, CabinWatch
from fpnet_core.sites.ride import RideWatch
from fpnet_core.sites.site import LinkKind, Site
from fpnet_core.sites.storey_plans import (
    storey_named,
    storey_plans,
    weights_after_leaving,
    weights_of_elevation,
    weights_of_level,
)
from fpnet_core.types import LocalizerOutput

_Snapshot = tuple[str, LocalizerOutput, NDArray[np.float64]]  # storey, output, T_odom_sensor


def create_site_localizer(config: FpnetConfig) -> SiteLocalizer:
    """
    Return a localizer for floorplans and sites, with the learned matcher.

    Raises
    ------
    WeightsError
        If the weights are missing, corrupt, or made for another feature schema.
    """
    return SiteLocalizer(config, LearnedMatcher(config.matcher))


class SiteLocalizer(Localizer):
    """
    Localizes the robot on one of a site's storeys; otherwise like :class:`Localizer`.

    Parameters
    ----------
    config, matcher : as in :class:`Localizer`
    """

    def __init__(self, config: FpnetConfig, matcher: RegionMatcher) -> None:
        super().__init__(config, matcher)
        self._config_of_plans = config
        self._site: Site | None = None
        self._ride, self._cabin = RideWatch(), CabinWatch()
        self._entered: _Snapshot | None = None  # state in a lift whose doors may be closing
        self._left: _Snapshot | None = None
        self._storey_hint: Mapping[str, float] | None = None  # hint since the last storey was left

    @property
    def site(self) -> Site | None:
        """The current site, or None."""
        return self._site

    def set_site(self, site: Site) -> None:
        """
        Set the site; it replaces all floorplans.

        Raises
        ------
        MapFormatError
            If a storey's drawing has no rooms; the old floorplans are kept.
        """
        self.set_storeys(storey_plans(site, self._config_of_plans))
        self._site = site

    def add_scan(
        self,
        points: NDArray[np.float32],
        T_odom_sensor: NDArray[np.float64],
        stamp_ns: int,
        viewpoints: NDArray[np.float32] | None = None,
    ) -> None:
        """Add a scan as :meth:`Localizer.add_scan`; a change of storey starts a new submap."""
        before = self._state_at(T_odom_sensor)  # the update may lose the pose inside a lift
        super().add_scan(points, T_odom_sensor, stamp_ns, viewpoints)
        if self._site is None or len(self._site.storeys) == 1:
            return
        self._follow_cabin(stamp_ns, points, before)
        self._follow_height(stamp_ns, T_odom_sensor)

    def _follow_height(self, stamp_ns: int, T_odom_sensor: NDArray[np.float64]) -> None:
        ride = self._ride.follow(stamp_ns, T_odom_sensor)
        if ride is None:
            return
        if not ride.is_over and not self._cabin.is_shut:
            self._left, self._storey_hint = self._state_at(T_odom_sensor), None
        way = 'up' if ride.rise_m > 0.0 else 'down'
        why = f'the robot has moved {way} by {abs(ride.rise_m):.1f} m'
        self._leave(why, ride.rise_m if ride.is_over else None)

    def _follow_cabin(self, stamp_ns: int, points: NDArray[np.float32], before: _Snapshot) -> None:
        """Leave the storey when a lift closes, from the state ``before``; restart as it opens."""
        if not self._cabin.is_shutting:
            if not self._is_at_lift(before):
                return
            self._entered = before
        if not self._cabin.follow(stamp_ns, points, before[2]):
            return
        if self._cabin.is_shut:
            self._left, self._storey_hint = self._entered, None
            self._leave('the robot is in a closed lift', None)
        else:
            self._leave('the lift has opened', None)

    def _is_at_lift(self, state: _Snapshot) -> bool:
        """Return whether the accepted pose is at a lift."""
        storey, output, T_odom_sensor = state
        site, pose = self._known_site(), output.pose(T_odom_sensor)
        if pose is None or storey not in site.names:
            return False
        stops = [link.at[storey] for link in site.linked(storey) if link.kind is LinkKind.LIFT]
        return any(np.linalg.norm(stop - pose.translation) <= CABIN_M for stop in stops)

    def _state_at(self, T_odom_sensor: NDArray[np.float64]) -> _Snapshot:
        return self.output.storey, self.output, np.array(T_odom_sensor)

    def tell_level(self, said: str) -> None:
        """
        Apply a storey hint, for example from a lift: the storey's name or level.

        If the robot is localized on another storey, that pose and the submap are dropped.

        Raises
        ------
        HintError
            If there is no site, or if not exactly one storey matches.
        """
        site = self._known_site()
        named, weights = storey_named(site, said), weights_of_level(site, said)
        output = self.output
        self._storey_hint = weights
        if output.A_plan_odom is None:
            self.suggest_storey(weights)
        elif output.storey != named.name:
            self.leave_storey(weights, f'the robot is on storey {named.name} now')

    def tell_elevation(self, elevation_m: float) -> None:
        """
        Apply an elevation hint, for example from a barometer: height of the floor in the site [m].

        Raises
        ------
        HintError
            If there is no site, the height is not finite, or a storey's elevation is unknown.
        """
        weights = weights_of_elevation(self._known_site(), elevation_m)
        output, self._storey_hint = self.output, weights
        if output.A_plan_odom is None:
            self.suggest_storey(weights)
        elif weights[output.storey] < max(weights.values()):
            self.leave_storey(weights, f'the robot is at {elevation_m:.1f} m now')

    def _known_site(self) -> Site:
        if self._site is None:
            raise HintError('storey hints need a site, and no site is loaded')
        return self._site

    def _leave(self, why: str, rise_m: float | None) -> None:
        """Drop the submap; raise the prior of storeys that links connect to the last one."""
        assert self._site is not None and self._left is not None  # noqa: PT018
        storey, output, T_odom_sensor = self._left
        if storey not in self._site.names or output.A_plan_odom is None:
            even = dict.fromkeys(self._site.names, 1.0)
            self.leave_storey(self._storey_hint or even, why)
            return
        pose = output.pose(T_odom_sensor)
        xy = None if pose is None else pose.translation
        weights = self._storey_hint or weights_after_leaving(self._site, storey, xy, rise_m)
        starts = continued(self._site, storey, output.A_plan_odom)
        self.leave_storey(weights, why, starts)


def continued(site: Site, left: str, A_plan_odom: Affine2D) -> Mapping[str, Affine2D]:
    """
    Return ``A_plan_odom`` for all storeys whose pose relative to the one left is known.

    The storey that was left is included: lift doors may close and open without a ride.
    """
    T_site_left = site.storey(left).T_site_plan
    placed = {left: A_plan_odom}
    if T_site_left is None:
        return placed
    for storey in site.storeys:
        if storey.T_site_plan is not None and storey.building == site.storey(left).building:
            T_plan_left: SE2 = storey.T_site_plan.inv() @ T_site_left
            placed[storey.name] = T_plan_left @ A_plan_odom
    return placed
