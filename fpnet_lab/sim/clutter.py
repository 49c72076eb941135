# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Furniture for raster worlds: upright boxes, thousands of buildings an hour.

Where :mod:`fpnet_lab.sim.furniture` models pieces for ray casting against meshes and keeps them
apart, here pieces may touch: a raster only needs what a scanner at one height meets.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_lab.sim.types import BuildingPlan

Array = NDArray[np.float64]

ROOM_DENSITY_PER_M2 = (0.05, 0.3)
CORRIDOR_DENSITY_PER_M2 = (0.0, 0.04)
MAX_PIECES = 24
DOOR_CLEARANCE_M = 1.2
"""Pieces keep this far from the middle of a door. Chosen."""

# Chosen, not measured:
_LEG_M = 0.06
_CHAIR_M = 0.45
_WALL_GAP_M = 0.03


@dataclass(frozen=True, eq=False)
class Boxes:
    """Upright boxes: ``centre (B, 2)``, ``half (B, 2)`` [m], ``yaw (B,)``, ``span (B, 2)`` [m]."""

    centre: Array
    half: Array
    yaw: Array
    span: Array

    def met_at(self, height_m: float) -> list[Array]:
        """Return the outlines (4, 2) of the boxes that a level ray at this height meets."""
        met = (self.span[:, 0] <= height_m) & (height_m <= self.span[:, 1])
        corners = self.half[met, None] * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        c, s = np.cos(self.yaw[met])[:, None], np.sin(self.yaw[met])[:, None]
        x = c * corners[..., 0] - s * corners[..., 1]
        y = s * corners[..., 0] + c * corners[..., 1]
        return list(np.stack([x, y], axis=2) + self.centre[met, None])


# A piece is boxes in its own frame, rows (x, y, half x, half y, bottom, top) in metres: x along
# the wall, y into the room, the middle of its back at the origin.


def _cabinet(rng: np.random.Generator) -> Array:
    width, depth = rng.uniform(0.7, 2.0), rng.uniform(0.3, 0.6)
    return np.array([[0.0, depth / 2, width / 2, depth / 2, 0.0, rng.uniform(0.7, 2.1)]])


def _legs(x: float, y: float, width: float, depth: float, top: float) -> Array:
    half = _LEG_M / 2
    return np.array(
        [
            [x + i * (width / 2 - half), y + j * (depth / 2 - half), half, half, 0.0, top]
            for i in (-1, 1)
            for j in (-1, 1)
        ]
    )


def _chair(x: float, y: float) -> Array:
    back = [[x, y - _CHAIR_M / 2, _CHAIR_M / 2, _LEG_M / 2, 0.45, 0.95]]
    return np.concatenate([_legs(x, y, _CHAIR_M, _CHAIR_M, 0.45), back])


def _desk(rng: np.random.Generator) -> Array:
    width, depth = rng.uniform(1.2, 1.8), rng.uniform(0.7, 0.85)
    top = [[0.0, depth / 2, width / 2, depth / 2, 0.7, 0.75]]
    drawers = [[width / 2 - 0.3, depth / 2, 0.2, depth / 2 - 0.05, 0.05, 0.7]]
    chair = _chair(rng.uniform(-0.3, 0.2), depth + rng.uniform(0.0, 0.4))
    return np.concatenate([_legs(0.0, depth / 2, width, depth, 0.7), top, drawers, chair])


def _table(rng: np.random.Generator) -> Array:
    width, depth = rng.uniform(1.0, 2.4), rng.uniform(0.7, 1.1)
    parts = [_legs(0.0, 0.0, width, depth, 0.7)]
    parts.append(np.array([[0.0, 0.0, width / 2, depth / 2, 0.7, 0.75]]))
    for x in np.arange(-width / 2 + 0.4, width / 2 - 0.2, 0.65):
        parts += [
            _chair(float(x), side * (depth / 2 + rng.uniform(0.0, 0.3)))
            for side in (-1.0, 1.0)
            if rng.random() < 0.7
        ]
    return np.concatenate(parts)


