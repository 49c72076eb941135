# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Symbols of drawings: door leaves and arcs, windows, hatching, texts, dimensions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_lab.sim.types import BuildingPlan

Array = NDArray[np.float64]

WINDOW_SHARE = 0.6
MAX_WINDOW_M = 2.4
MIN_WINDOW_WALL_M = 1.6
"""Width of a window as a share of its wall, its maximum, and the shortest wall. Chosen."""

# Chosen, not measured:
DIMENSION_OFFSET_M = 0.6
DIMENSION_TICK_M = 0.25

_ARC_POINTS = 9  # numerical
_PROBE_M = 0.1  # numerical
_NAMES = ('Office', 'Lab', 'Meeting', 'Store', 'Kitchen', 'WC', 'Archive', 'Copy', 'Server')


@dataclass(frozen=True)
class Text:
    """A line of text centred at ``xy`` [m]; ``width_m`` is the available width."""

    text: str
    xy: tuple[float, float]
    width_m: float


@dataclass(frozen=True, eq=False)
class Leaves:
    """
    Door leaves open at a right angle: ``hinge (L, 2)`` and ``length (L, 1)`` [m].

    The unit vectors ``along (L, 2)`` point from the hinge to the leaf's tip when closed,
    ``normal (L, 2)`` to its tip when open.
    """

    hinge: Array
    along: Array
    normal: Array
    length: Array

    @property
    def tips(self) -> Array:
        """Tips of the open leaves (L, 2) [m]."""
        return self.hinge + self.length * self.normal


def door_leaves(plan: BuildingPlan, wall_m: float) -> Leaves:
    """Return the leaves of all doors in walls drawn ``wall_m`` thick."""
    doors = [door for door in plan.doors if not door.is_open]
    if not doors:
        none = np.zeros((0, 2))
        return Leaves(none, none, none, none[:, :1])
    hinge = np.stack([door.ends[door.hinge] for door in doors])
    along = np.stack([door.ends[1 - door.hinge] for door in doors]) - hinge
    width = np.hypot(*along.T)[:, None]
    along /= width
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    probe = hinge + along * width / 2.0 + normal * (plan.wall_m / 2.0 + _PROBE_M)
    rooms = plan.outlines[[door.rooms[door.swing] for door in doors]]
    normal[~shapely.contains_xy(rooms, *probe.T)] *= -1.0
    leaves = np.array([[door.leaves] for door in doors])
    face = hinge + normal * wall_m / 2.0
    pairs = leaves[:, 0] == 2
    return Leaves(
        np.concatenate([face, (face + along * width)[pairs]]),
        np.concatenate([along, -along[pairs]]),
        np.concatenate([normal, normal[pairs]]),
        np.concatenate([width / leaves, width[pairs] / 2.0]),
    )


def door_marks(plan: BuildingPlan, wall_m: float, with_arcs: bool) -> list[Array]:
    """Return the open leaves of all doors as lines (V, 2) [m], optionally with swing arcs."""
    leaves = door_leaves(plan, wall_m)
    angle = np.linspace(np.pi / 2.0, 0.0, _ARC_POINTS if with_arcs else 1)[:, None, None]
    swept = leaves.length * (np.cos(angle) * leaves.along + np.sin(angle) * leaves.normal)
    lines = np.concatenate([leaves.hinge[None], leaves.hinge + swept])
    return list(lines.transpose(1, 0, 2))


def door_sills(plan: BuildingPlan, wall_m: float, lines: int) -> list[Array]:
    """Return threshold lines (2, 2) [m]: one in mid-wall, or two at the wall's faces."""
    offsets = np.linspace(-0.5, 0.5, lines) if lines > 1 else np.zeros(lines)
    doors = [door for door in plan.doors if not door.is_open]
    return [door.ends + at * wall_m * door.normal for door in doors for at in offsets]


