# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hospital-like storeys of any size: parallel, linked corridors lined with rooms."""

from __future__ import annotations

import numpy as np

from fpnet_lab.sim.plans.families import bank_depth, corridor_width
from fpnet_lab.sim.plans.finish import finish
from fpnet_lab.sim.plans.layout import Style
from fpnet_lab.sim.plans.skeleton import Arm, build_cells
from fpnet_lab.sim.types import BuildingPlan

# Chosen, not measured:
_STYLE = Style(wall_m=0.2, room_side_m=6.6, spread=0.35)  # about 50 m2 per room
_LINK_EVERY_M = 60.0


def wards(rng: np.random.Generator, area_m2: float) -> BuildingPlan:
    """
    Return a storey with a gross area of about ``area_m2``.

    Parallel corridors of equal width make the storey about square; links join them about every
    60 m. Banks and rooms vary.
    """
    width, side = corridor_width(rng), float(np.sqrt(area_m2))
    pitch = width + 2.0 * _STYLE.room_side_m
    lanes = max(1, round(side / pitch))
    length = area_m2 / (lanes * pitch)
    rows = [(lane * pitch, *(bank_depth(rng, _STYLE) for _ in range(2))) for lane in range(lanes)]
    arms = [Arm((0.0, y), (length, y), width, left, right) for y, left, right in rows]
    links = np.linspace(0.0, length, 2 + int(length / _LINK_EVERY_M))
    if lanes > 1:
        top = (lanes - 1) * pitch
        arms = [Arm((x, 0.0), (x, top), width, 0.0, 0.0) for x in links.tolist()] + arms
    return finish(rng, build_cells(rng, arms, _STYLE), _STYLE, 'wards')
