# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Furniture catalogue for simulated worlds and for drawings.

Every piece consists of a few upright boxes (a table is a top and four legs), so that low beams
pass below tables and between chair legs as in real buildings. One catalogue serves 3D lidars,
planar scanners, which measure one slice, and drawings, which show pieces from above.
:mod:`fpnet_lab.sim.buildings.furnishing` places the pieces.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_lab.sim.buildings.meshes import TriangleMesh, extrude_polygon, merge_meshes

Array = NDArray[np.float64]

_LEG_M = 0.05  # chosen

# Given: corners of a box in units of its half sides.
_CORNERS = np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])


@dataclass(frozen=True, eq=False)
class Boxes:
    """Upright boxes: ``centre (B, 2)``, ``half (B, 2)`` [m], ``yaw (B,)``, ``span (B, 2)`` [m]."""

    centre: Array
    half: Array
    yaw: Array
    span: Array

    @property
    def columns(self) -> tuple[Array, Array, Array, Array]:
        """Centres, half sides, angles and vertical spans."""
        return self.centre, self.half, self.yaw, self.span

    @property
    def rings(self) -> Array:
        """Outlines (B, 4, 2) on the floor [m]."""
        x, y = np.moveaxis(self.half[:, None] * _CORNERS, 2, 0)
        c, s = np.cos(self.yaw)[:, None], np.sin(self.yaw)[:, None]
        return np.asarray(np.stack([c * x - s * y, s * x + c * y], axis=2) + self.centre[:, None])

    def met_at(self, height_m: float) -> list[Array]:
        """Return the outlines (4, 2) of the boxes that span a height [m]."""
        return list(self.rings[(self.span[:, 0] <= height_m) & (height_m <= self.span[:, 1])])

    def from_above(self) -> Array:
        """Return the outlines (F, 4, 2) of all boxes wider than a leg."""
        return np.asarray(self.rings[self.half.min(axis=1) > _LEG_M])

    def moved(self, xy: Array, yaw_rad: Array | float) -> Boxes:
        """Return the boxes with their common or individual origins at ``xy``, rotated."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        x, y = self.centre.T
        centre = np.stack([c * x - s * y, s * x + c * y], axis=1) + xy
        return Boxes(centre, self.half, self.yaw + yaw_rad, self.span)

    def mesh(self) -> TriangleMesh:
        """Return the surface mesh of all boxes."""
        return merge_meshes(
            [
                extrude_polygon(Polygon(ring), bottom_m, top_m)
                for ring, (bottom_m, top_m) in zip(self.rings, self.span.tolist(), strict=True)
            ]
        )


def joined(groups: Sequence[Boxes]) -> Boxes:
    """Return the boxes of all groups as one group."""
    if not groups:
        return Boxes(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2)))
    columns = zip(*(group.columns for group in groups), strict=True)
    return Boxes(*(np.concatenate(column) for column in columns))


@dataclass(frozen=True, eq=False)
class FurniturePiece:
    """
    One piece, for example a table with its chairs [m].

    Its last ``rounded`` boxes are drawn as circles.
    """

    kind: str
    boxes: Boxes
    rounded: int = 0

    @cached_property
    def footprint(self) -> Polygon:
        """Convex hull of the boxes' outlines on the floor."""
        return shapely.convex_hull(shapely.multipoints(self.boxes.rings.reshape(-1, 2)))

    @property
    def rings(self) -> Array:
        """Distinct outlines (F, 4, 2) of the symbol: boxes wider than a leg that are not round."""
        cornered = len(self.boxes.yaw) - self.rounded
        boxes = Boxes(*(column[:cornered] for column in self.boxes.columns))
        return np.unique(boxes.from_above(), axis=0)

    @property
    def discs(self) -> Array:
        """Circles (N, 3) of the symbol: x, y and radius [m]."""
        first = len(self.boxes.yaw) - self.rounded
        return np.concatenate([self.boxes.centre, self.boxes.half[:, :1]], axis=1)[first:]

    def moved(self, xy: Array, yaw_rad: float) -> FurniturePiece:
        """Return the piece with its origin at ``xy (2,)``, rotated by ``yaw_rad``."""
        return replace(self, boxes=self.boxes.moved(xy, yaw_rad))


Maker = Callable[[np.random.Generator], FurniturePiece]
"""Function that samples a piece in the piece's frame."""


