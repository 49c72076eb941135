# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader of Open-RMF buildings: walls, doors and floors of a level from the traffic editor.

Vertices are pixels of the level's drawing (y down), or metres (y up); measurements give the scale
of a pixel. A site reads the drawing that a level names; this module reads the level's own lines.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.drawings.formats.model_page import choose_storey, page_of
from fpnet_core.drawings.formats.pages import Array, VectorPage
from fpnet_core.drawings.model import (
    DoorKind,
    FloorplanModel,
    ModelDoor,
    ModelStorey,
    ModelWall,
    ModelWindow,
)
from fpnet_core.drawings.model_raster import rectangle
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.plain_yaml import MAX_BYTES, parse_yaml

WALL_M = 0.2
"""Thickness of walls, which are centre lines in the file [m]. Chosen."""

_LARGEST_PX = 1e9  # numerical: largest coordinate of a vertex [pixels]
_LARGEST_M = 1e6  # physical: largest distance of a building from its origin
_SOURCE = 'Open-RMF'
_METRES = ('cartesian_meters', 'cartesian_metres')  # given: coordinate systems in metres
_PIXELS = ('', 'reference_image')  # given: in pixels
_KINDS = {
    'hinged': DoorKind.SWING, 'double_hinged': DoorKind.DOUBLE, 'sliding': DoorKind.SLIDING,
    'double_sliding': DoorKind.SLIDING, 'double_telescope': DoorKind.SLIDING,
}  # fmt: skip


def load_libraries() -> None:
    """Do nothing: this reader needs no further libraries."""


