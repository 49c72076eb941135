# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a colour means in all pictures and reports of a run, for matplotlib and plotly alike."""

from __future__ import annotations

PLACEMENT_COLOURS = ('#1f77b4', '#8e3fb0', '#00796b')
"""Of the best placement and its rivals. Chosen: neither is the red of doors."""

TRUTH_COLOUR, MATCH_COLOUR = '#2ca02c', '#ff7f0e'
"""Of the true path, and of lines between matched rooms. Chosen."""