def windows(rings: list[Array], depth_m: float, probe_m: float) -> tuple[Array, Array]:
    """
    Return the possible windows (E, 4, 2) in the walls around rooms.

    Parameters
    ----------
    rings : (V, 2) each
        Outlines of the rooms, counter-clockwise [m].
    depth_m : depth of the windows, outwards from the outline
    probe_m : distance beyond a window of the positions that must be outside of the building

    Returns
    -------
    Windows with two corners on the room's outline and two outside; positions (E, 2, 2) beyond.
    """
    edges = np.concatenate([np.stack([r, np.roll(r, -1, axis=0)], axis=1) for r in rings])
    along = edges[:, 1] - edges[:, 0]
    length = np.hypot(*along.T)
    long = length > MIN_WINDOW_WALL_M
    edges, length = edges[long], length[long, None]
    along = along[long] / length
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
    middle = edges.mean(axis=1)
    half = along * np.minimum(WINDOW_SHARE * length, MAX_WINDOW_M) / 2.0
    a, b, out = middle - half, middle + half, normals * depth_m
    panes = np.stack([a, b, b + out, a + out], axis=1)
    return panes, panes[:, 2:] + normals[:, None] * probe_m


def glazing(panes: Array) -> list[Array]:
    """Return the glass lines (2, 2) in the middle of windows (E, 4, 2)."""
    return list(np.stack([panes[:, [0, 3]].mean(axis=1), panes[:, 1:3].mean(axis=1)], axis=1))


def hatch(shape: BaseGeometry, angle_rad: float, spacing_m: float) -> list[Array]:
    """Return parallel strokes (2, 2) [m] that fill a shape."""
    if shape.is_empty:
        return []
    left, bottom, right, top = shape.bounds
    middle = np.array([(left + right) / 2.0, (bottom + top) / 2.0])
    reach = float(np.hypot(right - left, top - bottom)) / 2.0 + spacing_m
    along = np.array([np.cos(angle_rad), np.sin(angle_rad)])
    across = np.array([-along[1], along[0]])
    offsets = np.arange(-reach, reach, spacing_m)[:, None]
    starts = middle + offsets * across - reach * along
    strokes = shapely.linestrings(np.stack([starts, starts + 2.0 * reach * along], axis=1))
    shapely.prepare(shape)
    parts = shapely.get_parts(shapely.intersection(strokes, shape))
    lines = parts[shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING]
    return [shapely.get_coordinates(line) for line in lines if not shapely.is_empty(line)]


def room_texts(plan: BuildingPlan, rng: np.random.Generator) -> list[Text]:
    """Return one text for most rooms: a number, a name or the area."""
    storey, kind = int(rng.integers(5)), int(rng.integers(3))
    labels = room_labels(plan, rng, storey)
    return [replace(label, text=label.text.split('\n')[kind]) for label in labels]


def room_labels(plan: BuildingPlan, rng: np.random.Generator, storey: int) -> list[Text]:
    """Return three lines for each room of a storey: its number, its name and its area."""
    polygons = plan.outlines
    places = shapely.get_coordinates(shapely.point_on_surface(polygons))
    areas, bounds = shapely.area(polygons), shapely.bounds(polygons)
    texts = []
    for i, (x, y) in enumerate(places.tolist()):
        name = str(rng.choice(_NAMES))
        text = f'{storey}.{i:03d}\n{name}\n{areas[i]:.1f} m2'
        texts.append(Text(text, (x, y), float(bounds[i, 2] - bounds[i, 0])))
    return texts


def dimension_lines(points: Array, wall_m: float) -> list[Array]:
    """Return dimension lines with ticks, below and left of ``points (V, 2)`` and their walls."""
    (x0, y0), (x1, y1) = points.min(axis=0) - wall_m, points.max(axis=0) + wall_m
    x, y = x0 - DIMENSION_OFFSET_M, y0 - DIMENSION_OFFSET_M
    below, left = np.array([(x0, y), (x1, y)]), np.array([(x, y0), (x, y1)])
    return [*ticked(below, DIMENSION_TICK_M), *ticked(left, DIMENSION_TICK_M)]


def ticked(ends: Array, tick_m: float) -> list[Array]:
    """Return a dimension line between ``ends (2, 2)`` [m], and a diagonal tick at each end."""
    return [ends, *(np.stack([end - tick_m / 2.0, end + tick_m / 2.0]) for end in ends)]
