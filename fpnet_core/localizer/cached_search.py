# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
When the whole plan is searched, and what ticks in between go on from.

A tick that searches cuts the submap into rooms, matches them and verifies what they propose. While
a claim stands and hardly anything new is seen, that finds the same placements again: such ticks
only follow the claim and its rivals, on walls that are as fresh as those of any other tick.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from fpnet_core.config import LocalizerConfig
from fpnet_core.localizer.global_localizer import Candidates, GlobalLocalizer, MatchQuery
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.matches import MatchResult
from fpnet_core.pose import PreparedMap, map_evidence
from fpnet_core.types import Submap

NEWS_GROWTH = 1.05
"""A submap larger by this factor shows something new; chosen on drives (notes/localizer.md)."""


@dataclass(frozen=True, eq=False)
class CachedSearch:
    """
    The last search's regions and matches, and how long ago it was.

    ``free_area_m2`` is the submap's at that time; ``ticks`` have passed since.
    """

    sub: PreparedMap
    match: MatchResult
    free_area_m2: float
    updates: int = 0

    def holds(self, submap: Submap, config: LocalizerConfig) -> bool:
        """Tell whether the next tick may go on from this search."""
        is_recent = self.updates + 1 < config.search_every_updates
        return is_recent and submap.free_area_m2 < NEWS_GROWTH * self.free_area_m2

    def followed(
        self,
        global_localizer: GlobalLocalizer,
        query: MatchQuery,
        submap: Submap,
        timer: StageTimer,
    ) -> tuple[CachedSearch, Candidates]:
        """Return this search one tick later, and the tracked placements on new evidence."""
        with timer.stage('evidence'):
            sub = replace(self.sub, evidence=map_evidence(submap.grid))
        found = global_localizer.follow(replace(query, sub=sub), self.match, timer)
        return replace(self, sub=sub, updates=self.updates + 1), found
