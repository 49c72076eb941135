# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floorplan drawings to rooms and doors (paper, section III-A)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.errors import MapFormatError
from fpnet_core.io.outside import is_on_paper, outside_as_unknown
from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import (
    label_extents,
    label_figures,
    looked_up,
    pieces_of,
    reached_from_edge,
)
from fpnet_core.raster.windows import Window, border_of
from fpnet_core.segmentation.assemble import assemble, upsample_labels
from fpnet_core.segmentation.door_thresholds import doorway_symbols
from fpnet_core.segmentation.furniture import furniture_cells
from fpnet_core.segmentation.openings import Opening
from fpnet_core.segmentation.rooms import MIN_ROOM_AREA_M2, MIN_ROOM_WIDTH_M, cut_rooms
from fpnet_core.segmentation.scene import Scene
from fpnet_core.segmentation.strokes import erase_door_symbols
from fpnet_core.types import FREE, UNKNOWN, GridMap, Segmentation

# A closed space without a door that is smaller is no room;
# fitted to furnished drawings of generated storeys (notes/segmentation.md).
_MIN_SHUT_AREA_M2 = 3.0
# Physical: nobody walks where it is narrower. A closed space without a door that mostly is so is
# the hollow of a wall drawn as two lines, or a duct.
_MIN_SHUT_WIDTH_M = 0.6
# Doors of shut rooms, their leaves and windows beside them lie within [m]. Chosen.
_NEAR_SHUT_M = 2.0
# Numerical: a hectare at 2 cm has 25 million cells, and each costs some twenty bytes on the way.
_MAX_CELLS = 64_000_000
_CELL_M = 0.05
"""
Numerical: that of most robots' maps, and of the drawings that the model of doors has learned from.
Once symbols are gone, cells half as wide or less tell no more of rooms, and are taken together.
"""


