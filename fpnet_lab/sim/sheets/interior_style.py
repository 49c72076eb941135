# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random styles of components inside the building of a varied sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fpnet_lab.sim.sheets.artwork import Colour

DoorKind = Literal[
    'gap', 'leaf', 'arc', 'arc only', 'sliding', 'pocket', 'folding', 'both ways', 'closed'
]
WallKind = Literal['as look', 'solid', 'pale', 'coloured', 'outlined', 'hatched', 'cavity']
WindowKind = Literal['lines', 'sill', 'filled', 'mullions', 'gap']
FloorKind = Literal['solid', 'hatch', 'squares', 'bricks', 'herringbone', 'dots', 'gradient']
TagFrame = Literal['none', 'box', 'ellipse', 'leader']

# Chosen, not measured:
DOOR_KINDS: tuple[DoorKind, ...] = (
    'gap',
    'leaf',
    'arc',
    'arc only',
    'sliding',
    'pocket',
    'folding',
    'both ways',
    'closed',
)
_DOOR_SHARES = (0.1, 0.16, 0.28, 0.06, 0.16, 0.06, 0.06, 0.06, 0.06)
WALL_KINDS: tuple[WallKind, ...] = (
    'as look',
    'solid',
    'pale',
    'coloured',
    'outlined',
    'hatched',
    'cavity',
)
_WALL_SHARES = (0.3, 0.2, 0.14, 0.1, 0.12, 0.07, 0.07)
_WINDOW_KINDS: tuple[WindowKind, ...] = ('lines', 'sill', 'filled', 'mullions', 'gap')
_WINDOW_SHARES = (0.5, 0.15, 0.13, 0.15, 0.07)
_FLOOR_KINDS: tuple[FloorKind, ...] = (
    'solid',
    'hatch',
    'squares',
    'bricks',
    'herringbone',
    'dots',
    'gradient',
)
_FLOOR_SHARES = (0.36, 0.16, 0.14, 0.12, 0.06, 0.08, 0.08)
_TAG_FRAMES: tuple[TagFrame, ...] = ('none', 'box', 'ellipse', 'leader')
_TAG_SHARES = (0.6, 0.16, 0.12, 0.12)

ROOM_SYMBOLS: dict[str, float] = {
    'desks': 0.3,
    'wall to wall': 0.2,
    'cubicles': 0.15,
    'seats': 0.2,
    'racks': 0.2,
    'beds': 0.2,
    'bath': 0.3,
    'kitchen': 0.25,
    'cars': 0.1,
    'pots': 0.15,
    'machines': 0.2,
    'table': 0.3,
    'straight stairs': 0.3,
    'turning stairs': 0.25,
    'spiral stairs': 0.15,
    'ramp': 0.1,
    'escalator': 0.08,
    'lift': 0.3,
    'void': 0.15,
    'ceiling': 0.1,
    'beams': 0.12,
    'sprinklers': 0.12,
    'shaft': 0.2,
    'across room': 0.35,
    'in doorway': 0.15,
    'chain': 0.3,
    'icons': 0.15,
}
"""Symbols and texts of single rooms, with shares of sheets that show them; chosen."""

STOREY_SYMBOLS: dict[str, float] = {
    'columns': 0.25,
    'escape': 0.15,
    'routes': 0.12,
    'sections': 0.12,
    'wires': 0.12,
    'furniture': 0.25,
}
"""Symbols that extend over a storey, with shares of sheets that show them; chosen."""


@dataclass(frozen=True)
class DoorPaint:
    """
    Style of some of a sheet's doors.

    ``angle_rad`` is the opening angle of a leaf, ``sills`` the number of lines across the
    opening, ``slab_m`` a leaf's thickness (0: a line); ``colour`` None is the sheet's line colour.
    """

    kind: DoorKind
    angle_rad: float
    sills: int
    slab_m: float
    is_filled: bool
    pen_mm: float
    has_dashes: bool
    colour: Colour | None


@dataclass(frozen=True)
class WallPaint:
    """Style of outer or inner walls: their fill, and the pen of their outlines."""

    kind: WallKind
    colour: Colour
    pen_mm: float
    hatch_mm: float
    hatch_rad: float


@dataclass(frozen=True)
class WindowPaint:
    """
    Style and size of windows.

    Panes cover at most ``share`` of an edge, with a maximum length of ``longest_m`` and gaps of
    ``gap_m``; ``lines`` is the number of lines between the wall's faces.
    """

    kind: WindowKind
    lines: int
    colour: Colour | None
    share: float
    longest_m: float
    gap_m: float
    mullion_m: float


@dataclass(frozen=True)
class FloorPaint:
    """Floor style of a share of the rooms; ``inset_m`` is the width of the empty rim."""

    kind: FloorKind
    share: float
    colours: tuple[Colour, ...]
    pen: Colour
    pitch_m: float
    angle_rad: float
    inset_m: float


