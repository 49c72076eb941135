# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The core that floorplans and submaps share: from a clean scene to labelled rooms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.segmentation.assemble import upsample_labels
from fpnet_core.segmentation.basins import grow_basins, merge_basins
from fpnet_core.segmentation.corridors import is_corridor_frame
from fpnet_core.segmentation.gaps import closed_cells, find_gaps, openings_across
from fpnet_core.segmentation.openings import (
    Opening,
    Saddle,
    closing_line,
    find_openings,
    find_saddles_of_rooms,
)
from fpnet_core.segmentation.scene import Scene, WorkRaster, reduce_scene

# Smaller rooms join the neighbour with the widest opening;
# fitted to the tune half (docs/segmentation.md).
MIN_ROOM_AREA_M2 = 1.5
# Narrower openings are doors even where nothing widens behind;
# fitted to the tune half (docs/segmentation.md).
SURE_WIDTH_M = 1.2
# How far from an opening both rooms must have widened;
# fitted to the tune half (docs/segmentation.md).
_JAMB_REACH_M = 1.0
# By which factor they must have widened to be rooms;
# fitted to the tune half (docs/segmentation.md).
_JAMB_WIDENING = 1.1

# Numerical: joining rooms changes what their neighbours look like; it settles within so many
# rounds.
_MAX_ROUNDS = 4

IsDoor = Callable[[Saddle, NDArray[np.int32], WorkRaster], bool]


def cut_rooms(scene: Scene) -> tuple[NDArray[np.int32], list[Opening], Scene]:
    """
    Label the rooms of a scene and find the openings between them.

    Parameters
    ----------
    scene : free space and closed doorways; where it has a ``wall``, openings must touch
        it: between two unseen places lies the ragged edge of what was seen, not a door

    Returns
    -------
    labels (H, W) int32 : 1..R, 0 where there is no room
    openings : between these labels; saddles first, widest first, then gaps in walls
    scene : with the gaps in walls closed
    """
    gaps = find_gaps(scene.free & ~scene.lintel, _solid(scene), scene.cell_m)
    if gaps:
        scene = scene.closed_along(closed_cells(scene.free.shape, gaps) & scene.free)
    work = reduce_scene(scene)
    labels = merge_basins(grow_basins(work), work, MIN_ROOM_AREA_M2)
    passable = scene.free & ~scene.lintel

    def is_door(saddle: Saddle, labels: NDArray[np.int32], work: WorkRaster) -> bool:
        if not _has_jambs(saddle, labels, work):
            return False
        ends = closing_line(saddle, work, passable)
        if is_corridor_frame(ends, passable, scene.cell_m):
            return False
        return scene.wall is None or _is_anchored(ends, scene.wall)

    labels = _join_across(labels, work, is_door)
    openings = find_openings(labels, work, passable)
    full = upsample_labels(labels, work.stride, passable)
    return full, openings + openings_across(gaps, full, scene.cell_m), scene


def _solid(scene: Scene) -> Mask:
    """Return the cells (H, W) at which a gap may end."""
    return ~scene.free if scene.wall is None else ~scene.free & scene.wall


def _join_across(
    labels: NDArray[np.int32], work: WorkRaster, is_door: IsDoor
) -> NDArray[np.int32]:
    """Return ``labels (h, w)`` with rooms joined wherever one of their openings is no door."""
    for _ in range(_MAX_ROUNDS):
        target = np.arange(int(labels.max(initial=0)) + 1, dtype=np.int32)
        for saddle in find_saddles_of_rooms(labels, work):
            a, b = (int(target[room]) for room in saddle.rooms)
            if a != b and not is_door(saddle, labels, work):
                target[target == max(a, b)] = min(a, b)
        if (target == np.arange(len(target))).all():
            break
        labels = target[labels]
    return labels


def _has_jambs(saddle: Saddle, labels: NDArray[np.int32], work: WorkRaster) -> bool:
    """
    Tell whether the free space widens on both sides of an opening, as it does at a door.

    The neck between two bulges of a corridor stays as narrow as its saddle. Openings below
    ``SURE_WIDTH_M`` are taken for doors without this test.
    """
    if 2.0 * saddle.clearance_m < SURE_WIDTH_M:
        return True
    reach = _JAMB_REACH_M / work.cell_m
    row, col = saddle.rc
    size = int(np.ceil(reach))
    window = np.s_[max(0, row - size) : row + size + 1, max(0, col - size) : col + size + 1]
    near, clearance = labels[window], work.clearance[window]
    rows, cols = np.ogrid[: near.shape[0], : near.shape[1]]
    disc = np.hypot(rows + window[0].start - row, cols + window[1].start - col) <= reach
    widest = (float(clearance[disc & (near == room)].max(initial=0.0)) for room in saddle.rooms)
    return min(widest) >= _JAMB_WIDENING * saddle.clearance_m


def _is_anchored(ends_rc: NDArray[np.float64], wall: Mask) -> bool:
    """Tell whether an end of a line lies on ``wall (H, W)``."""
    cells = np.clip(np.rint(ends_rc).astype(np.int64), 0, np.array(wall.shape) - 1)
    return bool(wall[cells[:, 0], cells[:, 1]].any())
