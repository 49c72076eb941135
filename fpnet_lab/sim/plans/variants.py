# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layout families derived from others: repeated rooms, curved wings, curved facades, bays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Point, Polygon

from fpnet_lab.sim.plans.families import bank_depth, branched, double_corridor, racetrack
from fpnet_lab.sim.plans.layout import Cell, Style, clip_cells, unite, warp_cells
from fpnet_lab.sim.plans.skeleton import Arm, build_cells

BEND_RADII_M = (22.0, 70.0)
MAX_BEND_RAD = 3.6
"""Largest angle of a curved wing, about 200 degrees. Chosen."""


def repeated(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a storey of identical rooms, like a hotel or a dormitory."""
    layout = (double_corridor, branched, racetrack)[int(rng.integers(3))]
    return layout(rng, replace(style, is_uniform=True))


def bent(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a corridor with rooms on both sides, bent into an arc."""
    cells = double_corridor(rng, style)
    x0, _, x1, _ = shapely.union_all([cell.polygon for cell in cells]).bounds
    radius = max(float(rng.uniform(*BEND_RADII_M)), (x1 - x0) / MAX_BEND_RAD)

    def bend(xy: NDArray[np.float64]) -> NDArray[np.float64]:
        angle, distance = xy[:, 0] / radius, radius + xy[:, 1]
        return np.stack([distance * np.sin(angle), distance * np.cos(angle) - radius], axis=1)

    return warp_cells(cells, bend)


def curved_facade(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a loop or a branched corridor with one or two sides clipped by an arc."""
    cells = racetrack(rng, style) if rng.random() < 0.7 else branched(rng, style)
    x0, y0, x1, y1 = shapely.union_all([cell.polygon for cell in cells]).bounds
    outline: shapely.Geometry = shapely.box(x0, y0, x1, y1)
    for sign in (1.0, -1.0):
        if sign > 0.0 or rng.random() < 0.5:
            radius = rng.uniform(0.6, 1.5) * (y1 - y0)
            apex = x1 if sign > 0.0 else x0
            centre = Point(apex - sign * radius, rng.uniform(0.35, 0.65) * (y1 - y0) + y0)
            disc = centre.buffer(radius, quad_segs=24)
            far = (
                shapely.box(x0, y0, centre.x, y1)
                if sign > 0.0
                else shapely.box(centre.x, y0, x1, y1)
            )
            outline = outline.intersection(shapely.union(disc, far))
    return clip_cells(cells, max(shapely.get_parts(outline), key=lambda g: float(g.area)))


def bays(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a corridor where every second or third room has a bay or an apse."""
    length, depth = rng.uniform(30.0, 80.0), bank_depth(rng, style)
    arm = Arm((0.0, 0.0), (length, 0.0), rng.uniform(1.8, 3.0), depth, depth)
    cells, every = build_cells(rng, [arm], style), int(rng.integers(2, 4))
    is_round, reach = bool(rng.random() < 0.6), rng.uniform(0.8, 2.0)
    for i, cell in enumerate(cells):
        x0, y0, x1, y1 = cell.polygon.bounds
        if cell.kind != 'room' or i % every or x1 - x0 > 2.0 * depth:
            continue
        outer = y1 if y0 > 0.0 else y0
        united = unite(cell.polygon, _bay(x0, x1, outer, reach, is_round))
        if united is not None:
            cells[i] = replace(cell, polygon=united)
    return cells


def _bay(x0: float, x1: float, y: float, reach: float, is_round: bool) -> Polygon:
    """Return a half disc or a box that projects from the outer wall at coordinate ``y``."""
    half = 0.42 * (x1 - x0)
    middle, sign = (x0 + x1) / 2.0, np.sign(y)
    if not is_round:
        return shapely.box(
            middle - half, min(y, y + sign * reach), middle + half, max(y, y + sign * reach)
        )
    angles = np.linspace(0.0, np.pi, 17)
    arc = np.stack([middle + half * np.cos(angles), y + sign * half * np.sin(angles)], axis=1)
    return Polygon(arc)
