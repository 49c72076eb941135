# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random generation of a storey: its layout family, its style and its rooms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import math

import numpy as np

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.plans import composed, divided, families, homes, variants
from fpnet_lab.sim.plans.finish import finish
from fpnet_lab.sim.plans.layout import MIN_CELL_AREA_M2, Cell, Style
from fpnet_lab.sim.plans.roughen import roughen
from fpnet_lab.sim.types import BuildingPlan

Family = Callable[[np.random.Generator, Style], BuildingPlan]


def _from_cells(name: str, layout: Callable[[np.random.Generator, Style], list[Cell]]) -> Family:
    """Wrap a cell layout: apply irregular changes to its rooms, then build it."""

    def family(rng: np.random.Generator, style: Style) -> BuildingPlan:
        cells = layout(rng, style)
        return finish(rng, cells if style.is_uniform else roughen(rng, cells), style, name)

    return family


_LAYOUTS = (
    families.double_corridor,
    families.racetrack,
    families.branched,
    families.central_hall,
    families.ring_polygon,
    families.diagonal,
    divided.suites,
    divided.apartments,
    divided.house,
    divided.open_plan,
    variants.repeated,
    variants.bent,
    variants.curved_facade,
    variants.bays,
)

BUILDINGS: dict[str, Family] = {
    **{layout.__name__: _from_cells(layout.__name__, layout) for layout in _LAYOUTS},
    'mirrored': composed.mirrored,
    'turned': composed.turned,
    'disconnected': composed.disconnected,
}
"""Layout families that are sampled by default, by name."""

FAMILIES = BUILDINGS | {'home': homes.home, 'practice': homes.practice}
"""All layout families by name."""

ROOM_TO_ROOM = (0.0, 0.0, 0.04, 0.15, 0.5, 0.85)
"""
Shares of neighbouring rooms with a connecting door: few in most buildings, nearly all in some.
Fitted by hand to the development split (docs/simulator.md).
"""

DOOR_HABITS_M = (0.8, 0.9, 0.9, 0.95, 0.95, 1.0, 1.4)
"""
Door widths of buildings with a single door width. Fitted by hand to the development split
(docs/simulator.md).
"""

MAX_ROOMS = 90  # chosen
_ATTEMPTS = 60  # numerical


def generate_plan(
    rng: np.random.Generator,
    family: str | None = None,
    min_rooms: int = 8,
    max_rooms: int = MAX_ROOMS,
    max_area_m2: float | None = None,
    families: Sequence[str] = (),
) -> BuildingPlan:
    """
    Return a random storey with all rooms reachable ('disconnected' consists of two parts).

    Parameters
    ----------
    rng : random generator; equal generators give equal plans
    family : a key of :data:`FAMILIES`; None samples one of ``families``
    min_rooms, max_rooms : bounds of the number of rooms, including corridors
    max_area_m2 : upper bound of the total floor area of all rooms; None: unbounded
    families : families to sample from; empty: all of :data:`BUILDINGS`

    Raises
    ------
    ConfigError
        If the family is unknown, or the rooms do not fit into the area or the family.
    """
    wanted = list(families or BUILDINGS) if family is None else [family]
    _check_request(wanted, min_rooms, max_rooms, max_area_m2)
    for _ in range(_ATTEMPTS):
        name = wanted[0] if len(wanted) == 1 else str(rng.choice(wanted))
        style = draw_style(rng)
        plan = FAMILIES[name](rng, style)
        is_small = max_area_m2 is None or plan.floor_area_m2 <= max_area_m2
        if min_rooms <= len(plan.rooms) <= max_rooms and is_small:
            return plan
    bound = '' if max_area_m2 is None else f' on at most {max_area_m2:g} m²'
    raise ConfigError(
        f'no {family or "random"} plan with {min_rooms} to {max_rooms} rooms{bound} '
        f'in {_ATTEMPTS} attempts; widen the bounds'
    )


def _check_request(
    wanted: Sequence[str], min_rooms: int, max_rooms: int, max_area_m2: float | None
) -> None:
    """Raise ConfigError if no storey can meet the request."""
    for family in wanted:
        if family not in FAMILIES:
            raise ConfigError(f'unknown family {family!r}; expected one of {", ".join(FAMILIES)}')
    if min_rooms > max_rooms:
        raise ConfigError(f'min_rooms {min_rooms} exceeds max_rooms {max_rooms}; swap the bounds')
    if max_area_m2 is not None and min_rooms * MIN_CELL_AREA_M2 > max_area_m2:
        raise ConfigError(
            f'{min_rooms} rooms do not fit into {max_area_m2:g} m²: the smallest room needs '
            f'{MIN_CELL_AREA_M2:g} m²; request fewer rooms or a larger area'
        )


def draw_style(rng: np.random.Generator) -> Style:
    """Sample the design parameters of one building."""
    is_uniform = bool(rng.random() < 0.15)
    return Style(
        wall_m=float(rng.choice([0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.35])),
        room_side_m=float(5.6 * math.exp(0.15 * rng.standard_normal())),
        spread=float(rng.uniform(0.15, 0.45)),
        is_uniform=is_uniform,
        room_to_room=float(rng.choice(ROOM_TO_ROOM)),
        second_door=float(rng.uniform(0.1, 0.5)),
        door_width_m=float(rng.choice(DOOR_HABITS_M)) if rng.random() < 0.4 else None,
    )
