# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Colours shared by all plots and reports, for matplotlib and plotly."""

from __future__ import annotations

PLACEMENT_COLOURS = ('#1f77b4', '#8e3fb0', '#00796b')
"""Colours of the best placement and its runners-up. Chosen: distinct from the red of doors."""

TRUTH_COLOUR, MATCH_COLOUR = '#2ca02c', '#ff7f0e'
"""Colours of the true path, and of lines between matched rooms. Chosen."""

LIDAR_COLOUR = '#0a4fb4'
"""Colour of observed walls on an accepted placement. Chosen: the darkest mark on a pale plan."""

ERROR_COLOURS = ('#00876c', '#8bb84a', '#f2b134', '#e5703a', '#b3202a')
"""Colours of a path from small to large errors, evenly spaced on :data:`ERROR_RANGE_M`. Chosen."""

ERROR_RANGE_M = (0.03, 3.0)
"""
Chosen: errors [m] of the first and the last colour, on a log scale. It is the same for all runs,
so that colours of two reports can be compared; the last one is that of a wrong pose.
"""

ERROR_TICKS_M = (0.03, 0.1, 0.3, 1.0, 3.0)
"""Chosen: labels of the colour bar [m]."""