@dataclass(frozen=True, eq=False)
class Stock:
    """Furniture of rooms up to ``most_m2``: ``makers`` of pieces, and the share of each."""

    makers: tuple[Maker, ...]
    shares: tuple[float, ...]
    most_m2: float = np.inf

    @cached_property
    def _up_to(self) -> Array:
        summed = np.cumsum(self.shares)
        return np.asarray(summed / summed[-1])

    def draw(self, rng: np.random.Generator) -> FurniturePiece:
        """Sample a piece in the piece's frame."""
        # Equivalent to Generator.choice, but ten times faster.
        return self.makers[int(np.searchsorted(self._up_to, rng.random(), 'right'))](rng)


Box = tuple[float, float, float, float, float, float]
"""Corner x and y, width, depth, bottom and top [m]."""


def _piece(kind: str, *boxes: Box, rounded: int = 0) -> FurniturePiece:
    rows = np.array(boxes)
    half = rows[:, 2:4] / 2.0
    placed = Boxes(rows[:, :2] + half, half, np.zeros(len(rows)), rows[:, 4:])
    return FurniturePiece(kind, placed, rounded)


def _disc(x: float, y: float, radius: float, bottom: float, top: float) -> Box:
    """Return the bounding box of a disc with centre (x, y)."""
    return (x - radius, y - radius, 2.0 * radius, 2.0 * radius, bottom, top)


def _legs(x: float, y: float, width: float, depth: float, top: float) -> list[Box]:
    """Return four legs at the corners of a base with lower corner (x, y) [m]."""
    columns, rows = (x, x + width - _LEG_M), (y, y + depth - _LEG_M)
    return [(cx, cy, _LEG_M, _LEG_M, 0.0, top) for cx in columns for cy in rows]


def _chair(x: float, y: float, faces_up: bool) -> list[Box]:
    """Return a chair centred at (x, y), facing +y or -y."""
    size, seat_m, back_m = 0.45, 0.45, 0.9
    x0, y0 = x - size / 2.0, y - size / 2.0
    back_y = y0 if faces_up else y0 + size - _LEG_M
    return [
        *_legs(x0, y0, size, size, seat_m - 0.04),
        (x0, y0, size, size, seat_m - 0.04, seat_m),
        (x0, back_y, size, _LEG_M, seat_m, back_m),
    ]


# The makers below sample one piece in its own frame: x along the wall, y into the room, origin at
# the middle of its back; a table's origin is its centre.


def _cabinet(rng: np.random.Generator, deepest_m: float = 0.6) -> FurniturePiece:
    width, depth = rng.uniform(0.8, 1.8), rng.uniform(0.3, deepest_m)
    height = rng.uniform(0.8, 2.1)
    return _piece('cabinet', (-width / 2.0, 0.0, width, depth, 0.0, height))


def corridor_cabinet(rng: np.random.Generator) -> FurniturePiece:
    """Sample a cabinet shallow enough for corridors."""
    return _cabinet(rng, deepest_m=0.45)


def fixture(rng: np.random.Generator) -> FurniturePiece:
    """Sample a radiator, a notice board or a fire extinguisher."""
    width, depth, bottom = rng.uniform(0.25, 1.4), rng.uniform(0.06, 0.2), rng.uniform(0.0, 1.2)
    top = bottom + rng.uniform(0.4, 1.0)
    return _piece('fixture', (-width / 2.0, 0.0, width, depth, bottom, top))


def _shelf(rng: np.random.Generator) -> FurniturePiece:
    width, height = rng.uniform(0.8, 2.4), rng.uniform(1.7, 2.2)
    boards = [(-width / 2.0, 0.0, width, 0.3, z, z + 0.03) for z in np.arange(0, height, 0.4)]
    sides = [(x, 0.0, 0.03, 0.3, 0.0, height) for x in (-width / 2.0, width / 2.0 - 0.03)]
    return _piece('shelf', *boards, *sides, (-width / 2.0, 0.0, width, 0.02, 0.0, height))


def _desk(rng: np.random.Generator) -> FurniturePiece:
    width, depth, height = rng.uniform(1.2, 1.8), rng.uniform(0.7, 0.85), rng.uniform(0.7, 0.76)
    x0 = -width / 2.0
    return _piece(
        'desk',
        *_legs(x0, 0.0, width, depth, height - 0.03),
        (x0, 0.0, width, depth, height - 0.03, height),
        (x0 + 0.06, 0.1, 0.4, depth - 0.15, 0.05, height - 0.05),
        (rng.uniform(-0.3, 0.0), 0.1, 0.55, 0.06, height, height + 0.4),
        *_chair(rng.uniform(-0.1, 0.3), depth + rng.uniform(0.0, 0.3), faces_up=False),
    )