def segment_floorplan(
    grid: GridMap, config: SegmentationConfig, metres_per_unit: float = 1.0
) -> Segmentation:
    """
    Cut a floorplan into rooms and doors, by default by a watershed of its clearance.

    Door symbols and free-standing obstacles are removed. The free space is cut at gaps between the
    ends of walls and at the saddles of the distance to the walls; pieces join where a learned
    model says that the line between them is more probably no door, and the lines that remain are
    the doors. Where the paper erodes the free space step by step [6], saddles say in one pass at
    which erosion two rooms would part.

    Parameters
    ----------
    grid : the drawing; unknown cells count as not free
    config : how it is cut
    metres_per_unit : true metres per nominal metre of the grid; results stay nominal

    Returns
    -------
    Segmentation; an empty one with a reason where there is nothing to segment. Its grid is the
    drawing with the paper around the building turned unknown.

    Raises
    ------
    MapFormatError
        If the grid is too large to be a storey.
    """
    if grid.cells.size > _MAX_CELLS:
        rows, cols = grid.shape
        raise MapFormatError(
            f'the grid has {cols} x {rows} cells; expected at most '
            f'{_MAX_CELLS // 1_000_000} million: crop it to the building or give it coarser cells'
        )
    cell_m = grid.resolution * metres_per_unit
    grid = replace(grid, cells=outside_as_unknown(grid.cells, cell_m))
    free = grid.cells == FREE
    if not free.any():
        return _empty(grid, 'the grid has no free cells')
    on_paper = is_on_paper(free)
    if free.all():
        return _empty(grid, 'the grid has no walls')
    is_default = config.method == 'default'
    step = max(1, int(_CELL_M / cell_m))
    scene = drawn_scene(free, cell_m, is_bare=not is_default)
    coarse = scene.coarser(step)
    if is_default and (shut := _shut_rooms(coarse, on_paper)) is not None:
        symbols = _symbols_around(shut, grid.cells, cell_m, step)
        if symbols.any():
            scene = drawn_scene(free | symbols, cell_m)
            coarse = scene.coarser(step)
    if step == 1:
        return _cut(grid, scene, config, on_paper, metres_per_unit)
    cells = np.zeros([-(-side // step) for side in grid.shape], dtype=np.int8)
    blocks = replace(grid, cells=cells, resolution=step * grid.resolution)
    found = _cut(blocks, coarse, config, on_paper, metres_per_unit)
    labels = upsample_labels(np.asarray(found.labels), step, scene.free)
    labels.setflags(write=False)  # or they would be copied
    return replace(found, grid=grid, labels=labels)


def _shut_rooms(scene: Scene, on_paper: bool) -> Window | None:
    """
    Return the window around all spaces of a room's size that no door leads to, with what is near.

    None where one space is all: doors lead from the largest to all others.
    """
    spaces, figures = pieces_of(scene.free, connectivity=4)
    is_room = _is_room(spaces, scene.clearance, scene.cell_m, on_paper)
    sizes = figures[:, 4]
    is_room &= sizes >= _MIN_SHUT_AREA_M2 / scene.cell_m**2
    is_room[np.argmax(np.where(is_room, sizes, 0))] = False
    if not is_room.any():
        return None
    near = round(_NEAR_SHUT_M / scene.cell_m)
    left, top, width, height, _ = figures[is_room].T
    return (
        slice(max(0, int(top.min()) - near), int((top + height).max()) + near),
        slice(max(0, int(left.min()) - near), int((left + width).max()) + near),
    )


def _symbols_around(shut: Window, cells: NDArray[np.int8], cell_m: float, step: int) -> Mask:
    """Return the symbols (H, W) that close doorways in a window of blocks of ``cells (H, W)``."""
    rows, cols = (slice(side.start * step, side.stop * step) for side in shut)
    free = cells[rows, cols] == FREE
    ink = ~free & ~reached_from_edge(cells == UNKNOWN)[rows, cols]
    symbols = np.zeros(cells.shape, np.bool_)
    symbols[rows, cols] = doorway_symbols(ink, free, cell_m)
    return symbols


def _cut(
    grid: GridMap, scene: Scene, config: SegmentationConfig, on_paper: bool, metres_per_unit: float
) -> Segmentation:
    """Cut a drawing's scene into rooms and doors; ``grid`` has its shape."""
    is_default, cell_m = config.method == 'default', scene.cell_m
    cut = cut_rooms(scene) if is_default else _cut_simply(scene, config.method)
    full, openings, clearance = cut
    is_room = _is_room(full, clearance, cell_m, on_paper)
    if is_default and openings:
        is_room &= ~_is_shut(full, openings, is_room, clearance, cell_m)
    return assemble(grid, _only(full, is_room), openings, metres_per_unit)


def drawn_scene(free: Mask, cell_m: float, is_bare: bool = False) -> Scene:
    """
    Return the scene of a drawing's free cells (H, W), door symbols and furniture taken away.

    ``is_bare`` leaves them; ``cell_m`` is the cell edge [true metres].
    """
    bare = free
    if not is_bare:
        bare = erase_door_symbols(free, cell_m)
        bare = bare | furniture_cells(bare, cell_m, is_drawn=True)
    blocked = ~bare if is_on_paper(free) else _framed(~bare)
    return Scene(bare, np.zeros_like(bare), blocked, cell_m, furniture=bare & ~free)


def _cut_simply(
    scene: Scene, method: str
) -> tuple[NDArray[np.int32], list[Opening], NDArray[np.float32]]:
    from fpnet_core.segmentation.simple import cut_rooms_simply  # loads scikit-image

    return *cut_rooms_simply(scene, method), scene.clearance


def _empty(grid: GridMap, reason: str) -> Segmentation:
    return Segmentation(grid, np.zeros(grid.shape, dtype=np.int32), (), (), reason)


def _framed(blocked: Mask) -> Mask:
    """Return ``blocked`` with the raster's outermost cells blocked as well."""
    framed = blocked.copy()
    framed[[0, -1], :] = True
    framed[:, [0, -1]] = True
    return framed


def _is_room(
    labels: NDArray[np.int32], clearance: NDArray[np.float32], cell_m: float, on_paper: bool
) -> Mask:
    """
    Tell which labels (R + 1,) are rooms.

    Not those that are small, that nobody fits into (the space between a wall's two drawn faces),
    or that are the paper around the drawing.
    """
    sizes, widest = label_figures(labels, clearance, int(labels.max(initial=0)) + 1)
    is_room = sizes >= MIN_ROOM_AREA_M2 / cell_m**2
    is_room &= 2.0 * widest >= MIN_ROOM_WIDTH_M
    if on_paper:
        is_room[np.unique(border_of(labels))] = False
    is_room[0] = False
    return np.asarray(is_room)


def _is_shut(
    labels: NDArray[np.int32],
    openings: list[Opening],
    is_room: Mask,
    clearance: NDArray[np.float32],
    cell_m: float,
) -> Mask:
    """
    Tell which labels (R + 1,) nobody can enter, and are no rooms for that.

    Small ones are tables, shafts and cupboards, narrow ones hollows of walls; one around all
    others is what lies between the building and the frame or the dimensions that are drawn
    around it.
    """
    is_shut = np.ones(len(is_room), dtype=np.bool_)
    is_shut[[room for opening in openings for room in opening.rooms]] = False
    ends, sizes, _ = label_extents(labels, len(is_room))
    is_small = sizes < _MIN_SHUT_AREA_M2 / cell_m**2
    is_narrow = _mean_widths(labels, clearance, len(is_room)) < _MIN_SHUT_WIDTH_M
    inner = ends[is_room & ~is_shut]
    is_around = (ends[:, :2] < inner[:, :2].min(axis=0, initial=labels.size)).all(axis=1)
    is_around &= (ends[:, 2:] > inner[:, 2:].max(axis=0, initial=0)).all(axis=1)
    return np.asarray(is_shut & (is_small | is_narrow | is_around))


def _mean_widths(
    labels: NDArray[np.int32], clearance: NDArray[np.float32], count: int
) -> NDArray[np.float64]:
    """
    Return how wide (count,) spaces are in the mean [m].

    A strip's cells are a quarter of its width away from its sides in the mean, whatever its turn.
    """
    sizes = np.bincount(labels.ravel(), minlength=count)
    sums = np.bincount(labels.ravel(), clearance.ravel(), minlength=count)
    return np.asarray(4.0 * sums / np.maximum(sizes, 1))


def _only(labels: NDArray[np.int32], is_kept: Mask) -> NDArray[np.int32]:
    """Return ``labels`` (H, W) that are kept, 0 in place of the others."""
    numbers = np.where(is_kept, np.arange(len(is_kept)), 0).astype(np.int32)
    return looked_up(labels, numbers)
