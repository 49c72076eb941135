# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layout of storeys, colours, texts and surroundings on one sheet of paper."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from fpnet_core.geometry import SE2
from fpnet_lab.sim.sheets import page
from fpnet_lab.sim.sheets.artwork import (
    Area,
    Array,
    Artwork,
    Box,
    Colour,
    Letters,
    Mark,
    Role,
    box_ring,
    inverted,
)
from fpnet_lab.sim.sheets.colouring import (
    Departments,
    arrow_marks,
    draw_departments,
    fill_marks,
)
from fpnet_lab.sim.sheets.details import detail_marks
from fpnet_lab.sim.sheets.interior import interior_letters, interior_marks
from fpnet_lab.sim.sheets.lettering import (
    axis_marks,
    axis_space_m,
    dimension_marks,
    dimension_space_m,
    room_letters,
)
from fpnet_lab.sim.sheets.looks import Look, Trait
from fpnet_lab.sim.sheets.storeys import PlacedStorey, drawn_wall_m, storey_marks
from fpnet_lab.sim.types import BuildingPlan

# Chosen, not measured:
_GAP_MM = 12.0  # between elements of the sheet
_CAPTION_MM = 10.0
_BACKDROP_MM = 8.0
_SITE_MM = 45.0


@dataclass(frozen=True)
class Beside:
    """An element beside the building: its name ``what`` and its ``box`` [m, page]."""

    what: str
    box: Box


@dataclass(frozen=True, eq=False)
class Layout:
    """A composed sheet: its marks, the storeys and the elements beside them."""

    artwork: Artwork
    storeys: tuple[PlacedStorey, ...]
    beside: tuple[Beside, ...]


@dataclass
class _Sheet:
    """A sheet during composition: its style, and the marks and elements drawn so far."""

    look: Look
    rng: np.random.Generator
    marks: list[Mark]
    beside: list[Beside]

    def has(self, trait: Trait) -> bool:
        return trait in self.look.traits

    def add(self, marks: list[Mark], what: str = '', box: Box | None = None) -> None:
        self.marks += marks
        if box is not None:
            self.beside.append(Beside(what, box))


def compose(
    plans: tuple[BuildingPlan, ...],
    look: Look,
    rng: np.random.Generator,
    *,
    is_blank: bool = False,
) -> Layout:
    """
    Lay out storeys side by side or one above the other, with their surroundings.

    Parameters
    ----------
    plans : one or two storeys
    look : drawing style
    rng : random generator of positions, names and colours
    is_blank : omit the marks, if only the size is needed

    Returns
    -------
    Layout with the sheet's lower left corner at the origin of frame ``page``
    """
    turn = _draw_turn(look, rng)
    storeys = _place(plans, turn, look, rng)
    lower, upper = _bounds(storeys)
    column_m = _column_m(look)
    low = lower - _space_m(look, is_low=True)
    high = upper + _space_m(look, is_low=False) + np.array([column_m, 0.0])
    least = (float(high[0] - low[0]), float(high[1] - low[1]))
    size = _whole_pixels(_minimum_size(least, look, rng), look.resolution_m)
    spare = (np.array(size) - least) * rng.uniform(0.3, 0.7, 2)
    storeys = tuple(_moved(storey, spare - low) for storey in storeys)
    sheet = _Sheet(look, rng, [], [])
    if not is_blank:
        _draw_all(sheet, storeys, size, column_m)
    artwork = Artwork(size, look.denominator, tuple(sheet.marks), _paper(look, rng))
    if Trait.INVERTED in look.traits:
        artwork = inverted(artwork)
    return Layout(artwork, storeys, tuple(sheet.beside))


def _draw_turn(look: Look, rng: np.random.Generator) -> float:
    if Trait.ANY_ANGLE in look.traits:
        return float(rng.uniform(-np.pi, np.pi))
    return float(rng.integers(4)) * np.pi / 2.0


def _place(
    plans: tuple[BuildingPlan, ...], turn: float, look: Look, rng: np.random.Generator
) -> tuple[PlacedStorey, ...]:
    """Return the storeys, arranged in a row or a column by the lower left of their bounds."""
    placed: list[PlacedStorey] = []
    at = np.zeros(2)
    axis = int(rng.integers(2))
    for plan in plans:
        storey = PlacedStorey(plan, SE2.from_xy_yaw(0.0, 0.0, turn), drawn_wall_m(plan, look))
        low, high = storey.on_page.extent
        placed.append(_moved(storey, at - low))
        gap = dimension_space_m(look) if Trait.DIMENSIONS in look.traits else 0.0
        at[axis] += high[axis] - low[axis] + 2.0 * look.outer_m + gap + look.mm(2.0 * _GAP_MM)
    return tuple(placed)