def _seat(rng: np.random.Generator) -> Array:
    width, depth = rng.uniform(0.9, 2.2), rng.uniform(0.8, 2.0)
    return np.array([[0.0, depth / 2, width / 2, depth / 2, 0.1, rng.uniform(0.4, 0.9)]])


def _object(rng: np.random.Generator) -> Array:
    half = rng.uniform(0.1, 0.3)
    return np.array([[0.0, half, half, half, 0.0, rng.uniform(0.3, 1.7)]])


_MAKERS = (_cabinet, _desk, _table, _seat, _object)
# Chosen, not measured:
_FREQUENCIES = (0.35, 0.25, 0.15, 0.1, 0.15)
_FREE_STANDING = (_table, _object)
_FREE_STANDING_SHARE = 0.8  # of those that may, stand away from walls
_FREE_YAW_RAD = 0.1  # by how much they are out of line


def furnish_boxes(plan: BuildingPlan, rng: np.random.Generator) -> Boxes:
    """
    Fill a storey with furniture along walls and in the middle of rooms.

    Doors stay clear. Boxes may reach through walls; whoever rasterises them keeps to the rooms.
    """
    doors = np.array([door.ends.mean(axis=0) for door in plan.doors]).reshape(-1, 2)
    density = {
        'room': rng.uniform(*ROOM_DENSITY_PER_M2),
        'corridor': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
        'hall': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
    }
    rows: list[Array] = []
    for room in plan.rooms:
        count = min(MAX_PIECES, int(rng.poisson(density[room.kind] * _area_m2(room.polygon))))
        kinds = rng.choice(len(_MAKERS), count, p=_FREQUENCIES) if room.kind == 'room' else None
        makers = [_MAKERS[k] for k in kinds] if kinds is not None else [_cabinet] * count
        may_stand_free = np.array([maker in _FREE_STANDING for maker in makers], dtype=np.bool_)
        places, yaws = _draw_places(rng, room.polygon, may_stand_free)
        gaps = np.hypot(*(places[:, None] - doors).T).min(axis=0, initial=np.inf)
        rows += [
            _moved(maker(rng), xy, yaw)
            for maker, xy, yaw, gap in zip(makers, places, yaws.tolist(), gaps, strict=True)
            if gap > DOOR_CLEARANCE_M
        ]
    boxes = np.concatenate(rows) if rows else np.zeros((0, 7))
    return Boxes(boxes[:, :2], boxes[:, 2:4], boxes[:, 6], boxes[:, 4:6])


def _area_m2(ring: Array) -> float:
    x, y = ring.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _draw_places(
    rng: np.random.Generator, ring: Array, may_stand_free: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """
    Return places (B, 2) and angles (B,) for pieces in a room.

    They are at the outline ``ring (V, 2)``, counter-clockwise, or most of those that
    ``may_stand_free (B,)`` between two places at it.
    """
    count = len(may_stand_free)
    edges = np.roll(ring, -1, axis=0) - ring
    lengths = np.hypot(*edges.T)
    picks = rng.choice(len(ring), (2, count), p=lengths / lengths.sum())
    at_wall, other = ring[picks] + rng.random((2, count, 1)) * edges[picks]
    along = edges[picks[0]] / lengths[picks[0], None]
    yaw = np.arctan2(along[:, 1], along[:, 0])
    is_free = may_stand_free & (rng.random(count) < _FREE_STANDING_SHARE)
    beside = at_wall + _WALL_GAP_M * np.stack([-along[:, 1], along[:, 0]], axis=1)
    places = np.where(is_free[:, None], (at_wall + other) / 2.0, beside)
    return places, yaw + is_free * rng.normal(0.0, _FREE_YAW_RAD, count)


def _moved(piece: Array, xy: Array, yaw: float) -> Array:
    """Return the piece's boxes in the building, with their yaw as a seventh column."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = piece[:, 0], piece[:, 1]
    centre = np.stack([xy[0] + c * x - s * y, xy[1] + s * x + c * y], axis=1)
    return np.concatenate([centre, piece[:, 2:], np.full((len(piece), 1), yaw)], axis=1)
