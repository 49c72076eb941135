# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Page elements around a building: frame, title block, legend, north arrow, scale bar, site."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_lab.sim.sheets.artwork import (
    Area,
    Array,
    Box,
    Letters,
    Lines,
    Mark,
    Pen,
    Role,
    box_ring,
    circles,
    lines_of,
)
from fpnet_lab.sim.sheets.colouring import Departments
from fpnet_lab.sim.sheets.lettering import LETTER_ASPECT
from fpnet_lab.sim.sheets.looks import Look
from fpnet_lab.sim.sheets.storeys import arrow_head

TITLE_MM = (120.0, 45.0)
"""Width and height of a title block. Chosen."""
LEGEND_ROW_MM = 8.0
LEGEND_MM = 60.0
"""Row height and width of a legend. Chosen."""
FRAME_MM = 8.0
"""Distance of the frame from the paper's edge. Chosen."""

_PROJECTS = ('New Laboratory', 'Institute of Physics', 'Town Hall', 'School Annex', 'Clinic West')
_STOREYS = ('Ground floor', '1st floor', '2nd floor', 'Basement', 'Erdgeschoss', '1. Obergeschoss')
_OFFICES = ('Meyer + Partner', 'Studio Nord', 'Baubüro Süd', 'A. Rossi Architetti', 'Plan 4')
# Chosen, not measured:
_BAR_STEPS_M = (0.0, 1.0, 2.0, 5.0, 10.0)
_SITE_DASHES_MM = (6.0, 2.0, 1.0, 2.0)
_CLEAR_M = 1.0  # distance of site lines from the building


