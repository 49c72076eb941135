# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Homes: small rooms around a short hallway and one living room, with narrow doors."""

from __future__ import annotations

from dataclasses import replace
import itertools

import numpy as np
import shapely

from fpnet_lab.sim.plans.divided import bisect
from fpnet_lab.sim.plans.finish import finish
from fpnet_lab.sim.plans.layout import Cell, Style, absorb_slivers
from fpnet_lab.sim.plans.roughen import roughen
from fpnet_lab.sim.types import BuildingPlan

DOORS_M = (0.7, 0.75, 0.8, 0.8, 0.85, 0.9)
"""
Clear widths of the doors inside a home: leaves of 0.76 to 0.96 m in most building codes' tables.
Chosen; one per home.
"""

WALLS_M = (0.08, 0.1, 0.12, 0.15, 0.2)
"""Partition walls of homes: boards, brick, concrete. Chosen."""

# Chosen to span studios of 35 to bungalows of 150 square metres:
_DEPTH_M = (6.0, 11.5)
_ASPECT = (1.0, 1.7)
_HALLWAY_M = (1.1, 1.7)
_LIVING_SHARE = (0.3, 0.5)  # of the length
_ROOM_M = (3.4, 0.2)  # median of a bedroom's width, deviation of its logarithm
_BATH_M = (1.7, 2.6)
_DIVIDED = 0.3  # share of homes without a hallway, whose rooms open to each other


def home(rng: np.random.Generator, style: Style) -> BuildingPlan:
    """Lay a flat or a small house of one storey."""
    style = replace(
        style,
        wall_m=float(rng.choice(WALLS_M)),
        room_side_m=_ROOM_M[0],
        door_width_m=float(rng.choice(DOORS_M)),
        is_uniform=False,
    )
    depth = float(rng.uniform(*_DEPTH_M))
    length = depth * float(rng.uniform(*_ASPECT))
    if rng.random() < _DIVIDED:
        cells = [Cell(room) for room in bisect(rng, (0.0, 0.0, length, depth), style)]
        largest = max(cells, key=lambda cell: float(cell.polygon.area))
        cells[cells.index(largest)] = Cell(largest.polygon, 'hall')
    else:
        cells = _around_a_hallway(rng, length, depth)
    return finish(rng, roughen(rng, absorb_slivers(cells)), style, 'home')


def _around_a_hallway(rng: np.random.Generator, length: float, depth: float) -> list[Cell]:
    """Lay a hallway between two banks of rooms; the living room takes one end of it all."""
    width = float(rng.uniform(*_HALLWAY_M))
    end = length * (1.0 - float(rng.uniform(*_LIVING_SHARE)))
    low = float(rng.uniform(0.3, 0.55)) * (depth - width)
    living = shapely.box(end, 0.0, length, depth)
    if rng.random() < 0.5:  # the kitchen is cut off it
        living = shapely.box(end, 0.0, length, low + width)
    cells = [
        Cell(shapely.box(0.0, low, end, low + width), 'corridor'),
        Cell(living, 'hall'),
        Cell(shapely.box(end, 0.0, length, depth).difference(living)),
    ]
    for y0, y1 in ((0.0, low), (low + width, depth)):
        for x0, x1 in itertools.pairwise(_stops(rng, end)):
            cells.append(Cell(shapely.box(x0, y0, x1, y1)))
    return [cell for cell in cells if not cell.polygon.is_empty]


def _stops(rng: np.random.Generator, length: float) -> list[float]:
    """Return where the walls of a bank of bedrooms and one bathroom stand."""
    bath = float(rng.uniform(*_BATH_M))
    rest = max(length - bath, 0.0)
    count = max(1, round(rest / (_ROOM_M[0] * float(np.exp(_ROOM_M[1] * rng.standard_normal())))))
    widths = [rest / count] * count
    widths.insert(int(rng.integers(count + 1)), bath)
    return [0.0, *np.cumsum(widths).tolist()]
