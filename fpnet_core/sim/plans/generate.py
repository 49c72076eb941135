# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws a family, an architect's style and a storey."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fpnet_core.errors import ConfigError
from fpnet_core.sim.plans import composed, divided, families, variants
from fpnet_core.sim.plans.finish import finish
from fpnet_core.sim.plans.layout import Cell, Style
from fpnet_core.sim.plans.roughen import roughen
from fpnet_core.sim.types import BuildingPlan

Family = Callable[[np.random.Generator, Style], BuildingPlan]


def _from_cells(name: str, layout: Callable[[np.random.Generator, Style], list[Cell]]) -> Family:
    """Wrap a layout of cells: roughen it as people do over the years, then build it."""

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

FAMILIES: dict[str, Family] = {
    **{layout.__name__: _from_cells(layout.__name__, layout) for layout in _LAYOUTS},
    'mirrored': composed.mirrored,
    'turned': composed.turned,
    'disconnected': composed.disconnected,
}
"""Every layout family by name."""

ROOM_TO_ROOM = (0.0, 0.0, 0.04, 0.15, 0.5, 0.85)
"""Shares of neighbouring rooms that are joined directly: most buildings few, some nearly all."""

DOOR_HABITS_M = (0.8, 0.9, 0.9, 0.95, 0.95, 1.0, 1.4)
"""Door widths of buildings whose doors are all alike."""

MAX_ROOMS = 90
_ATTEMPTS = 60


def generate_plan(
    rng: np.random.Generator,
    family: str | None = None,
    min_rooms: int = 8,
    max_rooms: int = MAX_ROOMS,
) -> BuildingPlan:
    """
    Return a random storey in which every room can be reached (but 'disconnected' has two parts).

    Parameters
    ----------
    rng : source of all randomness; equal generators give equal plans
    family : a key of :data:`FAMILIES`; None draws one
    min_rooms, max_rooms : bounds of the number of rooms, corridors included

    Raises
    ------
    ConfigError
        If the family is unknown or does not reach the wanted number of rooms.
    """
    if family is not None and family not in FAMILIES:
        raise ConfigError(f'unknown family {family!r}; choose one of {", ".join(FAMILIES)}')
    for _ in range(_ATTEMPTS):
        name = family if family is not None else str(rng.choice(list(FAMILIES)))
        style = draw_style(rng)
        plan = FAMILIES[name](rng, style)
        if min_rooms <= len(plan.rooms) <= max_rooms:
            return plan
    raise ConfigError(
        f'no {family or "random"} plan with {min_rooms} to {max_rooms} rooms in {_ATTEMPTS} '
        'attempts; widen the bounds'
    )


def draw_style(rng: np.random.Generator) -> Style:
    """Draw the habits of one building's architect."""
    is_uniform = bool(rng.random() < 0.15)
    return Style(
        wall_m=float(rng.choice([0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.35])),
        room_side_m=float(5.6 * np.exp(0.15 * rng.standard_normal())),
        spread=float(rng.uniform(0.15, 0.45)),
        is_uniform=is_uniform,
        room_to_room=float(rng.choice(ROOM_TO_ROOM)),
        second_door=float(rng.uniform(0.1, 0.5)),
        door_width_m=float(rng.choice(DOOR_HABITS_M)) if rng.random() < 0.4 else None,
    )
