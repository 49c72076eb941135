# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Kinds of sheets, their traits with frequencies, and their drawing styles."""

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
    """Origin of a sheet."""

    CLEAN = 'clean'  # a bare plan, as for a robot
    OFFICE = 'office'  # plotted from CAD
    BROCHURE = 'brochure'  # coloured by room or department
    SCAN = 'scan'  # paper on a scanner
    PHONE = 'phone'  # paper photographed with a phone
    VARIED = 'varied'  # any combination of components, on screen or on paper


STANDARD_KINDS = (
    SheetKind.CLEAN,
    SheetKind.OFFICE,
    SheetKind.BROCHURE,
    SheetKind.SCAN,
    SheetKind.PHONE,
)
"""Kinds reported by benchmarks of drawings."""


class Trait(StrEnum):
    """Optional elements of a sheet beside walls and doors."""

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
    BACKDROP = 'backdrop'  # coloured background around the building
    INVERTED = 'inverted'
    TRANSPARENT = 'transparent'
    ANY_ANGLE = 'any angle'


# Shares of sheets with a trait, and of wall and door styles; chosen to resemble sheets of
# architects and universities, not fitted.
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
"""Fonts that are shipped with matplotlib, so that sheets are reproducible everywhere."""

FINEST_PX = 0.9
"""Minimum pen width in pixels, like the minimum line width of printers. Chosen."""

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
    Drawing style of one sheet.

    Parameters
    ----------
    kind : kind on paper, before scanning
    traits : optional elements
    walls, doors : styles of walls and doors
    ink : colour of walls
    line : colour of all thin lines
    letters : colour of texts
    outer_m : thickness of outer walls
    denominator : denominator of the scale
    resolution_m : edge of a pixel
    font : font of all texts
    letter_mm : capital height of room texts on paper
    interior : components inside the building; None for standard ones
    surround : components around the building; None for standard ones
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
        """Convert millimetres on paper to metres in the building."""
        return 1e-3 * on_paper * self.denominator

    def pen(
        self, on_paper_mm: float, colour: Colour | None = None, dashes_mm: tuple[float, ...] = ()
    ) -> Pen:
        """Return a pen with a width in mm on paper, by default in the sheet's line colour."""
        finest_m = FINEST_PX * self.resolution_m
        dashes = tuple(self.mm(length) for length in dashes_mm)
        return Pen(colour or self.line, max(self.mm(on_paper_mm), finest_m), dashes)

    @property
    def letter_m(self) -> float:
        """Capital height of room texts [m]."""
        return max(self.mm(self.letter_mm), MIN_LETTER_PX * self.resolution_m)


WALL_PEN_MM, THIN_PEN_MM, FAINT_PEN_MM = 0.35, 0.18, 0.09
"""Line widths on paper. Chosen."""

MIN_LETTER_PX = 7.0
"""Minimum height of legible capitals. Chosen."""

# Chosen, not measured:
_LONG_SIDE_PX = (1200.0, 3500.0)
_RESOLUTIONS_M = (0.01, 0.1)


def draw_look(rng: np.random.Generator, kind: SheetKind, extent_m: float) -> Look:
    """
    Sample the style of a sheet of a kind for a building with longer side ``extent_m``.

    For scans and phone pictures, this is the style of the paper.
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
    if walls == 'thin' or doors == 'gap':  # a line across the opening would look like a wall
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
    """Combine the traits of a random standard kind with independently sampled components."""
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
    """Sample the colours of walls and of thin lines."""
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
    """Sample a usual scale for the building's size; return its denominator."""
    usual = (50, 100) if extent_m < 25.0 else (100, 200) if extent_m < 70.0 else (200, 500)
    return int(usual[int(rng.random() < 0.5)])


def with_room_for(look: Look, long_side_m: float) -> Look:
    """Return the look with a pixel size that gives the sheet a usual number of pixels."""
    pixels = long_side_m / look.resolution_m
    resolution_m = long_side_m / float(np.clip(pixels, *_LONG_SIDE_PX))
    return replace(look, resolution_m=float(np.clip(resolution_m, *_RESOLUTIONS_M)))


def _resolution_m(rng: np.random.Generator, long_side_m: float, is_paper: bool) -> float:
    """Sample the edge of a pixel [m]; scans and phone pictures have higher resolutions."""
    low, high = np.log(_LONG_SIDE_PX)
    pixels = float(np.exp(rng.uniform(low + (0.4 if is_paper else 0.0), high)))
    return float(np.clip(long_side_m / pixels, *_RESOLUTIONS_M))