def _moved(storey: PlacedStorey, by: Array) -> PlacedStorey:
    T = SE2.from_xy_yaw(float(by[0]), float(by[1]), 0.0) @ storey.T_page_building
    return replace(storey, T_page_building=T)


def _bounds(storeys: tuple[PlacedStorey, ...]) -> tuple[Array, Array]:
    extents = np.stack([storey.on_page.extent for storey in storeys])
    return extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)


def _column_m(look: Look) -> float:
    """Return the width of the right-hand column for title block and legend [m]."""
    if not look.traits & {Trait.TITLE, Trait.LEGEND, Trait.NORTH}:
        return 0.0
    is_office = Trait.TITLE in look.traits and look.kind != 'brochure'
    return look.mm((page.TITLE_MM[0] if is_office else page.LEGEND_MM) + _GAP_MM)


def _space_m(look: Look, is_low: bool) -> Array:
    """Return the space (2,) [m] left of and below a building, or right of and above it."""
    space = look.outer_m + look.mm(page.FRAME_MM + _GAP_MM)
    if look.kind == 'clean':
        space = look.outer_m + 1.0
    wide = np.full(2, space)
    if Trait.SITE in look.traits:
        wide += look.mm(_SITE_MM)
    if Trait.DIMENSIONS in look.traits and is_low:
        wide += dimension_space_m(look)
    if Trait.AXES in look.traits and not is_low:
        wide += axis_space_m(look)
    if Trait.SCALE_BAR in look.traits and is_low:
        wide[1] += look.mm(10.0)
    if Trait.TITLE in look.traits and look.kind == 'brochure' and not is_low:
        wide[1] += look.mm(16.0)
    return wide


def _minimum_size(
    size: tuple[float, float], look: Look, rng: np.random.Generator
) -> tuple[float, float]:
    """Return a size that fits title block and legend, often with a paper aspect ratio."""
    width, height = size
    if _column_m(look):
        height = max(height, look.mm(110.0))
    if look.kind != 'clean' and rng.random() < 0.5:
        height = max(height, width / np.sqrt(2.0) if width > height else height)
        width = max(width, height / np.sqrt(2.0))
    return width, height


def _whole_pixels(size: tuple[float, float], resolution_m: float) -> tuple[float, float]:
    width, height = (float(np.ceil(side / resolution_m)) * resolution_m for side in size)
    return width, height


def _draw_all(
    sheet: _Sheet,
    storeys: tuple[PlacedStorey, ...],
    size: tuple[float, float],
    column_m: float,
) -> None:
    look, rng = sheet.look, sheet.rng
    built = shapely.union_all([storey.shell(look.outer_m) for storey in storeys])
    inset = look.mm(page.FRAME_MM) if sheet.has(Trait.FRAME) else 0.0
    inner = (inset, inset, size[0] - inset - column_m, size[1] - inset)
    if sheet.has(Trait.BACKDROP):
        _backdrop(sheet, storeys)
    if sheet.has(Trait.SITE):
        sheet.add(page.site_marks(built, inner, look, rng))
    departments = draw_departments(storeys[0], look, rng) if sheet.has(Trait.FILLS) else None
    for number, storey in enumerate(storeys):
        if departments is not None:
            mine = departments if number == 0 else _other_rooms(storey, departments, look, rng)
            sheet.add(fill_marks(storey, mine, look, rng))
        draw = storey_marks if look.interior is None else interior_marks
        sheet.add(draw(storey, look, rng))
        sheet.add(detail_marks(storey, look, rng))
        _write(sheet, storey, len(storeys) > 1)
    _surround(sheet, storeys, departments, size, column_m)


def _other_rooms(
    storey: PlacedStorey, departments: Departments, look: Look, rng: np.random.Generator
) -> Departments:
    """Return another storey's room owners for the same departments."""
    other = draw_departments(storey, look, rng)
    owners = np.where(other.of_room < 0, -1, other.of_room % len(departments.names))
    return replace(departments, of_room=owners)


