# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A storey of a varied sheet as marks: floors, walls, doors, what is in rooms, what is written."""

from __future__ import annotations

import numpy as np

from fpnet_lab.sim.sheets.artwork import Mark
from fpnet_lab.sim.sheets.door_styles import door_marks
from fpnet_lab.sim.sheets.floor_styles import floor_marks
from fpnet_lab.sim.sheets.looks import Look
from fpnet_lab.sim.sheets.storeys import PlacedStorey
from fpnet_lab.sim.sheets.wall_styles import wall_marks


def interior_marks(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return floors, walls, windows, doors and symbols, the lowest first."""
    style = look.interior
    if style is None:
        return []
    marks = floor_marks(storey, look, style, rng)
    marks += wall_marks(storey, look, style)
    return marks + door_marks(storey, look, style, rng)


def interior_letters(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return what is written into rooms."""
    del storey, look, rng
    return []
