# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parse of drawings whose files state the elements of the building."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fpnet_core.drawings.model import FloorplanModel
from fpnet_core.drawings.model_raster import WALL_M, model_grid
from fpnet_core.drawings.plan_files import is_affine
from fpnet_core.drawings.stated import SaidScale
from fpnet_core.drawings.stated_rooms import stated_rooms
from fpnet_core.drawings.types import Array, Drawing, Reading, ReadOptions
from fpnet_core.types import FREE, GridMap

CELL_M = WALL_M / 4.0
"""Numerical: edge of a cell [m]; a partition is four cells thick."""
_MOST_CELLS = 4_000  # numerical: along the drawing; larger buildings get larger cells
_NAMES = {'geojson': 'GeoJSON', 'rmf': 'Open-RMF building'}
_FLOOR_M2 = 4.0  # physical: smallest floor area of a building


def model_reading(drawing: Drawing, options: ReadOptions) -> Reading | None:
    """
    Return the parse of a drawing whose model holds walls or rooms at a stated scale.

    None if the format has none, if there are no rooms and the walls do not close, or if the user
    selects a part of the sheet by ``storey``.
    """
    model = drawing.model
    said = SaidScale.of(drawing, options).at(np.eye(3), drawing.pixels.shape[:2])
    if model is None or not model.is_whole or said is None or options.storey is not None:
        return None
    scale, pixel_m = said
    H_plan_image = _upright(drawing, pixel_m)
    A = (H_plan_image @ np.vstack([drawing.A_pixel_image, [0.0, 0.0, 1.0]]))[:2]
    model = replace(model.moved(A), scale=scale, H_plan_image=H_plan_image)
    height, width = drawing.pixels.shape[:2]
    cell_m = max(CELL_M, pixel_m * max(height, width) / _MOST_CELLS)
    shape = tuple(int(np.ceil(side * pixel_m / cell_m)) for side in (height, width))
    grid = model_grid(model, cell_m, (shape[0], shape[1]))
    if options.crop is not None:
        left, top, right, bottom = (np.array(options.crop) * pixel_m / cell_m).round().astype(int)
        rows = slice(max(shape[0] - int(bottom), 0), shape[0] - int(top))
        grid = grid.cropped(rows, slice(int(left), int(right)))
    if np.count_nonzero(grid.cells == FREE) * cell_m**2 < _FLOOR_M2:
        return None
    return Reading(
        grid, scale, H_plan_image, _how(model, drawing), drawing,
        notes=(*drawing.notes, _counted(model)), doubts=drawing.doubts, model=model,
        cut=stated_rooms(model, grid) if model.rooms else None,
    )  # fmt: skip


def _upright(drawing: Drawing, pixel_m: float) -> Array:
    """Return the affine (3, 3) from pixels to metres, origin at the drawing's lower left."""
    height_m, half = drawing.pixels.shape[0] * pixel_m, 0.5 * pixel_m
    return np.array(
        [[pixel_m, 0.0, half], [0.0, -pixel_m, height_m - half], [0.0, 0.0, 1.0]]
    )  # integers are pixel centres


def _how(model: FloorplanModel, drawing: Drawing) -> str:
    floor = 'rooms' if model.rooms else 'the floor within walls'
    name = _NAMES.get(drawing.format, drawing.format.upper())
    return f'walls, doors and {floor} as the {name} states them'


def _counted(model: FloorplanModel) -> str:
    kinds = ('walls', 'doors', 'windows', 'rooms')
    counts = ', '.join(f'{len(getattr(model, kind))} {kind}' for kind in kinds)
    return f'the file states {counts}'


def placed_model(drawing: Drawing, grid: GridMap, H_plan_image: Array) -> FloorplanModel | None:
    """
    Return the elements stated by a drawing that was parsed from its image, in the map's frame.

    None if it states none within the map, or if perspective was removed.
    """
    if drawing.model is None or not is_affine(H_plan_image):
        return None
    A = (H_plan_image @ np.vstack([drawing.A_pixel_image, [0.0, 0.0, 1.0]]))[:2]
    model = replace(drawing.model.moved(A), H_plan_image=H_plan_image, is_whole=False)
    middles = [grid.xy_to_rc(door.ends.mean(axis=0)) for door in model.doors]
    doors = tuple(
        door
        for door, middle in zip(model.doors, middles, strict=True)
        if (middle > 0).all() and (middle < grid.shape).all()
    )
    return replace(model, doors=doors) if doors else None
