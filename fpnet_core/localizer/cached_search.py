# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scheduling of global searches, and reuse of the last one in the updates between.

A search segments the submap into rooms, matches them and verifies the proposed placements. While
the status is `localized` and little new is observed, it would find the same placements again.
Such updates only track the accepted placement and its competitors, on the newest walls.
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
"""Growth of the submap that counts as new; chosen on recordings (notes/localizer.md)."""


@dataclass(frozen=True, eq=False)
class CachedSearch:
    """
    Regions and matches of the last search, and its age.

    ``free_area_m2`` is the submap's at that time; ``updates`` have passed since.
    """

    sub: PreparedMap
    match: MatchResult
    free_area_m2: float
    updates: int = 0

    def holds(self, submap: Submap, config: LocalizerConfig) -> bool:
        """Return whether the next update may reuse this search."""
        is_recent = self.updates + 1 < config.search_every_updates
        return is_recent and submap.free_area_m2 < NEWS_GROWTH * self.free_area_m2

    def followed(
        self,
        global_localizer: GlobalLocalizer,
        query: MatchQuery,
        submap: Submap,
        timer: StageTimer,
    ) -> tuple[CachedSearch, Candidates]:
        """Return this search one update later, and the tracked placements on new evidence."""
        with timer.stage('evidence'):
            sub = replace(self.sub, evidence=map_evidence(submap.grid))
        found = global_localizer.follow(replace(query, sub=sub), self.match, timer)
        return replace(self, sub=sub, updates=self.updates + 1), found
