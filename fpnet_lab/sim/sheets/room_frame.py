# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Local frame of a rectangular room, and drawing tools for its symbols."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from fpnet_lab.sim.sheets.artwork import (
    Arcs,
    Area,
    Array,
    Lines,
    Mark,
    Pen,
    Role,
    circles,
    lines_of,
)
from fpnet_lab.sim.sheets.interior_style import FurniturePaint
from fpnet_lab.sim.sheets.looks import Look

_SQUARE = 0.93  # minimum share of its bounding rectangle that a rectangular room covers; chosen
_CIRCLE_STEPS = 16  # numerical


@dataclass(frozen=True, eq=False)
class RoomFrame:
    """
    Frame of a rectangular room as drawn: its corner, unit vectors and side lengths [m].

    ``u`` runs along the longer side, ``v`` along the shorter one.
    """

    corner: Array
    along: Array
    across: Array
    length: float
    width: float

    def at(self, uv: Array) -> Array:
        """Convert ``uv`` (..., 2) [m] in the room to points (..., 2) [m, page]."""
        return np.asarray(self.corner + uv @ np.stack([self.along, self.across]))

    def line(self, *uv: tuple[float, float]) -> Array:
        """Return a polyline (V, 2) [m, page] through ``uv`` points."""
        return self.at(np.array(uv))

    def box(self, u: float, v: float, du: float, dv: float) -> Array:
        """Return a rectangle (4, 2) [m, page] from its lower left corner and side lengths."""
        return self.line((u, v), (u + du, v), (u + du, v + dv), (u, v + dv))

    def boxes(self, u: Array, v: Array, du: float, dv: float) -> list[Array]:
        """Return a rectangle (4, 2) for each pair of lower left corners (N,)."""
        corner = np.stack([u, v], axis=1)[:, None]
        ring = np.array([(0.0, 0.0), (du, 0.0), (du, dv), (0.0, dv)])
        return list(self.at(corner + ring))

    def grid(self, du: float, dv: float, rim_u: float, rim_v: float) -> tuple[Array, Array]:
        """Return lower left corners ``u, v (N,)`` of grid cells that fill the room inside rims."""
        us = np.arange(rim_u, self.length - rim_u - du + 1e-6, du)
        vs = np.arange(rim_v, self.width - rim_v - dv + 1e-6, dv)
        u, v = np.meshgrid(us, vs)
        return u.ravel(), v.ravel()

    @property
    def angle_rad(self) -> float:
        """Direction of ``u`` on the page [rad], with texts along it not upside down."""
        angle = float(np.arctan2(self.along[1], self.along[0]))
        return (angle + np.pi / 2.0 - 1e-6) % np.pi - np.pi / 2.0 + 1e-6


def room_frame(room: Array) -> RoomFrame | None:
    """Return the frame of a room, or None if the room is not rectangular."""
    polygon = shapely.Polygon(room)
    ring = shapely.get_coordinates(shapely.oriented_envelope(polygon))[:4]
    sides = np.roll(ring, -1, axis=0) - ring
    lengths = np.hypot(*sides.T)
    area = float(lengths[0] * lengths[1])
    if area < 1e-6 or shapely.area(polygon) < _SQUARE * area:
        return None
    first = int(np.argmax(lengths[:2]))
    along, across = sides[first] / lengths[first], -sides[first - 1] / lengths[first - 1]
    return RoomFrame(ring[first], along, across, float(lengths[first]), float(lengths[first - 1]))


@dataclass(frozen=True, eq=False)
class Brush:
    """Drawing tools for the symbols of one room."""

    look: Look
    paint: FurniturePaint
    rng: np.random.Generator

    @property
    def pen(self) -> Pen:
        """Pen of outlines."""
        return self.look.pen(self.paint.pen_mm, self.paint.colour)

    def uniform(self, low: float, high: float) -> float:
        """Sample a number uniformly."""
        return float(self.rng.uniform(low, high))

    def boxes(self, rings: list[Array], role: Role = Role.FURNITURE) -> list[Mark]:
        """Return rings (V, 2) as outlines, filled if the paint has a fill colour."""
        if not rings:
            return []
        marks: list[Mark] = []
        if self.paint.fill is not None:
            marks.append(Area(role, tuple(rings), self.paint.fill))
        return [*marks, Lines(role, tuple(rings), self.pen, is_closed=True)]

    def lines(self, lines: list[Array], role: Role = Role.FURNITURE) -> list[Mark]:
        """Return polylines (V, 2) as marks."""
        return lines_of(role, lines, self.pen)

    def dashed(self, lines: list[Array], role: Role = Role.STAIRS) -> list[Mark]:
        """Return dashed polylines (V, 2) as marks."""
        return lines_of(role, lines, self.look.pen(self.paint.pen_mm, dashes_mm=(2.0, 1.2)))

    def rounds(self, centre: Array, radius: float, role: Role = Role.FURNITURE) -> list[Mark]:
        """Return circles around centres (N, 2), filled if the paint has a fill colour."""
        if not len(centre):
            return []
        marks: list[Mark] = []
        if self.paint.fill is not None:
            marks.append(Area(role, tuple(disc(xy, radius) for xy in centre), self.paint.fill))
        return [*marks, circles(role, centre, radius, self.pen)]

    def arc(self, centre: Array, radius: float, start: float, end: float) -> Mark:
        """Return a circular arc."""
        spans = np.array([[start, end]])
        return Arcs(Role.STAIRS, centre[None], np.array([radius]), spans, self.pen)


def disc(xy: Array, radius: float) -> Array:
    """Return a circle as a polygon ring (V, 2)."""
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE_STEPS, endpoint=False)
    return np.asarray(xy + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