def _sofa(rng: np.random.Generator) -> FurniturePiece:
    width, depth = rng.uniform(1.4, 2.3), rng.uniform(0.8, 0.95)
    return _piece(
        'sofa',
        (-width / 2.0, 0.0, width, depth, 0.0, 0.42),
        (-width / 2.0, 0.0, width, 0.2, 0.42, rng.uniform(0.75, 0.95)),
    )


def _bed(rng: np.random.Generator) -> FurniturePiece:
    width = rng.uniform(0.9, 1.8)
    return _piece(
        'bed',
        (-width / 2.0, 0.0, width, 0.05, 0.0, rng.uniform(0.8, 1.1)),
        (-width / 2.0, 0.05, width, 2.0, 0.15, 0.5),
    )


def _table(rng: np.random.Generator) -> FurniturePiece:
    width, depth = rng.uniform(1.2, 2.2), rng.uniform(0.8, 1.1)
    x0, y0 = -width / 2.0, -depth / 2.0
    solids = [*_legs(x0, y0, width, depth, 0.71), (x0, y0, width, depth, 0.71, 0.75)]
    for x in np.linspace(-width / 2.0, width / 2.0, int(width / 0.6) + 2)[1:-1]:
        for side in (-1.0, 1.0):
            if rng.random() < 0.7:
                y = side * (depth / 2.0 + rng.uniform(0.0, 0.3))
                solids += _chair(float(x), y, faces_up=side < 0.0)
    return _piece('table', *solids)


def _toilet(_rng: np.random.Generator) -> FurniturePiece:
    cistern, seat = (-0.2, 0.0, 0.4, 0.18, 0.0, 0.9), (-0.15, 0.18, 0.3, 0.2, 0.0, 0.42)
    return _piece('toilet', cistern, seat, _disc(0.0, 0.42, 0.19, 0.0, 0.42), rounded=1)


def _basin(rng: np.random.Generator) -> FurniturePiece:
    bowl = _disc(0.0, 0.24, rng.uniform(0.12, 0.18), 0.7, 0.85)
    return _piece('basin', (-0.3, 0.0, 0.6, 0.45, 0.7, 0.85), bowl, rounded=1)


def _counter(rng: np.random.Generator) -> FurniturePiece:
    half = rng.uniform(1.0, 1.6)
    sink = (-half + 0.25, 0.12, 0.5, 0.36, 0.7, 0.9)
    plates = [_disc(half - x, y, 0.09, 0.9, 0.91) for x in (0.37, 0.63) for y in (0.17, 0.43)]
    return _piece('counter', (-half, 0.0, 2 * half, 0.6, 0.0, 0.9), sink, *plates, rounded=4)


def _round_table(rng: np.random.Generator) -> FurniturePiece:
    radius = rng.uniform(0.4, 0.8)
    stools = [
        _disc((radius + 0.1) * np.cos(turn), (radius + 0.1) * np.sin(turn), 0.2, 0.0, 0.45)
        for turn in np.arange(4) * np.pi / 2.0 + rng.uniform(0.0, 1.0)
    ]
    return _piece('round table', _disc(0.0, 0.0, radius, 0.71, 0.75), *stools, rounded=5)


def _plant(rng: np.random.Generator) -> FurniturePiece:
    radius = rng.uniform(0.15, 0.3)
    pot, leaves = (_disc(0.0, radius, r * radius, z, z + 0.5) for r, z in ((0.6, 0.0), (1, 0.5)))
    return _piece('plant', pot, leaves, rounded=2)


STANDING = (
    Stock((_cabinet, _shelf, _desk, _sofa, _bed, _table), (0.25, 0.2, 0.25, 0.08, 0.07, 0.15)),
)
"""Furniture of simulated worlds. Chosen."""

DRAWN = (
    Stock((_toilet, _basin), (0.5, 0.5), most_m2=6.0),
    Stock((_desk, _shelf, _plant), (0.45, 0.45, 0.1), most_m2=14.0),
    Stock(
        (_desk, _table, _round_table, _shelf, _sofa, _counter, _plant),
        (0.25, 0.2, 0.12, 0.14, 0.12, 0.12, 0.05),
    ),
)
"""Furniture of drawings, starting with small rooms. Chosen."""
