# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What kinds of sheets people have, and how often they show what."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Literal

import numpy as np

from fpnet_lab.sim.drawn.styles import DoorMark
from fpnet_lab.sim.sheets.artwork import Colour, Pen
from fpnet_lab.sim.sheets.interior_style import InteriorStyle, draw_interior_style
from fpnet_lab.sim.sheets.surround_style import SurroundStyle, draw_surround_style

WallLook = Literal['solid', 'thin', 'outlined', 'hatched', 'tinted']


class SheetKind(StrEnum):
    """Where a sheet is from."""

    CLEAN = 'clean'  # a bare plan, as for a robot
    OFFICE = 'office'  # plotted from CAD
    BROCHURE = 'brochure'  # coloured by room or department
    SCAN = 'scan'  # paper on a scanner
    PHONE = 'phone'  # paper under a phone
    VARIED = 'varied'  # any combination of components, on screen or on paper


STANDARD_KINDS = (
    SheetKind.CLEAN,
    SheetKind.OFFICE,
    SheetKind.BROCHURE,
    SheetKind.SCAN,
    SheetKind.PHONE,
)
"""The kinds that benchmarks of drawings report."""


class Trait(StrEnum):
    """What a sheet may show beside walls and doors."""

    WINDOWS = 'windows'
    THRESHOLDS = 'thresholds'
    COLUMNS = 'columns'
    STAIRS = 'stairs'
    TILES = 'tiles'
    OVERHEAD = 'overhead'  # dashed: beams, the roof's edge
    FURNITURE = 'furniture'
    TEXTS = 'texts'
    DIMENSIONS = 'dimensions'
    AXES = 'axes'
    FILLS = 'fills'
    PATTERNS = 'patterns'
    ARROWS = 'arrows'
    SITE = 'site'
    FRAME = 'frame'
    TITLE = 'title'
    LEGEND = 'legend'
    NORTH = 'north'
    SCALE_BAR = 'scale bar'
    TWO_STOREYS = 'two storeys'
    BACKDROP = 'backdrop'  # coloured ground around the building
    INVERTED = 'inverted'
    TRANSPARENT = 'transparent'
    ANY_ANGLE = 'any angle'


# Shares of sheets with a trait, and of looks of walls and doors, chosen to look like the sheets
# that architects and universities hand out; no figure was fitted.
_SHARES: dict[SheetKind, dict[Trait, float]] = {
    SheetKind.CLEAN: {
        Trait.WINDOWS: 0.2,
        Trait.TEXTS: 0.15,
        Trait.FURNITURE: 0.1,
        Trait.COLUMNS: 0.1,
        Trait.INVERTED: 0.1,
        Trait.TRANSPARENT: 0.15,
        Trait.ANY_ANGLE: 0.1,
    },
    SheetKind.OFFICE: {
        Trait.WINDOWS: 0.85,
        Trait.THRESHOLDS: 0.15,
        Trait.COLUMNS: 0.25,
        Trait.STAIRS: 0.8,
        Trait.TILES: 0.12,
        Trait.OVERHEAD: 0.25,
        Trait.FURNITURE: 0.55,
        Trait.TEXTS: 0.9,
        Trait.DIMENSIONS: 0.6,
        Trait.AXES: 0.25,
        Trait.FILLS: 0.1,
        Trait.ARROWS: 0.3,
        Trait.SITE: 0.35,
        Trait.FRAME: 0.75,
        Trait.TITLE: 0.8,
        Trait.LEGEND: 0.25,
        Trait.NORTH: 0.5,
        Trait.SCALE_BAR: 0.4,
        Trait.TWO_STOREYS: 0.1,
        Trait.INVERTED: 0.06,
        Trait.TRANSPARENT: 0.05,
        Trait.ANY_ANGLE: 0.1,
    },
    SheetKind.BROCHURE: {
        Trait.WINDOWS: 0.4,
        Trait.COLUMNS: 0.1,
        Trait.STAIRS: 0.8,
        Trait.FURNITURE: 0.2,
        Trait.TEXTS: 0.9,
        Trait.FILLS: 1.0,
        Trait.PATTERNS: 0.35,
        Trait.ARROWS: 0.6,
        Trait.SITE: 0.2,
        Trait.FRAME: 0.25,
        Trait.TITLE: 0.9,
        Trait.LEGEND: 0.85,
        Trait.NORTH: 0.4,
        Trait.SCALE_BAR: 0.25,
        Trait.TWO_STOREYS: 0.12,
        Trait.BACKDROP: 0.3,
        Trait.TRANSPARENT: 0.08,
        Trait.ANY_ANGLE: 0.15,
    },
}

