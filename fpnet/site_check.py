# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Similarity of a site's storeys: each storey is matched as a robot map against all storeys.

The placement scorer estimates whether a fully mapped storey can be confused with another one. An
overlay of both plans yields the share of common walls and the rooms that differ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.differences.overlay import overlay
from fpnet_core.localizer.global_localizer import GlobalLocalizer
from fpnet_core.localizer.maps import (
    MapMatch,
    SegmentedMap,
    cut_of,
    match_storeys,
    segment_robot_map,
)
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.raster.morphology import grown
from fpnet_core.sites.site import Site, Storey
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, UNKNOWN, GridMap

_SAME_M = 0.3
"""Physical: drawings of two storeys place the same wall within this distance [m]."""

_ROOM_SAME = 0.9
"""Chosen: a room is the same if this share of its walls also exists on the other storey."""

_MIN_COMMON = 0.6
"""Chosen: storeys with a smaller share of common walls are not reported."""


@dataclass(frozen=True)
class LikeStorey:
    """
    A storey that looks like another one.

    ``common`` is the share of its walls that also exist on ``other``; ``confusion`` the
    probability that a complete map of it is placed on ``other``; ``rooms`` are the numbers of its
    rooms that differ.
    """

    storey: str
    other: str
    common: float
    confusion: float
    rooms: tuple[int, ...]

    def said(self, accept_probability: float) -> str:
        """Return a one-line description."""
        share = f'{round(100 * self.common)} % of the walls of {self.storey} also exist on'
        if self.confusion >= 1.0 - accept_probability:
            return f'{share} {self.other}: walls alone cannot distinguish them'
        if not self.rooms:
            return f'{share} {self.other}; no single room differs'
        named = ', '.join(map(str, self.rooms))
        return f'{share} {self.other}; they differ in rooms {named}'


@dataclass(frozen=True, eq=False)
class SiteCheck:
    """Rooms and areas [m^2] of a site's storeys, and similar pairs, most similar first."""

    site: Site
    rooms: dict[str, int]
    areas_m2: dict[str, float]
    alike: tuple[LikeStorey, ...]
    accept_probability: float

    def lines(self) -> list[str]:
        """Return the report, one line per item."""
        site = self.site
        said = [self._storey(storey) for storey in site.storeys]
        for link in site.links:
            said.append(f'{link.kind.value} {link.name}: {", ".join(link.at)}')
        said += [each.said(self.accept_probability) for each in self.alike]
        if not self.alike and len(site.storeys) > 1:
            said.append('no two storeys look alike')
        return said

    def _storey(self, storey: Storey) -> str:
        name, height = storey.name, storey.elevation_m
        at = '' if height is None else f', {height:g} m up'
        doors = f', {len(storey.doors)} named doors' if storey.doors else ''
        return (
            f'storey {name}: {storey.plan.drawing.name}, level {storey.level}{at}, '
            f'{self.rooms[name]} rooms, {self.areas_m2[name]:.0f} m²{doors}'
        )

    def as_json(self) -> dict[str, Any]:
        """Return a JSON-serializable mapping."""
        return {
            'site': self.site.name,
            'storeys': [
                {
                    'name': storey.name,
                    'building': storey.building,
                    'level': storey.level,
                    'elevation_m': storey.elevation_m,
                    'rooms': self.rooms[storey.name],
                    'area_m2': round(self.areas_m2[storey.name], 1),
                }
                for storey in self.site.storeys
            ],
            'links': [
                {
                    'name': link.name,
                    'kind': link.kind.value,
                    'at': {name: xy.tolist() for name, xy in link.at.items()},
                }
                for link in self.site.links
            ],
            'alike': [
                {
                    'storey': each.storey,
                    'other': each.other,
                    'common_walls': round(each.common, 4),
                    'confusion': round(each.confusion, 4),
                    'differing_rooms': list(each.rooms),
                }
                for each in self.alike
            ],
        }


def check_site(
    site: Site,
    global_localizer: GlobalLocalizer,
    config: FpnetConfig,
    advance: Callable[[float], None],
) -> SiteCheck:
    """
    Match each storey against all others; ``advance(1)`` is called after each one.

    Raises
    ------
    MapFormatError
        If a plan holds no room.
    """
    plans = {storey.name: cut_of(storey.plan, config) for storey in site.storeys}
    found: list[LikeStorey] = []
    for storey in site.storeys if len(site.storeys) > 1 else ():
        found += _like(storey.name, plans, global_localizer, config)
        advance(1.0)
    return SiteCheck(
        site,
        {name: len(cut.segmentation.rooms) for name, cut in plans.items()},
        {name: _area_m2(cut) for name, cut in plans.items()},
        tuple(sorted(found, key=lambda each: (-each.confusion, -each.common))),
        config.localizer.accept_probability,
    )


def _area_m2(cut: SegmentedMap) -> float:
    nominal = sum(room.area_m2 for room in cut.segmentation.rooms)
    return nominal * cut.scale.factor**2


def _like(
    name: str,
    plans: dict[str, SegmentedMap],
    global_localizer: GlobalLocalizer,
    config: FpnetConfig,
) -> list[LikeStorey]:
    """Return the storeys that the storey ``name`` looks like."""
    cut = plans[name]
    seen = submap_from_grid(_as_seen(cut))
    sub = segment_robot_map(seen, config, cut.is_stated)
    found = match_storeys(plans, sub, global_localizer, StageTimer())
    like = []
    for other, match in found.items():
        if other == name or not match.candidates.estimates:
            continue
        common, rooms = _compared(match)
        if common >= _MIN_COMMON:
            like.append(LikeStorey(name, other, common, match.probability, rooms))
    return like


def _as_seen(cut: SegmentedMap) -> GridMap:
    """Return a storey as a complete robot map: its rooms with their walls."""
    segmentation = cut.segmentation
    grid, inside = segmentation.grid, segmentation.labels > 0
    near = grown(inside, max(1, round(_SAME_M / grid.resolution)))
    cells = np.where(near, grid.cells, UNKNOWN)
    cells[near & ~inside & (grid.cells == FREE) & ~_doorways(cut)] = UNKNOWN
    return replace(grid, cells=cells)


def _doorways(cut: SegmentedMap) -> NDArray[np.bool_]:
    """Return the mask of narrow gaps between rooms that belong to no room."""
    inside = cut.segmentation.labels > 0
    reach = max(1, round(_SAME_M / cut.segmentation.grid.resolution))
    closed = ~grown(~grown(inside, reach), reach)
    return np.asarray(closed & ~inside)


def _compared(match: MapMatch) -> tuple[float, tuple[int, ...]]:
    """Return the share of common walls, and the rooms of the matched storey that differ."""
    A_other_here = match.candidates.estimates[0].A_plan_submap
    laid = overlay(match.sub, match.plan, A_other_here.inv())
    is_common = laid.seen_m <= _SAME_M
    walls = laid.is_drawn
    common = float((walls & is_common).sum()) / max(int(walls.sum()), 1)
    segmentation = match.sub.segmentation
    reach = max(1, round(_SAME_M / segmentation.grid.resolution))
    differing = []
    for room in segmentation.rooms:
        around = grown(segmentation.labels == room.id + 1, reach) & walls
        share = float((around & is_common).sum()) / max(int(around.sum()), 1)
        if share < _ROOM_SAME:
            differing.append(room.id)
    return common, tuple(differing)
