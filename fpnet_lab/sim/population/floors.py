# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelled storeys as rasters, the common format for generated and real storeys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import MapFormatError
from fpnet_core.types import FREE, GridMap
from fpnet_lab.sim.drawn.render import door_outline, fill_polygons, render_plan
from fpnet_lab.sim.types import BuildingPlan

CELL_M = 0.05
"""Given: cell edge of the real drawings and of the generated ones."""

FREE_GREY = 250
"""Given: minimum brightness of floor pixels in a real drawing."""

TUNE_FLOORS = (
    'lab_a_scan',
    'lab_c_scan',
    'lab_ipa',
    'NLB',
    'office_a',
    'office_b',
    'office_c',
    'office_d',
    'office_e',
    'Freiburg52_scan',
)
"""Hand-labelled real storeys of the development split, used to choose parameters."""


@dataclass(frozen=True, eq=False)
class LabelledFloor:
    """
    Raster of a storey's rooms with cells of ``CELL_M``.

    ``labels (H, W) int32`` is 1 and up inside rooms and 0 elsewhere, including doorways;
    ``free (H, W) bool`` marks floor, including doorways.
    """

    name: str
    labels: NDArray[np.int32]
    free: NDArray[np.bool_]


def floor_of_plan(plan: BuildingPlan, name: str) -> LabelledFloor:
    """Return a generated storey with labels in the style of hand labels."""
    grid = render_plan(plan, CELL_M)
    return LabelledFloor(name, room_labels(plan, grid), grid.cells == FREE)


def room_labels(plan: BuildingPlan, grid: GridMap) -> NDArray[np.int32]:
    """
    Return ground truth room labels (H, W) on a drawing without rotation and stretch.

    Labels are 1 and up, 0 outside and in doorways; all pieces of a corridor are one room.
    """
    labels = np.zeros(grid.shape, np.int32)
    origin = np.array([grid.T_frame_grid.x, grid.T_frame_grid.y])
    for label, rings in enumerate(room_rings(plan), start=1):
        fill_polygons(labels, [(ring - origin) / grid.resolution for ring in rings], label)
    return labels


def room_rings(plan: BuildingPlan) -> list[list[NDArray[np.float64]]]:
    """Return the polygons (V, 2) [m] that cover each room; a corridor may have several."""
    rooms = []
    for part in plan.joined_rooms():
        rings = [plan.rooms[i].polygon for i in part]
        rings += [
            door_outline(door, plan.wall_m, plan.wall_m)
            for door in plan.doors
            if door.is_open and door.rooms[0] in part
        ]
        rooms.append(rings)
    return rooms


def read_image(path: Path, flag: int = cv2.IMREAD_GRAYSCALE) -> NDArray[Any]:
    """
    Return an image of the shared data, row 0 at the top, read with OpenCV's ``flag``.

    Raises
    ------
    MapFormatError
        If it is missing or not an image.
    """
    image = cv2.imread(str(path), flag) if path.is_file() else None
    if image is None:
        raise MapFormatError(f'{path} is missing or not an image; pass the folder that holds it')
    return np.asarray(image)


def read_labels(path: Path) -> NDArray[np.int32]:
    """Return hand-drawn room labels (H, W), row 0 at the lowest y, 0 outside."""
    return read_image(path, cv2.IMREAD_UNCHANGED)[::-1].astype(np.int32)


def read_floors(folder: Path, names: Sequence[str] = TUNE_FLOORS) -> list[LabelledFloor]:
    """
    Read hand-labelled storeys: ``folder/floorplan/NAME.png`` and ``folder/room_labels/NAME.png``.

    Raises
    ------
    MapFormatError
        If an image is missing, or if drawing and labels differ in size.
    """
    return [_read_floor(folder, name) for name in names]


def _read_floor(folder: Path, name: str) -> LabelledFloor:
    grey = read_image(folder / 'floorplan' / f'{name}.png')
    labels = read_labels(folder / 'room_labels' / f'{name}.png')[::-1]
    if grey.shape != labels.shape:
        raise MapFormatError(
            f'{name}: the drawing has {grey.shape} cells, its labels have {labels.shape}; '
            'they must have one size'
        )
    return LabelledFloor(name, labels, grey >= FREE_GREY)
