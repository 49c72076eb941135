# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Many floorplans at once: which of them are worth searching for what a robot has seen."""

from fpnet.library.library import LibraryPlan, PlanLibrary, Proposal, plan_of

__all__ = ['LibraryPlan', 'PlanLibrary', 'Proposal', 'plan_of']
