# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Conversion of labelled cells and openings to regions and portals in metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.raster.blocks import unblocked
from fpnet_core.raster.morphology import Mask, cross, spread
from fpnet_core.raster.pieces import cell_corners, label_extents, looked_up
from fpnet_core.segmentation.openings import Opening
from fpnet_core.types import GridMap, Portal, Region, RegionLabel, Segmentation

_DOOR_DEPTH_M = 0.2  # physical: depth of a door's region across its line, a wall's thickness

# Numerical: simplified polygons deviate from the raster's outline by at most this many cells.
SIMPLIFY_CELLS = 1.0


@dataclass(frozen=True)
class RoomScore:
    """How completely a room was observed; see :class:`fpnet_core.types.Region`."""

    observed_fraction: float = 1.0
    frontier_fraction: float = 0.0


def upsample_labels(
    labels: NDArray[np.int32], stride: int, free: Mask, reach: int | None = None
) -> NDArray[np.int32]:
    """
    Spread room labels (h, w) from working to full resolution, over free cells only.

    Cells along walls lie in blocks that are only partly free. They take the label of the room they
    touch, up to ``reach`` cells away; None means one block.
    """
    return spread(unblocked(labels, stride, free.shape), free, cross(), reach or stride)


def outline(mask: Mask) -> NDArray[np.float64] | None:
    """
    Trace the outer boundary of the largest component of ``mask (H, W)`` along its cells' edges.

    Returns (V, 2) row-column vertices in fractional cells (centres are integers), not closed; None
    for an empty mask.
    """
    contours, _ = cv2.findContours(cell_corners(mask), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    if not contours:
        return None
    ring = max(contours, key=cv2.contourArea)
    simple = cv2.approxPolyDP(ring, SIMPLIFY_CELLS, closed=True)[:, 0, ::-1]
    if len(simple) < 3 or not shapely.LinearRing(simple).is_simple:
        simple = ring[:, 0, ::-1]
    return np.asarray(simple - 0.5, dtype=np.float64)


def _signed_area(ring: NDArray[np.float64]) -> float:
    x, y = ring[:, -1], ring[:, 0]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def assemble(
    grid: GridMap,
    labels: NDArray[np.int32],
    openings: Sequence[Opening],
    metres_per_unit: float = 1.0,
    scores: dict[int, RoomScore] | None = None,
) -> Segmentation:
    """
    Build the segmentation from full-resolution room labels and openings.

    Parameters
    ----------
    grid : the segmented grid; the result has its frame and nominal metres
    labels : (H, W) int32, room labels with or without gaps, 0 outside
    openings : between these labels; a label that is 0 or absent is unseen space
    metres_per_unit : true metres per nominal metre, for a door's depth
    scores : completeness by label; missing labels count as fully observed

    Returns
    -------
    Segmentation; with a reason and no regions if no room has an outline
    """
    ids, rooms, kept = _rooms(grid, labels, scores or {}, _room_confidence(openings))
    if not rooms:
        return Segmentation(grid, np.zeros_like(labels), (), (), 'no room was found')
    pairs = [[ids[room] for room in opening.rooms if room in ids] for opening in openings]
    joining = [(opening, pair) for opening, pair in zip(openings, pairs, strict=True) if pair]
    doors, portals = _doors(grid, joining, len(rooms), _DOOR_DEPTH_M / metres_per_unit)
    return Segmentation(grid, kept, (*rooms, *doors), tuple(portals))


def _rooms(
    grid: GridMap,
    labels: NDArray[np.int32],
    scores: dict[int, RoomScore],
    confidence: dict[int, float],
) -> tuple[dict[int, int], list[Region], NDArray[np.int32]]:
    """Return ids by label, room regions (largest first) and labels renumbered to id + 1."""
    lut = np.zeros(int(labels.max(initial=0)) + 1, dtype=np.int32)
    extents, counts, middles = label_extents(labels, len(lut))
    ids: dict[int, int] = {}
    rooms: list[Region] = []
    largest_first = np.argsort(-counts[1:], kind='stable') + 1
    for label in largest_first[: np.count_nonzero(counts[1:])].tolist():
        r0, c0, r1, c1 = extents[label].tolist()
        mask = labels[r0:r1, c0:c1] == label
        ring = outline(mask)
        if ring is None:
            continue
        corner = np.array([r0, c0], dtype=np.float64)
        polygon = grid.rc_to_xy(ring + corner)
        if _signed_area(polygon[:, ::-1]) < 0.0:
            polygon = polygon[::-1]
        score = scores.get(label, RoomScore())
        ids[label] = len(rooms)
        lut[label] = len(rooms) + 1
        rooms.append(
            Region(
                id=len(rooms),
                label=RegionLabel.ROOM,
                polygon=polygon,
                centroid=grid.rc_to_xy(middles[label]),
                area_m2=float(counts[label]) * grid.resolution**2,
                observed_fraction=score.observed_fraction,
                frontier_fraction=score.frontier_fraction,
                confidence=score.observed_fraction * confidence.get(label, 1.0),
            )
        )
    kept = looked_up(labels, lut)
    kept.setflags(write=False)  # Segmentation copies writable arrays
    return ids, rooms, kept


def _opening_confidence(opening: Opening) -> float:
    """Return an opening's confidence as a separator: 1 with a lintel, else by its width."""
    if opening.has_lintel:
        return 1.0
    narrow_m, wide_m = 1.0, 2.2
    sure = 1.0 - 0.5 * (2.0 * opening.clearance_m - narrow_m) / (wide_m - narrow_m)
    return min(max(sure, 0.5), 1.0)


def _room_confidence(openings: Sequence[Opening]) -> dict[int, float]:
    """Return, by label, the confidence of the least certain opening of each room."""
    worst: dict[int, float] = {}
    for opening in openings:
        for room in opening.rooms:
            worst[room] = min(worst.get(room, 1.0), _opening_confidence(opening))
    return worst


def _doors(
    grid: GridMap, joining: Sequence[tuple[Opening, list[int]]], first: int, depth_m: float
) -> tuple[list[Region], list[Portal]]:
    """
    Return doors numbered from ``first`` and their portals: rectangles ``depth_m`` deep.

    ``joining`` are openings with the ids of their one or two rooms. Those without length are
    skipped.
    """
    ends = grid.rc_to_xy(np.array([opening.ends_rc for opening, _ in joining]).reshape(-1, 2, 2))
    along = ends[:, 1] - ends[:, 0]
    width = np.hypot(along[:, 0], along[:, 1])
    is_line = width > 0.0
    joining = [door for door, is_long in zip(joining, is_line, strict=True) if is_long]
    ends, along, width = ends[is_line], along[is_line], width[is_line]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / width[:, None] * depth_m / 2.0
    begin, end = ends[:, 0], ends[:, 1]
    polygons = np.stack([begin - across, end - across, end + across, begin + across], axis=1)
    doors: list[Region] = []
    portals: list[Portal] = []
    for k, ((opening, pair), middle) in enumerate(zip(joining, ends.mean(axis=1), strict=True)):
        doors.append(
            Region(
                id=first + k,
                label=RegionLabel.DOOR,
                polygon=polygons[k],
                centroid=middle,
                area_m2=float(width[k]) * depth_m,
                confidence=_opening_confidence(opening),
            )
        )
        second = pair[1] if len(pair) == 2 else None
        portals.append(Portal(first + k, (pair[0], second), ends[k], opening.has_lintel))
    return doors, portals
