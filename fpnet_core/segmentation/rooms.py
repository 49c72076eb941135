# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Core of both segmentations, of floorplans and submaps: from a clean scene to labelled rooms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import looked_up
from fpnet_core.segmentation.assemble import upsample_labels
from fpnet_core.segmentation.basins import grow_basins, merge_shallow
from fpnet_core.segmentation.door_figures import LineMasks, line_figures
from fpnet_core.segmentation.door_model import MAP_FIGURES, packaged_door_model
from fpnet_core.segmentation.gaps import closed_cells, find_gaps, openings_across
from fpnet_core.segmentation.joining import DividingLines, Pieces, absorb_small, join_pieces
from fpnet_core.segmentation.openings import (
    Opening,
    closing_lines,
    find_openings,
    find_saddles_of_rooms,
)
from fpnet_core.segmentation.scene import Scene, WorkRaster, reduce_scene

# Smaller rooms join the neighbour with the widest opening;
# fitted to the development split (notes/segmentation.md).
MIN_ROOM_AREA_M2 = 1.5
# Physical: nobody walks where it is narrower. A space that is narrower everywhere is no room;
# narrower parts of a room do not count towards its area [m].
MIN_ROOM_WIDTH_M = 0.5
# Small rooms with a longer edge to unseen space stay separate;
# fitted to the development split (notes/segmentation.md).
_GLIMPSE_EDGE_M = 0.8

Labels = NDArray[np.int32]
Line = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Parts:
    """
    A scene divided at every candidate dividing line.

    ``labels (h, w)`` are the pieces at working resolution, 0 outside; ``gaps`` are lines (2, 2)
    that were closed in ``scene``, and ``lines`` all places where pieces meet.
    """

    scene: Scene
    work: WorkRaster
    labels: Labels
    gaps: list[Line]
    pieces: Pieces
    lines: DividingLines


Decide = Callable[[Parts], NDArray[np.int64]]
"""Returns, for each piece (P,) of a divided scene, the piece that it joins."""


def joined_as_learned(parts: Parts) -> NDArray[np.int64]:
    """Return, for each piece (P,), the piece that it joins according to the packaged model."""
    scorer = packaged_door_model().probability_of_one_room
    return join_pieces(parts.pieces, parts.lines, scorer)


def cut_rooms(
    scene: Scene, decide: Decide = joined_as_learned
) -> tuple[Labels, list[Opening], NDArray[np.float32]]:
    """
    Label the rooms of a scene and find the openings between them; ``decide`` merges pieces.

    Returns
    -------
    labels (H, W) int32 : 1..R, 0 outside rooms
    openings : between these labels; saddles first, widest first, then gaps in walls
    clearance (H, W) float32 : distance to walls and to all candidate gaps [true metres]
    """
    parts = cut_parts(scene)
    target = decide(parts)
    target = absorb_small(parts.pieces, parts.lines, target, MIN_ROOM_AREA_M2, _GLIMPSE_EDGE_M)
    return *_rooms_of(scene, parts, target), parts.scene.clearance


def cut_parts(scene: Scene) -> Parts:
    """Return a scene divided at every gap in a wall and at every saddle of the clearance."""
    gaps = find_gaps(scene.free & ~scene.lintel, _solid(scene), scene.cell_m)
    shut = _closed(scene, gaps)
    work = reduce_scene(shut)
    labels = merge_shallow(grow_basins(work), work)
    pieces = Pieces.of(labels, work.clearance, work.frontier, work.cell_m)
    return Parts(shut, work, labels, gaps, pieces, _lines(scene, shut, work, labels, gaps))


def _lines(
    scene: Scene, shut: Scene, work: WorkRaster, labels: Labels, gaps: list[Line]
) -> DividingLines:
    """Return all places where pieces meet, saddles first, with their features."""
    passable = shut.free & ~shut.lintel
    saddles = find_saddles_of_rooms(labels, work)
    ends = list(closing_lines(saddles, work, passable))
    pairs = [saddle.rooms for saddle in saddles]
    full = upsample_labels(labels, work.stride, passable)
    for opening in openings_across(gaps, full, scene.cell_m):
        if min(opening.rooms) > 0:
            ends.append(opening.ends_rc)
            pairs.append(opening.rooms)
    places = np.array(ends).reshape(-1, 2, 2)
    kinds = np.zeros((len(places), len(MAP_FIGURES)))
    kinds[len(saddles) :, 0] = 1.0
    kinds[:, 1:] = scene.wall is None, scene.has_scans, scene.sees_lintels
    figures = line_figures(places, _surroundings(scene))
    width_m = np.hypot(*(places[:, 1] - places[:, 0]).T) * scene.cell_m
    rooms = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return DividingLines(rooms, width_m, np.column_stack([figures, kinds]))


def _surroundings(scene: Scene) -> LineMasks:
    """Return the masks for line features; held rooms count as passable."""
    nothing = np.zeros_like(scene.solid)
    unseen, furniture, high = (
        nothing if mask is None else mask for mask in (scene.unseen, scene.furniture, scene.high)
    )
    return LineMasks(~scene.solid & ~unseen, unseen, furniture, high, scene.cell_m)


def _rooms_of(
    scene: Scene, parts: Parts, target: NDArray[np.int64]
) -> tuple[Labels, list[Opening]]:
    """Return labels and openings after pieces have merged into their ``target (P,)``."""
    _, number = np.unique(target, return_inverse=True)
    labels = looked_up(parts.labels, number.astype(np.int32))
    work = parts.work
    apart = upsample_labels(labels, work.stride, parts.scene.free & ~parts.scene.lintel)
    across = openings_across(parts.gaps, apart, scene.cell_m)
    shut = _closed(scene, [opening.ends_rc for opening in across])
    passable = shut.free & ~shut.lintel
    # Lines that divide nothing become free again: two cells wide, plus the blocks they lie in.
    full = upsample_labels(labels, work.stride, passable, work.stride + 2)
    return full, find_openings(labels, work, passable) + across


def _closed(scene: Scene, lines: list[Line]) -> Scene:
    """Return the scene closed along lines."""
    if not lines:
        return scene
    return scene.closed_along(closed_cells(scene.free.shape, lines) & scene.free)


def _solid(scene: Scene) -> Mask:
    """Return the cells (H, W) at which a gap may end."""
    return ~scene.free if scene.wall is None else ~scene.free & scene.wall