@dataclass(frozen=True)
class TagStyle:
    """Style of room labels: their ``lines``, script, unit, size, rotation, frame and colour."""

    lines: tuple[str, ...]
    script: str
    unit: int
    scale: float
    angle_rad: float
    frame: TagFrame
    share: float
    colour: Colour | None


@dataclass(frozen=True)
class FurniturePaint:
    """Fill and pen of furniture; None means no fill, or the sheet's line colour."""

    fill: Colour | None
    colour: Colour | None
    pen_mm: float


@dataclass(frozen=True)
class InteriorStyle:
    """
    Style of the components inside a sheet's building.

    ``seed`` is the seed of random choices shared by drawing and ground truth, ``separator`` the
    light colour of inner walls between filled rooms, ``has_lines`` whether inner walls are single
    lines, ``glass_share`` the share of rooms with glass walls, and ``has_lengths`` whether
    dimensions have a text.
    """

    seed: int
    doors: tuple[DoorPaint, ...]
    outer: WallPaint
    inner: WallPaint
    has_lines: bool
    has_thin_outer: bool
    separator: Colour | None
    glass_share: float
    glass: Colour
    windows: WindowPaint
    entrances: int
    floors: tuple[FloorPaint, ...]
    tags: TagStyle | None
    furniture: tuple[FurniturePaint, ...]
    room_symbols: tuple[str, ...]
    storey_symbols: tuple[str, ...]
    density: float
    length_unit: int
    arrow: int
    dimension_mm: float
    has_lengths: bool


def draw_interior_style(rng: np.random.Generator) -> InteriorStyle:
    """Sample a combination of components."""
    outer = _wall_paint(rng)
    separator = _light(rng) if rng.random() < 0.14 else None
    return InteriorStyle(
        seed=int(rng.integers(2**31)),
        doors=tuple(_door_paint(rng) for _ in range(int(rng.choice(3, p=(0.5, 0.3, 0.2))) + 1)),
        outer=outer,
        inner=outer if rng.random() < 0.45 else _wall_paint(rng),
        has_lines=bool(rng.random() < 0.25),
        has_thin_outer=bool(rng.random() < (0.5 if separator else 0.1)),
        separator=separator,
        glass_share=float(rng.uniform(0.05, 0.4)) if rng.random() < 0.2 else 0.0,
        glass=hue_colour(rng, 0.7, 0.6) if rng.random() < 0.5 else (0.4, 0.4, 0.4),
        windows=_window_paint(rng),
        entrances=int(rng.integers(0, 5)),
        floors=tuple(_floor_paint(rng) for _ in range(int(rng.choice(3, p=(0.5, 0.3, 0.2))))),
        tags=_tag_style(rng) if rng.random() < 0.7 else None,
        furniture=tuple(_furniture_paint(rng) for _ in range(int(rng.integers(1, 4)))),
        room_symbols=tuple(n for n, share in ROOM_SYMBOLS.items() if rng.random() < share),
        storey_symbols=tuple(n for n, share in STOREY_SYMBOLS.items() if rng.random() < share),
        density=float(rng.uniform(0.15, 0.95)),
        length_unit=int(rng.integers(6)),
        arrow=int(rng.integers(4)),
        dimension_mm=float(rng.uniform(0.1, 0.35)),
        has_lengths=bool(rng.random() < 0.75),
    )


def hue_colour(rng: np.random.Generator, depth: float, value: float) -> Colour:
    """Sample a colour of random hue with saturation ``depth`` and brightness ``value``."""
    angles = (rng.random() + np.arange(3) / 3.0) * 2.0 * np.pi
    r, g, b = (value * (1.0 - depth * (0.5 + 0.5 * np.cos(angles)))).tolist()
    return (r, g, b)


def grey(value: float) -> Colour:
    """Return a grey from 0 (black) to 1 (white)."""
    return (value, value, value)


def _light(rng: np.random.Generator) -> Colour:
    return (1.0, 1.0, 1.0) if rng.random() < 0.8 else grey(float(rng.uniform(0.93, 1.0)))


def _any_colour(rng: np.random.Generator) -> Colour:
    return hue_colour(rng, float(rng.uniform(0.5, 1.0)), float(rng.uniform(0.4, 0.9)))


def _door_paint(rng: np.random.Generator) -> DoorPaint:
    quarter, eighth = np.pi / 2.0, np.pi / 4.0
    angle = (quarter, eighth, float(rng.uniform(0.2, 1.5)), np.pi)
    return DoorPaint(
        kind=DOOR_KINDS[int(rng.choice(len(DOOR_KINDS), p=_DOOR_SHARES))],
        angle_rad=float(angle[int(rng.choice(4, p=(0.6, 0.14, 0.2, 0.06)))]),
        sills=int(rng.choice(3, p=(0.65, 0.17, 0.18))),
        slab_m=float(rng.uniform(0.03, 0.12)) if rng.random() < 0.35 else 0.0,
        is_filled=bool(rng.random() < 0.5),
        pen_mm=float(rng.uniform(0.1, 0.5)),
        has_dashes=bool(rng.random() < 0.15),
        colour=_any_colour(rng) if rng.random() < 0.2 else None,
    )


