# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differences of walls between a drawing and the building: removed, added and glass walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon, affinity

from fpnet_lab.sim.config import BuildingConfig
from fpnet_lab.sim.drawn.render import door_outline
from fpnet_lab.sim.types import BuildingPlan

PARTITION_M = 0.1
LARGE_ROOM_M2 = 18.0
"""Rooms above this size may get a partition. Chosen."""

MOVED_WALL_M = (0.3, 1.2)
"""Displacement of a wall. Chosen."""

# Chosen, not measured:
_MOST_CHANGES = 2
_LEAST_WALL_M2 = 0.2
_GAP_M = 1.0  # width of the gap in a partition
_GLASS_PIECE_M = (0.8, 3.0)
_GLASS_DEPTH_M = 0.05  # numerical: overlap beyond the wall, so that no thin wall remains


@dataclass(frozen=True, eq=False)
class WallChanges:
    """Polygons [m] of removed walls, added walls, and walls made of glass."""

    removed: tuple[Polygon, ...]
    added: tuple[Polygon, ...]
    glass: tuple[Polygon, ...]


def draw_wall_changes(
    plan: BuildingPlan, rng: np.random.Generator, config: BuildingConfig
) -> WallChanges:
    """Sample the differences between a building's walls and its plan."""
    removed, added = [], []
    if rng.random() < config.removed_walls:
        for _, _, walls in _shared_walls(plan, rng):
            removed += walls
    if rng.random() < config.added_walls:
        added += _partitions(plan, rng)
    if rng.random() < config.moved_walls:
        for i, j, walls in _shared_walls(plan, rng):
            removed += walls
            added += _displaced(plan, (i, j), walls, rng)
    glass = _glass(plan, rng, rng.uniform(*config.glass))
    return WallChanges(tuple(removed), tuple(added), tuple(glass))


def _shared_walls(
    plan: BuildingPlan, rng: np.random.Generator
) -> list[tuple[int, int, list[Polygon]]]:
    """Return up to two pairs of neighbouring rooms with the wall polygons between them."""
    outlines = plan.outlines
    tree = shapely.STRtree(outlines)
    is_room = np.array([room.kind == 'room' for room in plan.rooms])
    found = []
    for pick in rng.permutation(np.flatnonzero(is_room))[: _draw_count(rng)].tolist():
        near = tree.query(outlines[pick], 'dwithin', 1.5 * plan.wall_m)
        near = near[(near != pick) & is_room[near]]
        if len(near):
            other = int(rng.choice(np.sort(near)))
            pair = [pick, other]
            grown = shapely.buffer(outlines[pair], plan.wall_m, join_style='mitre')
            gap = shapely.intersection(*grown)
            beside = np.setdiff1d(tree.query(gap, 'dwithin', plan.wall_m), pair)
            keep = shapely.buffer(shapely.union_all(outlines[beside]), plan.wall_m / 2.0)
            parts = shapely.get_parts(shapely.difference(gap, keep)).tolist()
            walls = [p for p in parts if isinstance(p, Polygon) and p.area > _LEAST_WALL_M2]
            found.append((pick, other, walls))
    return found


def _draw_count(rng: np.random.Generator) -> int:
    return int(rng.integers(1, _MOST_CHANGES + 1))


def _displaced(
    plan: BuildingPlan, pair: tuple[int, int], walls: list[Polygon], rng: np.random.Generator
) -> list[Polygon]:
    """Return the walls between two rooms, shifted into one of them, with doorways cut out."""
    rooms = shapely.union_all(plan.outlines[list(pair)])
    doorways = shapely.union_all(
        [
            Polygon(door_outline(door, plan.wall_m, plan.wall_m))
            for door in plan.doors
            if set(door.rooms) == set(pair)
        ]
    )
    shift_m = float(rng.uniform(*MOVED_WALL_M)) * (1.0 if rng.random() < 0.5 else -1.0)
    moved = []
    for wall in walls:
        box = shapely.get_coordinates(wall.minimum_rotated_rectangle)[:4]
        sides = np.diff(box[:3], axis=0)
        across = sides[np.argmin(np.hypot(*sides.T))]
        dx, dy = shift_m * across / np.hypot(*across)
        solid = wall.difference(doorways)
        parts = shapely.get_parts(affinity.translate(solid, dx, dy).intersection(rooms)).tolist()
        moved += [part for part in parts if isinstance(part, Polygon)]
    return moved


def _partitions(plan: BuildingPlan, rng: np.random.Generator) -> list[Polygon]:
    """Return partitions across one or two large rooms, each with a gap."""
    large = [
        outline
        for room, outline in zip(plan.rooms, plan.outlines, strict=True)
        if room.kind == 'room' and outline.area > LARGE_ROOM_M2
    ]
    added = []
    for pick in rng.permutation(len(large))[: _draw_count(rng)].tolist():
        box = large[pick].minimum_rotated_rectangle
        a, b, c, d = shapely.get_coordinates(box)[:4]
        if np.hypot(*(b - a)) < np.hypot(*(c - b)):
            a, b, c, d = b, c, d, a
        at, gap = rng.uniform(0.35, 0.65), rng.uniform(0.1, 0.8)
        start, end = a + at * (b - a), d + at * (c - d)
        half = _GAP_M / 2.0 / float(np.hypot(*(end - start)))
        shares = ((0.0, max(gap - half, 0.0)), (min(gap + half, 1.0), 1.0))
        for first, last in shares:
            line = shapely.LineString(start + np.array([[first], [last]]) * (end - start))
            added.append(line.buffer(PARTITION_M / 2.0, cap_style='flat'))
    return [wall for wall in added if not wall.is_empty]


def _glass(plan: BuildingPlan, rng: np.random.Generator, share: float) -> list[Polygon]:
    """Return polygons of glass walls, about ``share`` of the total wall length."""
    starts = np.concatenate([room.polygon for room in plan.rooms])
    ends = np.concatenate([np.roll(room.polygon, -1, axis=0) for room in plan.rooms])
    edges: NDArray[np.float64] = ends - starts
    lengths = np.hypot(*edges.T)
    pieces, budget = [], share * lengths.sum()
    while budget > 0.0:
        pick = int(rng.choice(len(edges), p=lengths / lengths.sum()))
        size = min(float(lengths[pick]), rng.uniform(*_GLASS_PIECE_M))
        along = edges[pick] / lengths[pick]
        a = starts[pick] + along * rng.uniform(0.0, lengths[pick] - size)
        b = a + along * size
        outwards = np.array([along[1], -along[0]]) * (plan.wall_m + _GLASS_DEPTH_M)
        pieces.append(Polygon([a, b, b + outwards, a + outwards]))
        budget -= size
    return pieces
