# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Check of a floorplan before a robot drives: parse, scale, look-alikes, advice."""

from fpnet.plan_check.check import DriveTour, PlanCheck, TourResult, check_plan

__all__ = ['DriveTour', 'PlanCheck', 'TourResult', 'check_plan']
