# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differences between drawing and building: observed but not drawn, and drawn but missing."""

from fpnet_core.differences.finding import find_differences
from fpnet_core.differences.found import Difference, DifferenceKind, Differences

__all__ = ['Difference', 'DifferenceKind', 'Differences', 'find_differences']
