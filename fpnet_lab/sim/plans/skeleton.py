# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion of a corridor skeleton to cells: banks of rooms on both sides of every arm.

Most storeys are corridors lined with rooms. A family only defines the corridors' centre lines,
at any angle; corners, overlaps and courtyards follow from the geometry.
"""

from __future__ import annotations

from dataclasses import dataclass
import itertools
import math

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import LineString, Polygon, affinity

from fpnet_lab.sim.plans.layout import (
    Cell,
    Kind,
    Style,
    absorb_slivers,
    cut_holes,
    polygons_of,
)

MIN_ROOM_WIDTH_M = 2.0
KINDS: tuple[Kind, ...] = ('hall', 'corridor')
"""Kinds of circulation space; where they overlap, the floor belongs to the hall. Chosen."""

MAX_ASPECT = 1.8
"""Largest ratio of width to depth, or depth to width, of rooms along a bank. Chosen."""


@dataclass(frozen=True)
class Arm:
    """
    A corridor or hall along a centre line, with a bank of rooms on each side.

    ``left_m`` and ``right_m`` are the depths of the banks (0: outer wall), seen from ``start`` to
    ``end``; ``before_m`` and ``after_m`` extend the banks beyond the corridor's ends to fill
    corners; ``foot_m`` and ``cap_m`` are the depths of rooms across the start and the end;
    ``bounds`` limits the area of the banks (None: unlimited).
    """

    start: tuple[float, float]
    end: tuple[float, float]
    width_m: float
    left_m: float
    right_m: float
    kind: Kind = 'corridor'
    before_m: float = 0.0
    after_m: float = 0.0
    foot_m: float = 0.0
    cap_m: float = 0.0
    bounds: Polygon | None = None

    @property
    def length_m(self) -> float:
        """Length of the centre line [m]."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))

    def to_world(self, polygon: Polygon) -> Polygon:
        """Transform a polygon from the arm's frame (x along the arm) to the building frame."""
        angle = math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])
        c, s = math.cos(angle), math.sin(angle)
        return affinity.affine_transform(polygon, [c, -s, s, c, *self.start])

    def to_local(self, polygon: Polygon) -> Polygon:
        """Transform a polygon from the building frame to the arm's frame."""
        angle = math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])
        c, s = math.cos(angle), math.sin(angle)
        x, y = self.start
        return affinity.affine_transform(polygon, [c, s, -s, c, -c * x - s * y, s * x - c * y])


def split_length(
    rng: np.random.Generator, length_m: float, depth_m: float, style: Style
) -> NDArray[np.float64]:
    """
    Split a bank of ``depth_m`` into rooms and return the wall positions from 0 to ``length_m``.

    Room widths are log-normal around the depth; a uniform style repeats one width.
    """
    lower = max(MIN_ROOM_WIDTH_M, depth_m / MAX_ASPECT)
    upper = max(lower, depth_m * MAX_ASPECT)
    if style.is_uniform:
        width = float(np.clip(style.room_side_m, lower, upper))
        return np.linspace(0.0, length_m, max(1, round(length_m / width)) + 1)
    widths: list[float] = []
    while sum(widths) < length_m:
        width = depth_m * math.exp(style.spread * rng.standard_normal())
        widths.append(float(np.clip(width, lower, upper)))
    if len(widths) > 1 and sum(widths) - length_m > widths[-1] / 2.0:
        widths.pop()
    cuts = np.concatenate([[0.0], np.cumsum(widths)])
    return np.asarray(cuts * (length_m / cuts[-1]))


def slice_bank(
    rng: np.random.Generator, bank: Polygon, arm: Arm, depth_m: float, style: Style
) -> list[Cell]:
    """Split a bank's remaining outline into rooms, perpendicular to its arm."""
    local = arm.to_local(bank)
    x0, y0, x1, y1 = local.bounds
    cells = []
    cuts = x0 + split_length(rng, x1 - x0, min(depth_m, y1 - y0), style)
    for left, right in itertools.pairwise(cuts):
        strip = shapely.box(left, y0 - 1.0, right, y1 + 1.0)
        cells += [Cell(arm.to_world(p)) for p in polygons_of(local.intersection(strip))]
    return cells


def _banks(arm: Arm) -> list[tuple[Polygon, float]]:
    """Return outlines and depths of an arm's banks and end rooms, before removing overlaps."""
    half = arm.width_m / 2.0
    x0, x1 = -arm.before_m, arm.length_m + arm.after_m
    banks = []
    if arm.left_m > 0.0:
        banks.append((shapely.box(x0, half, x1, half + arm.left_m), arm.left_m))
    if arm.right_m > 0.0:
        banks.append((shapely.box(x0, -half - arm.right_m, x1, -half), arm.right_m))
    for depth, near, far in ((arm.foot_m, x0 - arm.foot_m, x0), (arm.cap_m, x1, x1 + arm.cap_m)):
        if depth > 0.0:
            outline = shapely.box(near, -half - arm.right_m, far, half + arm.left_m)
            banks.append((outline, depth))
    return [(arm.to_world(outline), depth) for outline, depth in banks]


def _lanes(arms: list[Arm]) -> shapely.Geometry:
    """Return the corridors' floor area; arms of equal width that meet end to end are mitred."""
    floors = []
    for width in sorted({arm.width_m for arm in arms}):
        lines = [LineString([arm.start, arm.end]) for arm in arms if arm.width_m == width]
        merged = shapely.line_merge(shapely.multilinestrings(lines))
        floors.append(merged.buffer(width / 2.0, cap_style='flat', join_style='mitre'))
    return shapely.union_all(floors, grid_size=1e-3)


def build_cells(rng: np.random.Generator, arms: list[Arm], style: Style) -> list[Cell]:
    """
    Lay out corridors along ``arms`` and rooms in their banks; earlier arms get the overlaps.

    Touching corridors of one kind become one cell, which is split only where it closes a loop.
    """
    lanes = {kind: _lanes([arm for arm in arms if arm.kind == kind]) for kind in KINDS}
    lanes['corridor'] = lanes['corridor'].difference(lanes['hall'])
    cells: list[Cell] = []
    for kind in KINDS:
        for part in polygons_of(lanes[kind]):
            cells += [Cell(piece, kind) for piece in cut_holes(part)]
    taken = _areas(shapely.union_all(list(lanes.values()), grid_size=1e-3))
    for arm in arms:
        for outline, depth in _banks(arm):
            allowed: shapely.Geometry = outline
            if arm.bounds is not None:
                allowed = shapely.union_all(polygons_of(outline.intersection(arm.bounds)))
            for part in polygons_of(shapely.difference(allowed, taken, grid_size=1e-3)):
                if part.area > 1.0 and not part.interiors:
                    cells += slice_bank(rng, part, arm, depth, style)
            taken = _areas(shapely.union(taken, allowed, grid_size=1e-3))
    return absorb_slivers(cells)


def _areas(geometry: shapely.Geometry) -> shapely.Geometry:
    """Return the polygonal part: grid snapping may leave lines, which overlays reject."""
    if geometry.geom_type in ('Polygon', 'MultiPolygon'):
        return geometry
    return shapely.union_all(polygons_of(geometry))
