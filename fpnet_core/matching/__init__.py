# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Region matching: protocol, graded thresholds, selection of matches.

The learned matcher is in :mod:`fpnet_core.matching.learned`, which loads compiled kernels and
the network; this package does not.
"""

from fpnet_core.matching.thresholds import graded_threshold
from fpnet_core.matching.types import RegionMatcher, mutual_pairs

__all__ = ['RegionMatcher', 'graded_threshold', 'mutual_pairs']