def _wall_paint(rng: np.random.Generator) -> WallPaint:
    kind = WALL_KINDS[int(rng.choice(len(WALL_KINDS), p=_WALL_SHARES))]
    light = grey(float(rng.uniform(0.5, 0.85)))
    colour = hue_colour(rng, float(rng.uniform(0.3, 1.0)), float(rng.uniform(0.5, 0.95)))
    if kind == 'pale' and rng.random() < 0.8:
        colour = light
    return WallPaint(
        kind,
        colour,
        float(rng.uniform(0.12, 0.5)),
        float(rng.uniform(1.0, 3.0)),
        float(rng.choice([np.pi / 4.0, -np.pi / 4.0, np.pi / 3.0])),
    )


def _window_paint(rng: np.random.Generator) -> WindowPaint:
    blue = (
        float(rng.uniform(0.1, 0.6)),
        float(rng.uniform(0.4, 0.85)),
        float(rng.uniform(0.7, 1)),
    )
    is_long = rng.random() < 0.3
    return WindowPaint(
        kind=_WINDOW_KINDS[int(rng.choice(len(_WINDOW_KINDS), p=_WINDOW_SHARES))],
        lines=int(rng.integers(1, 4)),
        colour=blue if rng.random() < 0.3 else None,
        share=float(rng.uniform(0.85, 0.97) if is_long else rng.uniform(0.3, 0.8)),
        longest_m=float(rng.uniform(4.0, 50.0) if is_long else rng.uniform(0.8, 3.5)),
        gap_m=float(rng.uniform(0.2, 1.5)),
        mullion_m=float(rng.uniform(0.6, 1.6)),
    )


def _floor_paint(rng: np.random.Generator) -> FloorPaint:
    count = int(rng.integers(1, 6))
    depth, value = float(rng.uniform(0.1, 0.9)), float(rng.uniform(0.75, 1.0))
    if rng.random() < 0.2:
        value = float(rng.uniform(0.35, 0.75))
    colours = tuple(hue_colour(rng, depth, value) for _ in range(count))
    if rng.random() < 0.3:
        colours = tuple(grey(float(rng.uniform(0.55, 0.95))) for _ in range(count))
    pen = grey(float(rng.uniform(0.2, 0.85)))
    return FloorPaint(
        kind=_FLOOR_KINDS[int(rng.choice(len(_FLOOR_KINDS), p=_FLOOR_SHARES))],
        share=float(rng.uniform(0.1, 1.0)),
        colours=colours,
        pen=pen if rng.random() < 0.7 else hue_colour(rng, 0.6, 0.85),
        pitch_m=float(np.exp(rng.uniform(np.log(0.12), np.log(0.9)))),
        angle_rad=float(rng.choice([0.0, np.pi / 4.0, -np.pi / 4.0, np.pi / 2.0])),
        inset_m=float(rng.uniform(0.05, 0.4)) if rng.random() < 0.25 else 0.0,
    )


def _tag_style(rng: np.random.Generator) -> TagStyle:
    kinds = ('number', 'name', 'area', 'size')
    chosen = tuple(
        k for k, p in zip(kinds, (0.5, 0.5, 0.4, 0.25), strict=True) if rng.random() < p
    )
    scripts = ('latin', 'accents', 'cyrillic', 'greek')
    turned = float(rng.choice([np.pi / 2.0, rng.uniform(-np.pi, np.pi)]))
    return TagStyle(
        lines=chosen or ('number',),
        script=scripts[int(rng.choice(4, p=(0.5, 0.25, 0.15, 0.1)))],
        unit=int(rng.integers(6)),
        scale=float(rng.uniform(0.6, 1.5)),
        angle_rad=turned if rng.random() < 0.15 else 0.0,
        frame=_TAG_FRAMES[int(rng.choice(len(_TAG_FRAMES), p=_TAG_SHARES))],
        share=float(rng.uniform(0.4, 1.0)),
        colour=_any_colour(rng) if rng.random() < 0.2 else None,
    )


def _furniture_paint(rng: np.random.Generator) -> FurniturePaint:
    fill = hue_colour(rng, float(rng.uniform(0.1, 0.8)), float(rng.uniform(0.5, 1.0)))
    if rng.random() < 0.5:
        fill = grey(float(rng.uniform(0.25, 0.95)))
    return FurniturePaint(
        fill=fill if rng.random() < 0.45 else None,
        colour=_any_colour(rng) if rng.random() < 0.2 else None,
        pen_mm=float(rng.uniform(0.08, 0.35)),
    )
