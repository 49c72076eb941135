# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Segmentation of floorplan drawings into rooms and doors (paper, section III-A)."""

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

# Smaller enclosed spaces without a door are no rooms;
# fitted to furnished drawings of generated storeys (notes/segmentation.md).
_MIN_ENCLOSED_AREA_M2 = 3.0
# Physical: too narrow for a person. An enclosed space without a door that is mostly narrower is
# the hollow of a wall drawn as two lines, or a duct.
_MIN_ENCLOSED_WIDTH_M = 0.6
# Doors of rooms without an opening, their leaves and adjacent windows lie within [m]. Chosen.
_NEAR_ENCLOSED_M = 2.0
# Numerical: a hectare at 2 cm has 25 million cells; the work needs about twenty bytes per cell.
_MAX_CELLS = 64_000_000
_CELL_M = 0.05
"""
Numerical: cell edge of most robot maps and of the drawings that the door model was trained on.
After the symbols are removed, cells of half this size or less are merged: they add nothing.
"""


def segment_floorplan(
    grid: GridMap, config: SegmentationConfig, metres_per_unit: float = 1.0
) -> Segmentation:
    """
    Segment a floorplan into rooms and doors, by default by a watershed of its clearance.

    Door symbols and free-standing obstacles are removed. The free space is divided at gaps between
    the ends of walls and at the saddles of the distance to the walls. Pieces merge where a learned
    model finds the line between them more probably no door; the remaining lines are the doors. The
    paper erodes the free space step by step [6]; saddles give the erosion at which two rooms
    separate in a single pass.

    Parameters
    ----------
    grid : the drawing; unknown cells count as not free
    config : segmentation method
    metres_per_unit : true metres per nominal metre of the grid; results stay nominal

    Returns
    -------
    Segmentation; an empty one with a reason if there is nothing to segment. Its grid is the
    drawing with the paper around the building set to unknown.

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
    if is_default and (window := _enclosed_rooms(coarse, on_paper)) is not None:
        symbols = _symbols_around(window, grid.cells, cell_m, step)
        if symbols.any():
            scene = drawn_scene(free | symbols, cell_m)
            coarse = scene.coarser(step)
    if step == 1:
        return _cut(grid, scene, config, on_paper, metres_per_unit)
    cells = np.zeros([-(-side // step) for side in grid.shape], dtype=np.int8)
    blocks = replace(grid, cells=cells, resolution=step * grid.resolution)
    found = _cut(blocks, coarse, config, on_paper, metres_per_unit)
    labels = upsample_labels(np.asarray(found.labels), step, scene.free)
    labels.setflags(write=False)  # Segmentation copies writable arrays
    return replace(found, grid=grid, labels=labels)


def _enclosed_rooms(scene: Scene, on_paper: bool) -> Window | None:
    """
    Return the window, with a margin, around all room-sized spaces without a door; or None.

    The largest space is not counted: doors connect it to all others.
    """
    spaces, figures = pieces_of(scene.free, connectivity=4)
    is_room = _is_room(spaces, scene.clearance, scene.cell_m, on_paper)
    sizes = figures[:, 4]
    is_room &= sizes >= _MIN_ENCLOSED_AREA_M2 / scene.cell_m**2
    is_room[np.argmax(np.where(is_room, sizes, 0))] = False
    if not is_room.any():
        return None
    near = round(_NEAR_ENCLOSED_M / scene.cell_m)
    left, top, width, height, _ = figures[is_room].T
    return (
        slice(max(0, int(top.min()) - near), int((top + height).max()) + near),
        slice(max(0, int(left.min()) - near), int((left + width).max()) + near),
    )


def _symbols_around(window: Window, cells: NDArray[np.int8], cell_m: float, step: int) -> Mask:
    """Return the symbols (H, W) that close doorways in a window of blocks of ``cells (H, W)``."""
    rows, cols = (slice(side.start * step, side.stop * step) for side in window)
    free = cells[rows, cols] == FREE
    ink = ~free & ~reached_from_edge(cells == UNKNOWN)[rows, cols]
    symbols = np.zeros(cells.shape, np.bool_)
    symbols[rows, cols] = doorway_symbols(ink, free, cell_m)
    return symbols


def _cut(
    grid: GridMap, scene: Scene, config: SegmentationConfig, on_paper: bool, metres_per_unit: float
) -> Segmentation:
    """Segment a drawing's scene into rooms and doors; ``grid`` has the same shape."""
    is_default, cell_m = config.method == 'default', scene.cell_m
    cut = cut_rooms(scene) if is_default else _segment_simply(scene, config.method)
    full, openings, clearance = cut
    is_room = _is_room(full, clearance, cell_m, on_paper)
    if is_default and openings:
        is_room &= ~_is_enclosed(full, openings, is_room, clearance, cell_m)
    return assemble(grid, _only(full, is_room), openings, metres_per_unit)


