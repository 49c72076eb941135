# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Colours shared by all plots and reports of a run, for matplotlib and plotly."""

from __future__ import annotations

PLACEMENT_COLOURS = ('#1f77b4', '#8e3fb0', '#00796b')
"""Colours of the best placement and its runners-up. Chosen: distinct from the red of doors."""

TRUTH_COLOUR, MATCH_COLOUR = '#2ca02c', '#ff7f0e'
"""Colours of the true path, and of lines between matched rooms. Chosen."""
