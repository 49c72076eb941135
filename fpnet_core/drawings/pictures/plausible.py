# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plausibility checks and scale-free features of segmented rooms."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.pictures.thickness import wall_cells
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.segmentation.ways_out import rooms_with_ways_out
from fpnet_core.types import FREE, OCCUPIED, GridMap, Segmentation

Array = NDArray[np.float64]

FEATURES = (
    'rooms', 'largest', 'door_to_room', 'doored', 'doors', 'square', 'squarest', 'door_spread',
    'ink', 'wall_to_door', 'specks', 'used', 'small', 'long', 'closed', 'spread',
)  # fmt: skip


# Chosen, not measured:
_GIANT_SHARE = 0.8  # of the total room area is in one of several rooms
_HALL_DOORS = 3  # rooms with doors to a hall; paper and missed walls have fewer
_MANY_SPECKS = 40.0  # per room
_DOORED_SHARE = 0.4  # of several rooms must have a detected door
_SEVERAL_ROOMS = 4
_JOINED_SHARE = 0.6  # of the rooms must be joined by doors, or belong to dwellings in a row
_DWELLING_ROOMS = 3  # this many joined rooms may be a dwelling with its own outer door
_DOOR_TO_ROOM = (0.06, 0.7)  # median door width over the root of the median room area
_INK_SHARE = 0.6  # largest share of walls in a building


def findings(segmentation: Segmentation, metres_per_unit: float | None = None) -> list[str]:
    """
    Return what is implausible about a segmentation with rooms, one sentence each.

    If the scale is stated, as ``metres_per_unit``, doors to the outside count as doors, and a room
    of any size with a door may be a hall. Without a scale such a room may also be the paper.
    """
    figures = dict(zip(FEATURES, features(segmentation).tolist(), strict=True))
    rooms = len(segmentation.rooms)
    ways = set() if metres_per_unit is None else rooms_with_ways_out(segmentation, metres_per_unit)
    low, high = np.log(_DOOR_TO_ROOM)
    ratio = figures['door_to_room']
    specks = np.expm1(figures['specks'])
    doored = len(ways | {room for p in segmentation.portals for room in p.rooms} - {None}) / rooms
    is_doored = rooms < _SEVERAL_ROOMS or doored >= _DOORED_SHARE
    has_doors = bool(segmentation.portals or ways)
    is_hall = _is_hall(segmentation, ways, _HALL_DOORS if metres_per_unit is None else 1)
    groups = _joined_rooms(segmentation)
    checks = [
        (
            rooms == 1 and not (metres_per_unit and is_hall),
            'Only one room was found: walls were missed, or this is not a floorplan.',
        ),
        (
            rooms > 1 and figures['largest'] > _GIANT_SHARE and not is_hall,
            f'One room takes {100.0 * figures["largest"]:.0f} % of the area: walls were missed, '
            'or the paper was taken for a room.',
        ),
        (
            not has_doors,
            'No door was found: perhaps they were taken for walls; draw them as gaps.',
        ),
        (
            has_doors and not is_doored,
            f'{100.0 * (1.0 - doored):.0f} % of the rooms have no door: arcs or '
            'thresholds of doors were taken for walls; draw the doors as gaps.',
        ),
        (
            is_doored and rooms >= _SEVERAL_ROOMS and _are_apart(segmentation, groups, ways),
            f'No more than {max(map(len, groups), default=0)} of {rooms} rooms are joined by '
            'doors: other doors were taken for walls; draw them as gaps.',
        ),
        (
            bool(segmentation.portals) and not low < ratio < high,
            f'Doors are {np.exp(ratio):.2f} times as wide as a typical room: implausible.',
        ),
        (
            figures['ink'] > _INK_SHARE,
            f'{100.0 * figures["ink"]:.0f} % of the building is wall: fills or hatching were '
            'taken for walls.',
        ),
        (
            specks > _MANY_SPECKS,
            f'{specks:.0f} specks per room were taken for walls: texts, patterns or noise.',
        ),
    ]
    return [sentence for is_so, sentence in checks if is_so]


def _joined_rooms(segmentation: Segmentation) -> list[set[int]]:
    """Return the groups of rooms that are joined by doors, as sets of ids."""
    groups = [{room.id} for room in segmentation.rooms]
    for portal in segmentation.portals:
        met = [group for group in groups if group & set(portal.rooms)]
        groups = [group for group in groups if group not in met] + [set().union(*met)]
    return groups


def _are_apart(segmentation: Segmentation, groups: list[set[int]], ways: set[int]) -> bool:
    """
    Return whether too many rooms are unreachable from the largest group and from outside.

    Groups as large as a dwelling count as reachable: their outer doors are seldom detected.
    """
    outer = ways | {p.rooms[0] for p in segmentation.portals if p.rooms[1] is None}
    largest = max(groups, key=len)
    reached = sum(
        len(group)
        for group in groups
        if group is largest or len(group) >= _DWELLING_ROOMS or group & outer
    )
    return reached < _JOINED_SHARE * len(segmentation.rooms)


def _is_hall(segmentation: Segmentation, ways: set[int], least: int) -> bool:
    """
    Return whether the largest room has enough doors for a hall.

    At least ``least`` other rooms must have a door to it; the outside counts as one.
    """
    largest = max(segmentation.rooms, key=lambda room: room.area_m2).id
    beside = {room for p in segmentation.portals if largest in p.rooms for room in p.rooms}
    return len(beside - {largest, None}) + (largest in ways or None in beside) >= least


def features(segmentation: Segmentation) -> Array:
    """Return the features (F,) of rooms, in the order of ``FEATURES``; zeros without rooms."""
    rooms = segmentation.rooms
    if not rooms:
        return np.zeros(len(FEATURES))
    grid = segmentation.grid
    area = np.array([room.area_m2 for room in rooms])
    width = np.array([portal.width_m for portal in segmentation.portals])
    doored = {room for portal in segmentation.portals for room in portal.rooms}
    sides = np.array([_sides(room.polygon) for room in rooms])
    square = area / np.maximum(sides.prod(axis=1), area)
    median = float(np.median(area))
    door = float(np.median(width)) if width.size else np.sqrt(median)
    occupied, free = (int(np.count_nonzero(grid.cells == k)) for k in (OCCUPIED, FREE))
    return np.array([
        np.log(len(rooms)),
        area.max() / area.sum(),
        np.log(door / np.sqrt(median)),
        sum(room.id in doored for room in rooms) / len(rooms),
        np.log((len(width) + 1) / len(rooms)),
        float(np.mean(square)),
        float(np.average(square, weights=area)),
        float(np.std(np.log(width))) if width.size else 1.0,
        occupied / (occupied + free),
        np.log(wall_cells(grid.cells == OCCUPIED) * grid.resolution / door),
        np.log1p(_specks(grid, door) / len(rooms)),
        area.sum() / (free * grid.resolution**2),
        float(np.mean(area < 0.15 * median)),
        float(np.log(np.median(sides.max(axis=1) / sides.min(axis=1)))),
        float(not width.size),
        float(np.std(np.log(area))),
    ])  # fmt: skip


def _sides(ring: Array) -> tuple[float, float]:
    _, size, _ = cv2.minAreaRect(ring.astype(np.float32))
    return max(size[0], 1e-6), max(size[1], 1e-6)


def _specks(grid: GridMap, door: float) -> int:
    """Return the number of wall components that are shorter than a door is wide."""
    _, stats = pieces_of(grid.cells == OCCUPIED)
    extent = stats[1:, 2:4].max(axis=1, initial=0) * grid.resolution
    return int(np.count_nonzero(extent < door))
