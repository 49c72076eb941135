# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Index of many floorplans that proposes those which may contain a robot map."""

from fpnet.library.library import LibraryPlan, PlanLibrary, Proposal, plan_of

__all__ = ['LibraryPlan', 'PlanLibrary', 'Proposal', 'plan_of']
