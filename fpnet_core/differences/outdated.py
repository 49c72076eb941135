# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection of an outdated drawing around the robot, as distinct from being lost.

A lost robot fits nowhere, which allows no conclusion about the drawing. A localized robot among
walls that are not drawn can tell where the drawing is wrong, and how much.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.differences.found import DifferenceKind, Differences
from fpnet_core.differences.of_output import differences_of
from fpnet_core.frozen import freeze_field
from fpnet_core.localizer.cached_search import NEWS_GROWTH
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.scoring.reasons import metres, percent
from fpnet_core.types import LocalizerOutput

AROUND_M = 10.0
"""Chosen: radius around the robot that is checked."""

_OUTDATED, _AGREES = 0.15, 0.1
"""
Chosen: shares of the walls nearby above which the drawing counts as outdated, and below which it
no longer does; in between the state is kept (hysteresis).
"""

_EVERY_UPDATES = 10
"""Chosen: localized updates between two checks, each of which takes as long as an update."""


@dataclass(frozen=True, eq=False)
class Outdated:
    """
    An outdated part of the drawing.

    ``xy (2,)`` is its position in the drawing's frame [m], ``new_m`` the length of observed walls
    nearby that are not drawn, ``missing_m`` the length of drawn walls that are missing, and
    ``share`` the share of both in the walls nearby.
    """

    xy: NDArray[np.float64]
    new_m: float
    missing_m: float
    share: float

    def __post_init__(self) -> None:
        """Check the position."""
        freeze_field(self, 'xy', np.float64, (2,))

    @property
    def said(self) -> str:
        """Description in one sentence."""
        x, y = self.xy.tolist()
        return (
            f'the drawing is out of date here: {metres(self.new_m)} of observed wall not drawn, '
            f'{metres(self.missing_m)} of drawn wall missing, {percent(self.share)} of the walls '
            f'within {metres(AROUND_M)} of ({x:.1f}, {y:.1f})'
        )

    def as_json(self) -> dict[str, Any]:
        """Return a mapping of plain values."""
        names = ('new_m', 'missing_m', 'share')
        rounded = {name: round(getattr(self, name), 3) for name in names}
        return {'xy': np.round(self.xy, 3).tolist(), **rounded, 'said': self.said}


def outdated_at(
    found: Differences, xy: NDArray[np.float64], walls_m: float, was_outdated: bool = False
) -> Outdated | None:
    """
    Return how much the drawing is out of date around a position; None if it is up to date.

    Parameters
    ----------
    found : all differences
    xy : (2,) the position in the drawing's frame [m]
    walls_m : length of the observed walls around it [m]
    was_outdated : the previous result, for the hysteresis
    """
    near = [
        each
        for each in found.likely
        if each.is_of_drawing
        and np.linalg.norm(each.ends.mean(axis=0) - xy) <= AROUND_M + each.length_m / 2.0
    ]
    new_m = sum(each.length_m for each in near if each.kind is DifferenceKind.WALL)
    missing_m = sum(each.length_m for each in near) - new_m
    share = (new_m + missing_m) / max(walls_m, new_m + missing_m) if near else 0.0
    if not near or share < (_AGREES if was_outdated else _OUTDATED):
        return None
    return Outdated(xy, new_m, missing_m, share)


def outdated_here(
    output: LocalizerOutput, found: Differences, was_outdated: bool = False
) -> Outdated | None:
    """Return how much the drawing is out of date around the robot; None if it is up to date."""
    submap = output.submap
    if output.A_plan_odom is None or submap is None or not len(submap.path_xy):
        return None
    xy = output.A_plan_odom.apply(submap.T_odom_submap.apply(submap.path_xy[-1]))
    cell_m = submap.grid.resolution
    cells = np.unique(np.floor(submap.recent_xy / cell_m).astype(np.int64), axis=0)
    return outdated_at(found, xy, len(cells) * cell_m, was_outdated)


class DrawingWatch:
    """
    Checks the drawing at intervals, from a running localizer's outputs.

    ``outdated`` is the last result; None if the drawing is up to date around the robot, or the
    robot is not localized.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Reset the state, as for a robot that is not localized."""
        self.outdated: Outdated | None = None
        self._updates = 0
        self._checked_m2 = 0.0
        self._storey = ''

    def follow(self, output: LocalizerOutput, plan: Floorplan | None) -> Differences | None:
        """Add an output; return all differences if they were computed for it."""
        if output.A_plan_odom is None or plan is None or output.submap is None:
            self.forget()
            return None
        self._updates += 1
        area_m2 = output.submap.free_area_m2
        has_news = area_m2 >= NEWS_GROWTH * self._checked_m2 or output.storey != self._storey
        if self._updates % _EVERY_UPDATES != 1 or not has_news:
            return None
        found = differences_of(output, plan)
        if found is not None:
            self._checked_m2, self._storey = area_m2, output.storey
            self.outdated = outdated_here(output, found, self.outdated is not None)
        return found
