# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawing styles of storeys."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fpnet_core.config import Section

Walls = Literal['solid', 'thin', 'thick', 'double']
DoorMark = Literal['gap', 'leaf', 'arc']
Sills = Literal[0, 1, 2]

MAX_SEED = 2**31  # numerical


@dataclass(frozen=True)
class DrawingStyle:
    """
    Style of one drawing.

    Parameters
    ----------
    walls : filled, one thin line, filled and thick, or an outline
    doors : a gap only, an open leaf, or a leaf with its swing arc
    hatching : diagonal strokes between the two lines of outlined walls
    windows : three parallel lines in outer walls
    furniture : outlines of desks, tables, cabinets and chairs
    text : room numbers, names and areas
    dimensions : dimension lines along two sides of the building
    white_paper : the outside is free like the rooms; otherwise it is unknown
    seed : seed of the furniture and the texts
    sills : number of threshold lines from jamb to jamb: one in mid-wall, or two at its faces
    """

    walls: Walls = 'solid'
    doors: DoorMark = 'gap'
    hatching: bool = False
    windows: bool = False
    furniture: bool = False
    text: bool = False
    dimensions: bool = False
    white_paper: bool = False
    seed: int = 0
    sills: Sills = 0


CLEAN = DrawingStyle()
"""A bare occupancy grid."""

STYLES: dict[str, DrawingStyle] = {
    'clean': CLEAN,
    'thin': DrawingStyle(walls='thin'),
    'thick': DrawingStyle(walls='thick', doors='leaf'),
    'double': DrawingStyle(walls='double', windows=True),
    'sketch': DrawingStyle(walls='double', doors='arc', hatching=True, white_paper=True),
    'sills': DrawingStyle(walls='thick', doors='arc', sills=1, windows=True),
    'furnished': DrawingStyle(furniture=True, windows=True),
    'lettered': DrawingStyle(walls='thin', doors='leaf', text=True, white_paper=True),
    'architect': DrawingStyle(
        'double', 'arc', windows=True, furniture=True, text=True, dimensions=True, white_paper=True
    ),
}
"""Named styles for the command line and the gallery. Chosen."""


class StyleConfig(Section):
    """Shares of drawings with a trait; the others are drawn without it."""

    thin_walls: float = Field(0.15, ge=0.0, le=1.0, description='Walls are one thin line.')
    thick_walls: float = Field(0.15, ge=0.0, le=1.0, description='Walls are filled and thick.')
    double_walls: float = Field(0.08, ge=0.0, le=1.0, description='Walls are two lines.')
    hatching: float = Field(0.5, ge=0.0, le=1.0, description='Share of two-line walls hatched.')
    door_leaves: float = Field(0.1, ge=0.0, le=1.0, description='Doors show their open leaf.')
    door_arcs: float = Field(0.05, ge=0.0, le=1.0, description='Doors show leaf and arc.')
    windows: float = Field(0.2, ge=0.0, le=1.0, description='Outer walls show windows.')
    furniture: float = Field(0.12, ge=0.0, le=1.0, description='Rooms show furniture.')
    text: float = Field(0.15, ge=0.0, le=1.0, description='Rooms are lettered.')
    dimensions: float = Field(0.05, ge=0.0, le=1.0, description='Two sides are dimensioned.')
    white_paper: float = Field(0.2, ge=0.0, le=1.0, description='The outside is white.')

    @model_validator(mode='after')
    def _are_shares(self) -> Self:
        if self.thin_walls + self.thick_walls + self.double_walls > 1.0:
            raise ValueError('thin_walls, thick_walls and double_walls must not exceed 1 together')
        if self.door_leaves + self.door_arcs > 1.0:
            raise ValueError('door_leaves and door_arcs must not exceed 1 together')
        return self


def draw_style(rng: np.random.Generator, config: StyleConfig) -> DrawingStyle:
    """Sample the style of one drawing, with independent traits."""
    kinds: tuple[Walls, ...] = ('thin', 'thick', 'double')
    marks: tuple[DoorMark, ...] = ('leaf', 'arc')
    walls = _pick(rng, (config.thin_walls, config.thick_walls, config.double_walls))
    doors = _pick(rng, (config.door_leaves, config.door_arcs))
    hatching, windows, furniture, text, dimensions, white = (
        bool(rng.random() < share)
        for share in (
            config.hatching,
            config.windows,
            config.furniture,
            config.text,
            config.dimensions,
            config.white_paper,
        )
    )
    return DrawingStyle(
        walls='solid' if walls is None else kinds[walls],
        doors='gap' if doors is None else marks[doors],
        hatching=hatching,
        windows=windows,
        furniture=furniture,
        text=text,
        dimensions=dimensions,
        white_paper=white,
        seed=int(rng.integers(MAX_SEED)),
    )


def _pick(rng: np.random.Generator, shares: tuple[float, ...]) -> int | None:
    """Sample an index with probabilities ``shares``, or None with the remaining probability."""
    found = int(np.searchsorted(np.cumsum(shares), rng.random(), side='right'))
    return found if found < len(shares) else None