# Chosen, not measured:
_WALLS: dict[SheetKind, tuple[float, ...]] = {
    SheetKind.CLEAN: (0.6, 0.15, 0.15, 0.05, 0.05),
    SheetKind.OFFICE: (0.4, 0.1, 0.2, 0.15, 0.15),
    SheetKind.BROCHURE: (0.7, 0.2, 0.05, 0.0, 0.05),
}
_DOORS: dict[SheetKind, tuple[float, ...]] = {
    SheetKind.CLEAN: (0.6, 0.2, 0.2),
    SheetKind.OFFICE: (0.05, 0.1, 0.85),
    SheetKind.BROCHURE: (0.5, 0.2, 0.3),
}
_PAPER_KINDS: dict[SheetKind, tuple[tuple[SheetKind, ...], tuple[float, ...]]] = {
    SheetKind.SCAN: ((SheetKind.OFFICE, SheetKind.BROCHURE, SheetKind.CLEAN), (0.65, 0.2, 0.15)),
    SheetKind.PHONE: ((SheetKind.OFFICE, SheetKind.BROCHURE, SheetKind.CLEAN), (0.4, 0.4, 0.2)),
}
_WALL_LOOKS: tuple[WallLook, ...] = ('solid', 'thin', 'outlined', 'hatched', 'tinted')
_DOOR_LOOKS: tuple[DoorMark, ...] = ('gap', 'leaf', 'arc')

FONTS = ('DejaVu Sans', 'DejaVu Serif', 'DejaVu Sans Mono', 'STIXGeneral')
"""Those that come with matplotlib, so that a seed gives the same sheet everywhere."""

FINEST_PX = 0.9
"""No pen is finer than so many pixels: printers and plotters have a finest line, too. Chosen."""

# Chosen, not measured:
_DARK: tuple[Colour, ...] = (
    (0.10, 0.16, 0.38),
    (0.36, 0.10, 0.10),
    (0.12, 0.30, 0.16),
    (0.30, 0.20, 0.12),
    (0.05, 0.35, 0.42),
    (0.42, 0.16, 0.40),
)
_MAX_WALL_GREY = 140 / 255
_BLACK_SHARE, _COLOURED_SHARE = 0.4, 0.15
_NO_PRINTS = (Trait.INVERTED, Trait.TRANSPARENT)  # paper is white


@dataclass(frozen=True)
class Look:
    """
    How one sheet is drawn.

    Parameters
    ----------
    kind : as on paper, before anybody scanned it
    traits : what it shows
    walls, doors : how they are drawn
    ink : of walls
    line : of everything else that is thin
    letters : of texts
    outer_m : thickness of outer walls
    denominator : the paper is to the building as 1 to this
    resolution_m : of a pixel
    font : of all texts
    letter_mm : height of a room's capitals on paper
    interior : components drawn within the building; None for standard ones
    surround : components drawn around the building; None for standard ones
    """

    kind: SheetKind
    traits: frozenset[Trait]
    walls: WallLook
    doors: DoorMark
    ink: Colour
    line: Colour
    letters: Colour
    outer_m: float
    denominator: int
    resolution_m: float
    font: str
    letter_mm: float
    interior: InteriorStyle | None = None
    surround: SurroundStyle | None = None

    def mm(self, on_paper: float) -> float:
        """Return what so many millimetres on paper are in the building [m]."""
        return 1e-3 * on_paper * self.denominator

    def pen(
        self, on_paper_mm: float, colour: Colour | None = None, dashes_mm: tuple[float, ...] = ()
    ) -> Pen:
        """Return a pen of so many millimetres on paper, in the sheet's line colour by default."""
        finest_m = FINEST_PX * self.resolution_m
        dashes = tuple(self.mm(length) for length in dashes_mm)
        return Pen(colour or self.line, max(self.mm(on_paper_mm), finest_m), dashes)

    @property
    def letter_m(self) -> float:
        """Height of a room's capitals [m]."""
        return max(self.mm(self.letter_mm), MIN_LETTER_PX * self.resolution_m)


WALL_PEN_MM, THIN_PEN_MM, FAINT_PEN_MM = 0.35, 0.18, 0.09
"""Widths of lines on paper. Chosen."""

MIN_LETTER_PX = 7.0
"""Smaller capitals cannot be read by people. Chosen."""