def frame_marks(size_m: tuple[float, float], look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return one or two rectangles along the paper's edge."""
    width, height = size_m
    marks: list[Mark] = []
    for inset_mm, pen_mm in ((FRAME_MM, 0.7), (FRAME_MM / 2.0, 0.18))[: int(rng.integers(1, 3))]:
        inset = look.mm(inset_mm)
        ring = box_ring((inset, inset, width - inset, height - inset))
        marks += lines_of(Role.SHEET, [ring], look.pen(pen_mm), is_closed=True)
    return marks


def storey_name(rng: np.random.Generator) -> str:
    """Sample a storey's name."""
    return str(rng.choice(_STOREYS))


def title_block(box: Box, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return a title block with project, storey, scale, date and office."""
    left, bottom, right, top = box
    rows = [
        str(rng.choice(_PROJECTS)),
        storey_name(rng),
        f'Scale 1:{look.denominator}',
        '{:02d}.{:02d}.20{:02d}'.format(*rng.integers((1, 1, 5), (29, 13, 26)).tolist()),
        f'{rng.choice(_OFFICES)}  A-{int(rng.integers(100, 400))}',
    ]
    edges = np.linspace(top, bottom, len(rows) + 1)
    split = left + 0.3 * (right - left)
    lines = [np.array([(left, y), (right, y)]) for y in edges[1:-1]]
    lines.append(np.array([(split, bottom), (split, float(edges[1]))]))
    marks = lines_of(Role.SHEET, [box_ring(box)], look.pen(0.5), is_closed=True)
    marks += lines_of(Role.SHEET, lines, look.pen(0.18))
    row_m = (top - bottom) / len(rows)
    for i, text in enumerate(rows):
        y = float(edges[i]) - row_m / 2.0
        start = left if i == 0 else split
        marks.append(_fitted(text, (start, y), 0.9 * (right - start), 0.45 * row_m, look, i == 0))
        if i:
            note = ('Plan', 'Scale', 'Date', 'Office')[i - 1]
            marks.append(_fitted(note, (left, y), 0.26 * (right - left), 0.3 * row_m, look))
    return marks


def _fitted(
    text: str,
    left: tuple[float, float],
    width_m: float,
    height_m: float,
    look: Look,
    is_bold: bool = False,
) -> Letters:
    """Return a text starting slightly right of ``left``, at most ``width_m`` long."""
    height = min(height_m, width_m / (len(text) * LETTER_ASPECT))
    xy = (left[0] + 0.5 * height, left[1])
    return Letters(
        Role.SHEET, text, xy, height, look.letters, look.font, align='left', is_bold=is_bold
    )


def headline(box: Box, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return a brochure's headline."""
    left, bottom, right, top = box
    text = f'{rng.choice(_PROJECTS)} - {storey_name(rng)}'
    return [
        _fitted(text, (left, (bottom + top) / 2.0), right - left, 0.5 * (top - bottom), look, True)
    ]


def legend_marks(box: Box, departments: Departments | None, look: Look) -> list[Mark]:
    """Return labelled swatches, from the top of the box downwards."""
    left, _, right, top = box
    row = look.mm(LEGEND_ROW_MM)
    marks: list[Mark] = []
    for i, name in enumerate(legend_names(departments)):
        y = top - (i + 0.5) * row
        swatch = box_ring((left, y - 0.3 * row, left + 1.2 * row, y + 0.3 * row))
        if departments is not None:
            marks.append(Area(Role.SHEET, (swatch,), departments.colours[i]))
        marks += lines_of(Role.SHEET, [swatch], look.pen(0.18), is_closed=True)
        marks.append(
            _fitted(name, (left + 1.3 * row, y), right - left - 1.5 * row, 0.35 * row, look)
        )
    return marks


def legend_names(departments: Departments | None) -> Sequence[str]:
    """Return the entries of a legend."""
    return departments.names if departments is not None else ('Walls', 'Partitions', 'Glass')


def north_arrow(
    centre: Array, radius_m: float, look: Look, rng: np.random.Generator
) -> list[Mark]:
    """Return a circle with an arrow in a random direction and the letter N."""
    angle = float(rng.uniform(0.0, 2.0 * np.pi))
    up, side = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    tip, back = centre + radius_m * up, centre - 0.7 * radius_m * up
    needle = np.stack([tip, back + 0.4 * radius_m * side, back, back - 0.4 * radius_m * side])
    half = Area(Role.SHEET, (needle[:3],), look.letters)
    letter = (centre + 1.35 * radius_m * up).tolist()
    return [
        circles(Role.SHEET, centre, 0.8 * radius_m, look.pen(0.18)),
        half,
        Lines(Role.SHEET, (needle,), look.pen(0.18), is_closed=True),
        Letters(Role.SHEET, 'N', (letter[0], letter[1]), 0.35 * radius_m, look.letters, look.font),
    ]


def scale_bar(corner: Array, look: Look) -> list[Mark]:
    """Return a 10 m scale bar with numbers and its lower left at ``corner`` (2,)."""
    x, y = corner.tolist()
    height = look.mm(1.5)
    pen = look.pen(0.18)
    letter = max(look.mm(2.0), 0.8 * look.letter_m)
    marks: list[Mark] = []
    for i, (a, b) in enumerate(pairwise(_BAR_STEPS_M)):
        ring = box_ring((x + a, y, x + b, y + height))
        if i % 2 == 0:
            marks.append(Area(Role.SHEET, (ring,), look.letters))
        marks += lines_of(Role.SHEET, [ring], pen, is_closed=True)
    for step in _BAR_STEPS_M:
        text = f'{step:.0f} m' if step == _BAR_STEPS_M[-1] else f'{step:.0f}'
        at = (x + step, y + height + letter)
        marks.append(Letters(Role.SHEET, text, at, letter, look.letters, look.font))
    return marks


SCALE_BAR_M = _BAR_STEPS_M[-1]
"""Length of the scale bar [m]."""


def site_marks(built: BaseGeometry, area: Box, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return contours, trees, a boundary and a path, clipped to the outside of the building."""
    around = shapely.difference(shapely.box(*area), shapely.buffer(built, _CLEAR_M))
    marks: list[Mark] = []
    if rng.random() < 0.8:
        contours = [_contour(area, rng) for _ in range(int(rng.integers(3, 9)))]
        marks += lines_of(Role.SITE, _clipped(contours, around), look.pen(0.13))
    if rng.random() < 0.7:
        ring = box_ring(area) + rng.normal(0.0, 0.02, (4, 2)) * (area[2] - area[0])
        pen = look.pen(0.35, dashes_mm=_SITE_DASHES_MM)
        marks += lines_of(Role.SITE, _clipped([np.vstack([ring, ring[:1]])], around), pen)
    if rng.random() < 0.7:
        marks += _trees(around, area, look, rng)
    if rng.random() < 0.5:
        marks += _path(built, around, area, look, rng)
    return marks


def _contour(area: Box, rng: np.random.Generator) -> Array:
    """Return a wavy line (V, 2) across the sheet."""
    left, bottom, right, top = area
    t = np.linspace(0.0, 1.0, 80)
    wave = sum(
        rng.normal(0.0, 0.08 / k) * np.sin(2.0 * np.pi * (k * t + rng.random())) for k in (1, 2, 3)
    )
    across = rng.random() + wave + rng.normal(0.0, 0.3) * (t - 0.5)
    x, y = (t, across) if rng.random() < 0.5 else (across, t)
    return np.stack([left + (right - left) * x, bottom + (top - bottom) * y], axis=1)


def _clipped(lines: list[Array], shape: BaseGeometry) -> list[Array]:
    """Return the parts of lines inside a shape."""
    parts = shapely.get_parts(
        shapely.intersection(
            shapely.linestrings(
                np.concatenate(lines),
                indices=np.repeat(np.arange(len(lines)), [len(line) for line in lines]),
            ),
            shape,
        )
    )
    return [shapely.get_coordinates(p) for p in parts if p.geom_type == 'LineString']


def _trees(around: BaseGeometry, area: Box, look: Look, rng: np.random.Generator) -> list[Mark]:
    count = int(rng.integers(4, 25))
    centres = rng.uniform(area[:2], area[2:], (count, 2))
    radii = rng.uniform(0.8, 2.2, count)
    stands = shapely.contains(around, shapely.buffer(shapely.points(centres), radii))
    if not stands.any():
        return []
    pen = look.pen(0.13)
    trunks = circles(Role.SITE, centres[stands], 0.15, pen)
    return [circles(Role.SITE, centres[stands], radii[stands], pen), trunks]


def _path(
    built: BaseGeometry, around: BaseGeometry, area: Box, look: Look, rng: np.random.Generator
) -> list[Mark]:
    """Return a path from the paper's edge to the building, with joints and an arrow."""
    x = float(rng.uniform(built.bounds[0], built.bounds[2]))
    half = float(rng.uniform(0.9, 2.0))
    lines = [np.array([(x + s * half, area[1]), (x + s * half, built.bounds[3])]) for s in (-1, 1)]
    joints = np.arange(area[1], built.bounds[1], 1.2)
    lines += [np.array([(x - half, y), (x + half, y)]) for y in joints]
    start, end = np.array([x, area[1]]), np.array([x, built.bounds[1] - _CLEAR_M])
    marks = lines_of(Role.SITE, _clipped(lines, around), look.pen(0.13))
    tip = [np.stack([start, end]), *arrow_head(start, end, look.mm(4.0))]
    return marks + lines_of(Role.SITE, tip, Pen(look.line, look.pen(0.35).width_m))
