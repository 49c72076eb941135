# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random storeys that follow the statistics of real ones: :func:`generate_plan`."""

from fpnet_lab.sim.plans.generate import BUILDINGS, FAMILIES, generate_plan

__all__ = ['BUILDINGS', 'FAMILIES', 'generate_plan']
