# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A sheet as vector marks on paper, independent of the output format: pixels, PDF, SVG or DXF.

Frame ``page``: true metres at the drawing's scale, x right, y up, origin at the lower left corner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fpnet_lab.sim.drawn.symbols import ticked

Array = NDArray[np.float64]
Colour = tuple[float, float, float]
"""Red, green and blue from 0 to 1."""

Box = tuple[float, float, float, float]
"""Left, bottom, right and top [m, page]."""


class Role(StrEnum):
    """Meaning of a mark; a vector file has one layer per role."""

    WALL = 'wall'
    WALL_PATTERN = 'wall pattern'
    DOOR = 'door'
    WINDOW = 'window'
    STAIRS = 'stairs'
    FURNITURE = 'furniture'
    FILL = 'fill'
    TEXT = 'text'
    DIMENSION = 'dimension'
    AXIS = 'axis'
    SITE = 'site'
    SHEET = 'sheet'  # frame, title block, legend, north arrow, scale bar


@dataclass(frozen=True)
class Pen:
    """Colour, width [m], and dash and gap lengths [m] of a line."""

    colour: Colour
    width_m: float
    dashes_m: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Lines:
    """Polylines (V, 2) [m]; with ``is_closed``, the last point connects to the first."""

    role: Role
    lines: tuple[Array, ...]
    pen: Pen
    is_closed: bool = False


@dataclass(frozen=True, eq=False)
class Arcs:
    """
    Circular arcs, counter-clockwise.

    ``centre (N, 2)`` and ``radius (N,)`` [m], ``span (N, 2)`` start and end angles [rad].
    """

    role: Role
    centre: Array
    radius: Array
    span: Array
    pen: Pen


@dataclass(frozen=True, eq=False)
class Area:
    """A filled polygon of ``rings (V, 2)`` [m]: outlines counter-clockwise, holes clockwise."""

    role: Role
    rings: tuple[Array, ...]
    colour: Colour


@dataclass(frozen=True)
class Letters:
    """
    A line of text at ``xy`` [m] with capital height ``height_m``, rotated by ``angle_rad``.

    ``align`` is the anchor of the text at ``xy``: its centre or its left end.
    """

    role: Role
    text: str
    xy: tuple[float, float]
    height_m: float
    colour: Colour
    font: str
    angle_rad: float = 0.0
    align: str = 'center'
    is_bold: bool = False


@dataclass(frozen=True)
class Dimension:
    """
    A dimension with its text, between the ends ``a`` and ``b`` of its line [m].

    ``feet`` is the vector of the extension lines towards the measured object [m], ``tick_m`` the
    size of the strokes across the line's ends. ``text`` is empty if it does not fit.
    """

    a: tuple[float, float]
    b: tuple[float, float]
    feet: tuple[float, float]
    text: str
    height_m: float
    tick_m: float
    pen: Pen
    colour: Colour
    font: str
    role: Role = Role.DIMENSION


Stroke = Lines | Arcs | Area | Letters
Mark = Stroke | Dimension


@dataclass(frozen=True, eq=False)
class Artwork:
    """
    All marks of a sheet in drawing order.

    ``size_m`` is the paper's width and height at the drawing's scale of 1 to ``denominator``;
    ``paper`` is None if it is transparent.
    """

    size_m: tuple[float, float]
    denominator: int
    marks: tuple[Mark, ...]
    paper: Colour | None = (1.0, 1.0, 1.0)

    @property
    def strokes(self) -> list[Stroke]:
        """All marks decomposed into lines, arcs, areas and texts."""
        return [stroke for mark in self.marks for stroke in strokes_of(mark)]

    @property
    def size_mm(self) -> tuple[float, float]:
        """Physical width and height of the paper [mm]."""
        width, height = (1e3 * side / self.denominator for side in self.size_m)
        return width, height


def circles(role: Role, centre: Array, radius_m: float | Array, pen: Pen) -> Arcs:
    """Return full circles around ``centre (N, 2)`` [m]."""
    centre = np.asarray(centre, np.float64).reshape(-1, 2)
    radius = np.broadcast_to(np.asarray(radius_m, np.float64), len(centre)).copy()
    return Arcs(role, centre, radius, np.tile([0.0, 2.0 * np.pi], (len(centre), 1)), pen)


def strokes_of(mark: Mark) -> list[Stroke]:
    """Return the strokes of a mark: lines and text of a dimension, otherwise the mark itself."""
    if not isinstance(mark, Dimension):
        return [mark]
    a, b, feet = (np.array(point) for point in (mark.a, mark.b, mark.feet))
    along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
    across = np.array([-along[1], along[0]])
    lines = ticked(np.stack([a, b]), mark.tick_m)
    lines += [np.stack([end, end + feet]) for end in (a, b)]
    strokes: list[Stroke] = [Lines(mark.role, tuple(lines), mark.pen)]
    if mark.text:
        x, y = ((a + b) / 2.0 + 0.9 * mark.height_m * across).tolist()
        angle = float(np.arctan2(along[1], along[0]))
        strokes.append(
            Letters(mark.role, mark.text, (x, y), mark.height_m, mark.colour, mark.font, angle)
        )
    return strokes


def box_ring(box: Box) -> Array:
    """Return a box's corners (4, 2), counter-clockwise."""
    left, bottom, right, top = box
    return np.array([(left, bottom), (right, bottom), (right, top), (left, top)])


def lines_of(role: Role, lines: Sequence[Array], pen: Pen, is_closed: bool = False) -> list[Mark]:
    """Return the lines as one mark, or no mark if there are no lines."""
    return [Lines(role, tuple(lines), pen, is_closed)] if len(lines) else []


def inverted(artwork: Artwork) -> Artwork:
    """Return artwork with light ink on dark paper."""
    paper = artwork.paper or (1.0, 1.0, 1.0)
    return replace(
        artwork, paper=_opposite(paper), marks=tuple(_inverted(mark) for mark in artwork.marks)
    )


def _inverted(mark: Mark) -> Mark:
    if isinstance(mark, Area | Letters):
        return replace(mark, colour=_opposite(mark.colour))
    if isinstance(mark, Dimension):
        return replace(mark, colour=_opposite(mark.colour), pen=_inverted_pen(mark.pen))
    return replace(mark, pen=_inverted_pen(mark.pen))


def _inverted_pen(pen: Pen) -> Pen:
    return replace(pen, colour=_opposite(pen.colour))


def _opposite(colour: Colour) -> Colour:
    r, g, b = (1.0 - value for value in colour)
    return r, g, b