# Chosen, not measured:
_LONG_SIDE_PX = (1200.0, 3500.0)
_RESOLUTIONS_M = (0.01, 0.1)


def draw_look(rng: np.random.Generator, kind: SheetKind, extent_m: float) -> Look:
    """
    Draw how a sheet of a kind shows a building whose longer side is ``extent_m``.

    Of scans and phone pictures this is the look of the paper.
    """
    if kind is SheetKind.VARIED:
        return _varied_look(rng, extent_m)
    is_paper = kind in _PAPER_KINDS
    if is_paper:
        kinds, shares = _PAPER_KINDS[kind]
        kind = kinds[int(rng.choice(len(kinds), p=shares))]
    traits = {trait for trait, share in _SHARES[kind].items() if rng.random() < share}
    if is_paper:
        traits -= {*_NO_PRINTS}
    ink, line = _draw_inks(rng, kind)
    walls = _WALL_LOOKS[int(rng.choice(5, p=_WALLS[kind]))]
    doors = _DOOR_LOOKS[int(rng.choice(3, p=_DOORS[kind]))]
    if walls == 'thin' or doors == 'gap':  # a line across the opening would be a wall
        traits -= {Trait.THRESHOLDS}
    return Look(
        kind=kind,
        traits=frozenset(traits),
        walls=walls,
        doors=doors,
        ink=ink,
        line=line,
        letters=line if rng.random() < 0.6 else (0.0, 0.0, 0.0),
        outer_m=float(rng.uniform(0.25, 0.5)),
        denominator=_denominator(rng, extent_m),
        resolution_m=_resolution_m(rng, extent_m, is_paper),
        font=str(rng.choice(FONTS, p=(0.55, 0.15, 0.1, 0.2))),
        letter_mm=float(rng.uniform(1.8, 3.5)),
    )


def _varied_look(rng: np.random.Generator, extent_m: float) -> Look:
    """Mix the traits of a random standard kind with components drawn one by one."""
    kinds = (SheetKind.CLEAN, SheetKind.OFFICE, SheetKind.BROCHURE)
    look = draw_look(rng, kinds[int(rng.integers(len(kinds)))], extent_m)
    traits = set(look.traits)
    for other in kinds:
        traits |= {t for t, share in _SHARES[other].items() if rng.random() < 0.35 * share}
    return replace(
        look,
        traits=frozenset(traits),
        walls=_WALL_LOOKS[int(rng.integers(len(_WALL_LOOKS)))],
        interior=draw_interior_style(rng),
        surround=draw_surround_style(rng),
    )


def _draw_inks(rng: np.random.Generator, kind: SheetKind) -> tuple[Colour, Colour]:
    """Draw the colours of walls and of thin lines."""
    picks = rng.random(2)
    grey = float(rng.uniform(0.0, _MAX_WALL_GREY))
    dark = _DARK[int(rng.integers(len(_DARK)))]
    ink = (grey, grey, grey)
    if picks[0] < _BLACK_SHARE:
        ink = (0.0, 0.0, 0.0)
    elif picks[0] > 1.0 - _COLOURED_SHARE * (1.0 if kind is not SheetKind.OFFICE else 0.4):
        ink = dark
    lighter = float(rng.uniform(0.0, 0.35)) if picks[1] < 0.6 else 0.0
    line = tuple(c + lighter * (1.0 - c) for c in ink)
    return ink, (line[0], line[1], line[2])


def _denominator(rng: np.random.Generator, extent_m: float) -> int:
    """Return the usual scale at which a building fits on paper."""
    usual = (50, 100) if extent_m < 25.0 else (100, 200) if extent_m < 70.0 else (200, 500)
    return int(usual[int(rng.random() < 0.5)])


def with_room_for(look: Look, long_side_m: float) -> Look:
    """Return the look with pixels of such a size that a sheet has a usual number of them."""
    pixels = long_side_m / look.resolution_m
    resolution_m = long_side_m / float(np.clip(pixels, *_LONG_SIDE_PX))
    return replace(look, resolution_m=float(np.clip(resolution_m, *_RESOLUTIONS_M)))


def _resolution_m(rng: np.random.Generator, long_side_m: float, is_paper: bool) -> float:
    """Draw the edge of a pixel: people export at any size, scanners and phones at good ones."""
    low, high = np.log(_LONG_SIDE_PX)
    pixels = float(np.exp(rng.uniform(low + (0.4 if is_paper else 0.0), high)))
    return float(np.clip(long_side_m / pixels, *_RESOLUTIONS_M))
