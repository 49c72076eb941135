# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Where the robot is, the drawing is out of date: another thing than being lost.

Who is lost fits nowhere, and nothing can be said of the drawing. Who is localized among walls that
are not drawn can say where the drawing is wrong, and by how much.
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
"""Chosen: what lies so far from the robot is "here"."""

_OUTDATED, _AGREES = 0.15, 0.1
"""
Chosen: shares of the walls here that must differ for the drawing to be called outdated, and below
which it is no longer: what is in between says nothing new.
"""

_EVERY_TICKS = 10
"""Chosen: claimed ticks between two looks, each about as long as a tick."""


@dataclass(frozen=True, eq=False)
class Outdated:
    """
    The drawing is out of date around a place.

    ``xy (2,)`` is the place in the drawing's frame [m], ``new_m`` the length of wall near it that
    is not drawn, ``missing_m`` of what is drawn and not there, and ``share`` that of both in the
    walls there.
    """

    xy: NDArray[np.float64]
    new_m: float
    missing_m: float
    share: float

    def __post_init__(self) -> None:
        """Check the place."""
        freeze_field(self, 'xy', np.float64, (2,))

    @property
    def said(self) -> str:
        """Where and how much, in one sentence."""
        x, y = self.xy.tolist()
        return (
            f'the drawing is out of date here: {metres(self.new_m)} of wall that is not drawn, '
            f'{metres(self.missing_m)} drawn and not there, {percent(self.share)} of the walls '
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
    Return how far the drawing is out of date around a place; None where it is not.

    Parameters
    ----------
    found : all differences
    xy : (2,) the place in the drawing's frame [m]
    walls_m : length of the walls seen around it [m]
    was_outdated : it was before, and needs less to stay so
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
    """Return how far the drawing is out of date where the robot is; None unless it is."""
    submap = output.submap
    if output.A_plan_odom is None or submap is None or not len(submap.path_xy):
        return None
    xy = output.A_plan_odom.apply(submap.T_odom_submap.apply(submap.path_xy[-1]))
    cell_m = submap.grid.resolution
    cells = np.unique(np.floor(submap.recent_xy / cell_m).astype(np.int64), axis=0)
    return outdated_at(found, xy, len(cells) * cell_m, was_outdated)


class DrawingWatch:
    """
    Follows a running localizer's outputs, and looks now and then at what differs.

    ``outdated`` is what holds where the robot is; None where the drawing agrees, or nobody knows
    where the robot is.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew: nobody knows where the robot is."""
        self.outdated: Outdated | None = None
        self._updates = 0
        self._looked_m2 = 0.0
        self._storey = ''

    def follow(self, output: LocalizerOutput, plan: Floorplan | None) -> Differences | None:
        """Take an output; return all differences if this was a look at them."""
        if output.A_plan_odom is None or plan is None or output.submap is None:
            self.forget()
            return None
        self._updates += 1
        area_m2 = output.submap.free_area_m2
        has_news = area_m2 >= NEWS_GROWTH * self._looked_m2 or output.storey != self._storey
        if self._updates % _EVERY_TICKS != 1 or not has_news:
            return None
        found = differences_of(output, plan)
        if found is not None:
            self._looked_m2, self._storey = area_m2, output.storey
            self.outdated = outdated_here(output, found, self.outdated is not None)
        return found