def read_rmf(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return a level of a building: ``options.page`` from below, else the one with most walls.

    Raises
    ------
    MapFormatError
        If the file is malformed or too large, has no walls, lacks the level or its scale.
    """
    if path.stat().st_size > MAX_BYTES:
        raise MapFormatError(f'{path.name} is too large: expected at most {MAX_BYTES} bytes')
    try:
        values = parse_yaml(path.read_text(encoding='utf-8'))
        levels = [(str(name), dict(level)) for name, level in values['levels'].items()]
        levels.sort(key=lambda each: float(each[1].get('elevation') or 0.0))
        counts = [len(level.get('walls') or ()) for _, level in levels]
        system = str(values.get('coordinate_system') or '')
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise MapFormatError(
            f'{path.name} is a damaged building of Open-RMF ({detail_of(error)}); save it again '
            'in the traffic editor'
        ) from None
    if system not in (*_PIXELS, *_METRES):
        raise MapFormatError(
            f'{path.name}: coordinate_system {system!r} is unknown; expected pixels of a drawing '
            'or metres'
        )
    if not any(counts):
        raise MapFormatError(f'{path.name} has no walls; draw some in the traffic editor')
    number, notes = choose_storey(path.name, [name for name, _ in levels], counts, options)
    storeys = tuple(
        ModelStorey(name, float(level.get('elevation') or 0.0)) for name, level in levels
    )
    name, level = levels[number]
    try:
        model = _model(level, system in _METRES, storeys, number)
    except MapFormatError as error:
        raise MapFormatError(f'{path.name}: level {name!r}: {error}') from None
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        raise MapFormatError(
            f'{path.name}: level {name!r} is damaged ({detail_of(error)}); save it again in the '
            'traffic editor'
        ) from None
    return page_of(path.name, model, notes)


def _model(
    level: dict[str, Any], in_metres: bool, storeys: tuple[ModelStorey, ...], number: int
) -> FloorplanModel:
    points = vertices_of(level)
    if not in_metres:
        points = points * (1.0, -1.0) * metres_per_pixel(level, points)
    if not (np.abs(points) < _LARGEST_M).all():
        raise MapFormatError(f'it has vertices more than {_LARGEST_M:g} m from the origin')
    lines = [(ends_of(wall, points), told_of(wall)) for wall in level.get('walls') or ()]
    lines = [(ends, told) for ends, told in lines if (ends[0] != ends[1]).any()]
    walls = [
        ModelWall((_thick(ends),), source=_SOURCE)
        for ends, told in lines
        if float(told.get('alpha', 1.0)) >= 1.0
    ]
    panes = [
        ModelWindow(ends, WALL_M, source=_SOURCE)
        for ends, told in lines
        if float(told.get('alpha', 1.0)) < 1.0
    ]
    doors = [_door(each, points) for each in level.get('doors') or ()]
    floors = [points[list(map(int, floor['vertices']))] for floor in level.get('floors') or ()]
    return FloorplanModel(
        walls=tuple(walls),
        doors=tuple(doors),
        windows=tuple(panes),
        outline=tuple(floor for floor in floors if len(floor) > 2),
        storeys=storeys,
        storey=number,
    )


def vertices_of(level: dict[str, Any]) -> Array:
    """
    Return a level's vertices ``(N, 2)`` in its own units.

    Raises
    ------
    MapFormatError
        If one is invalid.
    """
    told = level.get('vertices') or []
    try:
        points = np.array([vertex[:2] for vertex in told], np.float64).reshape(len(told), 2)
    except (ValueError, TypeError, KeyError, OverflowError) as error:
        raise MapFormatError(f'its vertices are damaged ({detail_of(error)})') from None
    if not (np.abs(points) < _LARGEST_PX).all():
        raise MapFormatError('it has vertices with invalid coordinates')
    return points


def metres_per_pixel(level: dict[str, Any], points: Array) -> float:
    """
    Return the mean scale of a level's measurements between its vertices.

    Raises
    ------
    MapFormatError
        If there is none, or one is invalid.
    """
    scales = []
    for each in level.get('measurements') or ():
        ends = ends_of(each, points)
        length = float(np.hypot(*(ends[1] - ends[0])))
        try:
            metres = float(told_of(each)['distance'])
        except (KeyError, TypeError, ValueError, OverflowError):
            metres = math.nan
        if not (0.0 < metres < _LARGEST_M and length > 0.0):
            raise MapFormatError(f'it has a measurement of {metres:g} m over {length:g} pixels')
        scales.append(metres / length)
    if not scales:
        raise MapFormatError(
            'it has no measurement for the scale of its pixels; add one in the traffic editor'
        )
    return float(np.mean(scales))


def ends_of(edge: Any, points: Array) -> Array:
    """
    Return the positions (2, 2) of the two vertices of an edge.

    Raises
    ------
    MapFormatError
        If there are no such vertices.
    """
    try:
        first, second = int(edge[0]), int(edge[1])
    except (ValueError, TypeError, KeyError, IndexError, OverflowError):
        raise MapFormatError('it has an edge without two vertices') from None
    if not (0 <= first < len(points) and 0 <= second < len(points)):
        raise MapFormatError(
            f'it has an edge from vertex {first} to {second}, but only {len(points)} vertices'
        )
    return points[[first, second]]


def told_of(edge: Any) -> dict[str, Any]:
    """Return the parameters of an edge, stored as [type, value]."""
    told = edge[2] if len(edge) > 2 and isinstance(edge[2], dict) else {}
    return {key: each[1] if isinstance(each, list) else each for key, each in told.items()}


def _thick(ends: Array) -> Array:
    """Return the corners (4, 2) of a wall, extended by half its thickness at both ends."""
    along = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    longer = ends + 0.5 * WALL_M * np.array([-along, along])
    return rectangle(ModelWindow(longer, WALL_M))


def _door(edge: Any, points: Array) -> ModelDoor:
    told = told_of(edge)
    kind = _KINDS.get(str(told.get('type')), DoorKind.UNKNOWN)
    hinge = None
    if kind is DoorKind.SWING:
        hinge = int(str(told.get('motion_axis')) == 'end')
    name = str(told.get('name') or '')
    return ModelDoor(ends_of(edge, points), WALL_M, kind, hinge, name=name, source=_SOURCE)
