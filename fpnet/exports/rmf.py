# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Export of a floorplan model as an Open-RMF building with one level.

Positions are metres or, with a picture of the level, its pixels, as the traffic editor has them:
from the upper left corner of the picture, x right, y down. A robot map is then a layer over it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from fpnet.exports.solids import wall_lines
from fpnet_core.drawings.model import DoorKind, FloorplanModel
from fpnet_core.drawings.types import Array
from fpnet_core.geometry.polar import heading_of, scale_of

WALL_M = 0.2
"""Thickness of walls in Open-RMF [m]. Chosen."""

_DIGITS = 4  # numerical: of metres
_TEXT, _WHOLE, _NUMBER = 1, 2, 3  # given: types of parameters
_DOORS = {
    DoorKind.DOUBLE: 'double_hinged', DoorKind.SLIDING: 'sliding', DoorKind.FOLDING: 'sliding',
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class RmfLayer:
    """
    A robot map over the picture of a level.

    ``filename`` is relative to the building's file. ``A_level_pixel (2, 3)`` is a similarity from
    pixels of that image, counted as those of the picture, to metres of the level, y down.
    """

    filename: str
    A_level_pixel: Array

    def as_yaml(self) -> dict[str, Any]:
        """Return the layer as the traffic editor stores it."""
        linear, (x, y) = self.A_level_pixel[:, :2], self.A_level_pixel[:, 2].tolist()
        # The editor's yaw is counter-clockwise as seen, and y points down.
        yaw, scale = -float(heading_of(linear)), float(scale_of(linear))
        transform = {'yaw': yaw, 'scale': scale, 'translation_x': x, 'translation_y': y}
        return {'filename': self.filename, 'visible': True, 'transform': transform}


@dataclass(frozen=True, eq=False)
class RmfPicture:
    """
    Picture of a level, with a robot map as a layer.

    Parameters
    ----------
    filename : image, relative to the building's file
    A_pixel_plan : (2, 3) similarity from the model's metres to its pixels
    metres_per_pixel, width_px : scale and width of the picture
    layers : robot maps by name
    """

    filename: str
    A_pixel_plan: Array
    metres_per_pixel: float
    width_px: int
    layers: dict[str, RmfLayer]


def write_rmf(
    model: FloorplanModel, path: Path, name: str, picture: RmfPicture | None = None
) -> None:
    """
    Write a ``*.building.yaml``; walls are lines, to which Open-RMF adds the thickness.

    The model is in metres. With a picture, positions are written in its pixels.
    """
    vertices, wall = _Vertices(), WALL_M
    if picture is not None:
        model = model.moved(picture.A_pixel_plan)
        wall = WALL_M / picture.metres_per_pixel
    walls = [
        [*vertices.ends(line), {'alpha': [_NUMBER, 1.0], 'texture_name': [_TEXT, 'default']}]
        for line in wall_lines(model, wall)
    ]
    doors = [
        [*vertices.ends(door.ends), {
            'name': [_TEXT, door.name or f'door {number}'],
            'type': [_TEXT, _DOORS.get(door.kind, 'hinged')],
            'motion_axis': [_TEXT, 'end' if door.hinge == 1 else 'start'],
            'motion_degrees': [_NUMBER, 90.0],
            'motion_direction': [_WHOLE, 1],
        }]
        for number, door in enumerate(model.doors, 1)
    ]  # fmt: skip
    floors = [
        {'parameters': {}, 'vertices': [vertices.number(place) for place in room.rings[0]]}
        for room in model.rooms
    ]
    storey = model.storeys[model.storey] if model.storey is not None else None
    level: dict[str, Any] = {
        'elevation': float(storey.elevation_m or 0.0) if storey is not None else 0.0,
        'vertices': vertices.places, 'walls': walls, 'doors': doors, 'floors': floors,
        'lanes': [], 'measurements': [], 'models': [],
    }  # fmt: skip
    if picture is not None:
        edge = np.array([[0.0, 0.0], [picture.width_px, 0.0]])
        metres = picture.width_px * picture.metres_per_pixel
        level |= {
            'drawing': {'filename': picture.filename},
            'measurements': [[*vertices.ends(edge), {'distance': [_NUMBER, metres]}]],
            'layers': {key: layer.as_yaml() for key, layer in picture.layers.items()},
        }
    building = {
        'name': name,
        'coordinate_system': 'cartesian_meters' if picture is None else 'reference_image',
        'levels': {storey.name if storey is not None else 'L1': level}, 'lifts': {},
    }  # fmt: skip
    text = yaml.safe_dump(building, default_flow_style=None, sort_keys=False, width=100)
    path.write_text(text, encoding='utf-8')


class _Vertices:
    """Unique vertices of a level."""

    def __init__(self) -> None:
        self.places: list[list[Any]] = []
        self._numbers: dict[tuple[float, float], int] = {}

    def number(self, place: Array) -> int:
        """Return the index of a vertex (2,), which is added if new."""
        x, y = (round(float(each), _DIGITS) + 0.0 for each in place)
        if (x, y) not in self._numbers:
            self._numbers[x, y] = len(self.places)
            self.places.append([x, y, 0.0, ''])
        return self._numbers[x, y]

    def ends(self, line: Array) -> list[int]:
        """Return the vertex indices of both ends of a line (2, 2)."""
        return [self.number(np.asarray(end)) for end in line]