def _backdrop(sheet: _Sheet, storeys: tuple[PlacedStorey, ...]) -> None:
    """Draw a pale background under and around the building."""
    margin = sheet.look.mm(_BACKDROP_MM)
    low, high = _bounds(storeys)
    (left, bottom), (right, top) = low - margin, high + margin
    r, g, b = sheet.rng.uniform(0.85, 0.97, 3).tolist()
    ring = box_ring((float(left), float(bottom), float(right), float(top)))
    sheet.add([Area(Role.FILL, (ring,), (r, g, b))])


def _write(sheet: _Sheet, storey: PlacedStorey, has_caption: bool) -> None:
    """Draw the texts, dimensions, axes, arrows and caption of one storey."""
    look, rng = sheet.look, sheet.rng
    if look.interior is not None:
        sheet.add(interior_letters(storey, look, rng))
    if sheet.has(Trait.TEXTS) and (look.interior is None or look.interior.tags is None):
        sheet.add(room_letters(storey, look, rng))
    if sheet.has(Trait.DIMENSIONS):
        sheet.add(dimension_marks(storey, look, rng))
    if sheet.has(Trait.AXES):
        sheet.add(axis_marks(storey, look))
    if sheet.has(Trait.ARROWS):
        sheet.add(arrow_marks(storey, look, rng))
    if has_caption:
        (left, _), (_, top) = storey.on_page.extent
        height = look.mm(_CAPTION_MM) / 3.0
        xy = (float(left), float(top) + look.outer_m + 2.0 * height)
        text = page.storey_name(rng)
        sheet.add([Letters(Role.TEXT, text, xy, height, look.letters, look.font, align='left')])


def _surround(
    sheet: _Sheet,
    storeys: tuple[PlacedStorey, ...],
    departments: Departments | None,
    size: tuple[float, float],
    column_m: float,
) -> None:
    """Draw frame, title, legend, north arrow and scale bar in the space left by the layout."""
    look, rng = sheet.look, sheet.rng
    edge = look.mm(page.FRAME_MM)
    low, _ = _bounds(storeys)
    if sheet.has(Trait.FRAME):
        sheet.add(page.frame_marks(size, look, rng), 'frame', (0.0, 0.0, *size))
    right, left = size[0] - edge, size[0] - edge - column_m + look.mm(_GAP_MM / 2.0)
    if sheet.has(Trait.TITLE) and look.kind == 'brochure':
        box = (edge, size[1] - edge - look.mm(12.0), right, size[1] - edge)
        sheet.add(page.headline(box, look, rng), 'title', box)
    elif sheet.has(Trait.TITLE):
        box = (right - look.mm(page.TITLE_MM[0]), edge, right, edge + look.mm(page.TITLE_MM[1]))
        sheet.add(page.title_block(box, look, rng), 'title block', box)
    top = size[1] - edge - look.mm(24.0)
    if sheet.has(Trait.LEGEND):
        rows = len(page.legend_names(departments)) * look.mm(page.LEGEND_ROW_MM)
        box = (left, top - rows, right, top)
        sheet.add(page.legend_marks(box, departments, look), 'legend', box)
        top -= rows + look.mm(_GAP_MM)
    if sheet.has(Trait.NORTH):
        radius = look.mm(9.0)
        x, y = left + 2.0 * radius, top - 2.0 * radius
        box = (x - 1.6 * radius, y - 1.6 * radius, x + 1.6 * radius, y + 1.6 * radius)
        sheet.add(page.north_arrow(np.array([x, y]), radius, look, rng), 'north arrow', box)
    if sheet.has(Trait.SCALE_BAR):
        x, y = float(low[0]), edge + look.mm(3.0)
        box = (x - 1.0, y, x + page.SCALE_BAR_M + 2.0, y + look.mm(4.0) + 2.0 * look.letter_m)
        sheet.add(page.scale_bar(np.array([x, y]), look), 'scale bar', box)


def _paper(look: Look, rng: np.random.Generator) -> Colour | None:
    if Trait.TRANSPARENT in look.traits:
        return None
    if rng.random() < 0.8:
        return (1.0, 1.0, 1.0)
    r, g, b = rng.uniform(0.92, 1.0, 3).tolist()
    return (r, g, b)
