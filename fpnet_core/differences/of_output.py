# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differences between a localizer's output and its floorplan."""

from __future__ import annotations

from fpnet_core.differences.finding import find_differences
from fpnet_core.differences.found import Differences
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.pose import PreparedMap, map_evidence
from fpnet_core.types import LocalizerOutput


def differences_of(output: LocalizerOutput, plan: Floorplan) -> Differences | None:
    """
    Return the differences between a floorplan and the submap; None unless localized.

    The result is in the frame of the floorplan as given. Takes about as long as an update.
    """
    seen, graph = output.segmentation, output.graph
    if output.A_plan_odom is None or seen is None or graph is None or not output.estimates:
        return None
    sub = PreparedMap(seen, graph, map_evidence(seen.grid))
    A_working_sub = plan.placed_in_working(output.estimates[0].A_plan_submap)
    return find_differences(plan.working, sub, A_working_sub, plan.given)