def drawn_scene(free: Mask, cell_m: float, is_bare: bool = False) -> Scene:
    """
    Return the scene of a drawing's free cells (H, W) without door symbols and furniture.

    ``is_bare`` keeps them; ``cell_m`` is the cell edge [true metres].
    """
    bare = free
    if not is_bare:
        bare = erase_door_symbols(free, cell_m)
        bare = bare | furniture_cells(bare, cell_m, is_drawn=True)
    blocked = ~bare if is_on_paper(free) else _framed(~bare)
    return Scene(bare, np.zeros_like(bare), blocked, cell_m, furniture=bare & ~free)


def _segment_simply(
    scene: Scene, method: str
) -> tuple[NDArray[np.int32], list[Opening], NDArray[np.float32]]:
    from fpnet_core.segmentation.simple import cut_rooms_simply  # for benchmarks only

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
    Return which labels (R + 1,) are rooms.

    Small labels, labels too narrow for a person (the space between a wall's two drawn faces) and
    the paper around the drawing are not.
    """
    sizes, widest = label_figures(labels, clearance, int(labels.max(initial=0)) + 1)
    is_room = sizes >= MIN_ROOM_AREA_M2 / cell_m**2
    is_room &= 2.0 * widest >= MIN_ROOM_WIDTH_M
    if on_paper:
        is_room[np.unique(border_of(labels))] = False
    is_room[0] = False
    return np.asarray(is_room)


def _is_enclosed(
    labels: NDArray[np.int32],
    openings: list[Opening],
    is_room: Mask,
    clearance: NDArray[np.float32],
    cell_m: float,
) -> Mask:
    """
    Return which labels (R + 1,) are inaccessible spaces and therefore no rooms.

    Small ones are tables, shafts and cupboards; narrow ones are hollows of walls. A space around
    all others lies between the building and a frame or dimensions drawn around it.
    """
    is_enclosed = np.ones(len(is_room), dtype=np.bool_)
    is_enclosed[[room for opening in openings for room in opening.rooms]] = False
    ends, sizes, _ = label_extents(labels, len(is_room))
    is_small = sizes < _MIN_ENCLOSED_AREA_M2 / cell_m**2
    is_narrow = _mean_widths(labels, clearance, len(is_room)) < _MIN_ENCLOSED_WIDTH_M
    inner = ends[is_room & ~is_enclosed]
    is_around = (ends[:, :2] < inner[:, :2].min(axis=0, initial=labels.size)).all(axis=1)
    is_around &= (ends[:, 2:] > inner[:, 2:].max(axis=0, initial=0)).all(axis=1)
    return np.asarray(is_enclosed & (is_small | is_narrow | is_around))


def _mean_widths(
    labels: NDArray[np.int32], clearance: NDArray[np.float32], count: int
) -> NDArray[np.float64]:
    """
    Return the mean width (count,) of spaces [m].

    In a strip of any orientation, the mean distance to its sides is a quarter of its width.
    """
    sizes = np.bincount(labels.ravel(), minlength=count)
    sums = np.bincount(labels.ravel(), clearance.ravel(), minlength=count)
    return np.asarray(4.0 * sums / np.maximum(sizes, 1))


def _only(labels: NDArray[np.int32], is_kept: Mask) -> NDArray[np.int32]:
    """Return the kept ``labels`` (H, W), 0 in place of the others."""
    numbers = np.where(is_kept, np.arange(len(is_kept)), 0).astype(np.int32)
    return looked_up(labels, numbers)
