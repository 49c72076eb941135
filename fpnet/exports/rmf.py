# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Export of a floorplan model as an Open-RMF building in metres with one level."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from fpnet.exports.solids import wall_lines
from fpnet_core.drawings.model import DoorKind, FloorplanModel
from fpnet_core.drawings.types import Array

WALL_M = 0.2
"""Thickness of walls in Open-RMF [m]. Chosen."""

_DIGITS = 4  # numerical: of metres
_TEXT, _NUMBER = 1, 3  # given: types of parameters
_DOORS = {
    DoorKind.DOUBLE: 'double_hinged', DoorKind.SLIDING: 'sliding', DoorKind.FOLDING: 'sliding',
}  # fmt: skip


def write_rmf(model: FloorplanModel, path: Path, name: str) -> None:
    """Write a ``*.building.yaml``; walls are lines, to which Open-RMF adds the thickness."""
    vertices = _Vertices()
    walls = [
        [*vertices.ends(line), {'alpha': [_NUMBER, 1.0], 'texture_name': [_TEXT, 'default']}]
        for line in wall_lines(model, WALL_M)
    ]
    doors = [
        [*vertices.ends(door.ends), {
            'name': [_TEXT, door.name or f'door {number}'],
            'type': [_TEXT, _DOORS.get(door.kind, 'hinged')],
            'motion_axis': [_TEXT, 'end' if door.hinge == 1 else 'start'],
            'motion_degrees': [_NUMBER, 90.0],
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
    building = {
        'name': name, 'coordinate_system': 'cartesian_meters',
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
