# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Small storeys: homes, and practices, which have the same layout at a larger size."""

from __future__ import annotations

from dataclasses import dataclass, replace
import itertools
import math

import numpy as np
import shapely

from fpnet_lab.sim.plans.divided import bisect
from fpnet_lab.sim.plans.finish import finish
from fpnet_lab.sim.plans.layout import Cell, Style, absorb_slivers
from fpnet_lab.sim.plans.roughen import roughen
from fpnet_lab.sim.types import BuildingPlan

WALLS_M = (0.08, 0.1, 0.12, 0.15, 0.2)
"""Thickness of partition walls: boards, brick, concrete. Chosen."""

_ROOM_SPREAD = 0.2  # chosen: standard deviation of the logarithm of a room's width


@dataclass(frozen=True)
class _Habits:
    """Ranges of sizes [m]; a storey uses one door width out of ``doors``."""

    doors: tuple[float, ...]
    depth: tuple[float, float]
    hallway: tuple[float, float]
    room: float
    bath: tuple[float, float]
    aspect: tuple[float, float] = (1.0, 1.7)
    hall_share: tuple[float, float] = (0.3, 0.5)  # of the length
    divided: float = 0.0  # share of storeys without a hallway, with interconnected rooms


# Chosen: from studios of 35 to bungalows of 150 square metres; door leaves of 0.76 to 0.96 m.
_HOME = _Habits(
    doors=(0.7, 0.75, 0.8, 0.8, 0.85, 0.9), depth=(6.0, 11.5), hallway=(1.1, 1.7), room=3.4,
    bath=(1.7, 2.6), divided=0.3,
)  # fmt: skip
# Chosen: medical practices, law firms and branch offices of 80 to 300 square metres.
_PRACTICE = _Habits(
    doors=(0.85, 0.9, 0.9, 0.95, 1.0), depth=(9.0, 15.0), hallway=(1.5, 2.4), room=4.6,
    bath=(2.2, 3.6), aspect=(1.2, 2.0), hall_share=(0.0, 0.4),
)  # fmt: skip


def home(rng: np.random.Generator, style: Style) -> BuildingPlan:
    """Lay out a flat or a small single-storey house."""
    return _laid(rng, style, _HOME, 'home')


def practice(rng: np.random.Generator, style: Style) -> BuildingPlan:
    """Lay out a small office or a doctor's practice."""
    return _laid(rng, style, _PRACTICE, 'practice')


def _laid(rng: np.random.Generator, style: Style, habits: _Habits, family: str) -> BuildingPlan:
    style = replace(
        style,
        wall_m=float(rng.choice(WALLS_M)),
        room_side_m=habits.room,
        door_width_m=float(rng.choice(habits.doors)),
        is_uniform=False,
    )
    depth = float(rng.uniform(*habits.depth))
    length = depth * float(rng.uniform(*habits.aspect))
    if rng.random() < habits.divided:
        cells = [Cell(room) for room in bisect(rng, (0.0, 0.0, length, depth), style)]
        largest = max(cells, key=lambda cell: float(cell.polygon.area))
        cells[cells.index(largest)] = Cell(largest.polygon, 'hall')
    else:
        cells = _around_a_hallway(rng, length, depth, habits)
    return finish(rng, roughen(rng, absorb_slivers(cells)), style, family)


def _around_a_hallway(
    rng: np.random.Generator, length: float, depth: float, habits: _Habits
) -> list[Cell]:
    """Lay out a hallway between two banks of rooms, with the largest room across one end."""
    width = float(rng.uniform(*habits.hallway))
    end = length * (1.0 - float(rng.uniform(*habits.hall_share)))
    low = float(rng.uniform(0.3, 0.55)) * (depth - width)
    living = shapely.box(end, 0.0, length, depth)
    if rng.random() < 0.5:  # separate kitchen
        living = shapely.box(end, 0.0, length, low + width)
    cells = [
        Cell(shapely.box(0.0, low, end, low + width), 'corridor'),
        Cell(living, 'hall'),
        Cell(shapely.box(end, 0.0, length, depth).difference(living)),
    ]
    for y0, y1 in ((0.0, low), (low + width, depth)):
        for x0, x1 in itertools.pairwise(_stops(rng, end, habits)):
            cells.append(Cell(shapely.box(x0, y0, x1, y1)))
    return [cell for cell in cells if not cell.polygon.is_empty]


def _stops(rng: np.random.Generator, length: float, habits: _Habits) -> list[float]:
    """Return the wall positions along a bank of rooms that includes one small bathroom."""
    bath = float(rng.uniform(*habits.bath))
    rest = max(length - bath, 0.0)
    room = habits.room * math.exp(_ROOM_SPREAD * rng.standard_normal())
    count = max(1, round(rest / room))
    widths = [rest / count] * count
    widths.insert(int(rng.integers(count + 1)), bath)
    return [0.0, *np.cumsum(widths).tolist()]
