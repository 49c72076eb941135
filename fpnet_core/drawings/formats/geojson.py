# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader of GeoJSON and IMDF: units are rooms, openings are doors, levels are storeys.

Input is a file of features, a folder of such files, or a ZIP of one. Longitudes and latitudes
become metres about the building, x east and y north.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.drawings.formats.geojson_files import feature_files
from fpnet_core.drawings.formats.model_page import choose_storey, page_of
from fpnet_core.drawings.formats.pages import Array, VectorPage
from fpnet_core.drawings.geodesy import LocalMetres
from fpnet_core.drawings.model import (
    DoorKind,
    FloorplanModel,
    ModelDoor,
    ModelRoom,
    ModelStorey,
    ModelWall,
)
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError

_SOURCE = 'GeoJSON'
_DEGREES = (180.0, 90.0)  # given: largest longitude and latitude
_LARGEST_DEG = 0.5  # physical: 55 km; larger extents are metres of a projected grid
_LARGEST = 1e8  # physical: largest coordinate of a projected grid on Earth [m]
_FAR_M = 0.6  # physical: from a door's middle to its rooms' edges, at most half a thick wall
# Given: categories of IMDF units that are solid, and of those without floor.
_SOLID = frozenset({'structure', 'column', 'brick', 'concrete', 'drywall', 'glass', 'wood'})
_NO_FLOOR = frozenset({'opentobelow', 'nonpublic'})
_KINDS = {
    'swinging': DoorKind.SWING, 'sliding': DoorKind.SLIDING, 'revolving': DoorKind.REVOLVING,
    'open': DoorKind.OPENING, 'movablepartition': DoorKind.FOLDING, 'door': DoorKind.UNKNOWN,
}  # fmt: skip
_INDOOR = {'room': 'unit', 'corridor': 'unit', 'area': 'unit', 'wall': 'wall', 'level': 'level'}


@dataclass(frozen=True, eq=False)
class _Feature:
    """A feature: its ``kind`` (``unit``, ``opening``, ...), its lines in file coordinates."""

    id: str
    kind: str
    parts: tuple[tuple[Array, ...], ...]
    properties: dict[str, Any]

    @property
    def level(self) -> str:
        """Key of its level; empty if not stated."""
        value = self.properties.get('level_id', self.properties.get('level'))
        return '' if value is None or isinstance(value, dict | list) else str(value)

    @property
    def category(self) -> str:
        """Its use as named in the file."""
        return str(self.properties.get('category') or self.properties.get('room') or '')


def load_libraries() -> None:
    """Import the libraries of this reader before the process is restricted."""
    import zipfile
    import zlib  # noqa: F401

    zipfile.ZipFile  # noqa: B018, the module is loaded


def read_geojson(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return a level of a GeoJSON or IMDF: ``options.page`` from below, else the largest one.

    Raises
    ------
    MapFormatError
        If the file is damaged or too large, holds no rooms or walls, or lacks the level.
    """
    features = [
        feature for stem, values in feature_files(path) for feature in _features(stem, values)
    ]
    levels = _levels(features)
    elements = [each for each in features if each.kind in ('unit', 'opening', 'wall')]
    counts = [sum(each.level == key for each in elements) for key, _ in levels]
    if not any(counts):
        raise MapFormatError(
            f'{path.name} has no units: expected rooms as in IMDF, polygons of feature_type unit'
        )
    number, note = choose_storey(path.name, [level.name for _, level in levels], counts, options)
    chosen = [each for each in features if levels[number][0] in (each.level, each.id)]
    metres, more = _metres(chosen, path.name)
    model = _model(metres, tuple(level for _, level in levels), number)
    return page_of(path.name, model, [*note, *more])


def _features(stem: str, values: Any) -> list[_Feature]:
    """Return the features of a file that have lines, and all levels."""
    found = values.get('features') if isinstance(values, dict) else None
    if not isinstance(found, list):
        found = [values]
    features = []
    for each in found:
        geometry = each.get('geometry') if isinstance(each, dict) else None
        properties = each.get('properties') if isinstance(each, dict) else None
        properties = properties if isinstance(properties, dict) else {}
        parts = _parts(geometry) if isinstance(geometry, dict) else ()
        kind = _kind(stem, each, properties, geometry) if isinstance(each, dict) else ''
        if parts or kind == 'level':
            features.append(_Feature(str(each.get('id', '')), kind, parts, properties))
    return features


def _kind(stem: str, feature: dict[str, Any], properties: dict[str, Any], geometry: Any) -> str:
    """Return the kind of a feature: as stated, by the name of its file, or by its geometry."""
    stated_type = feature.get('feature_type') or properties.get('feature_type')
    if stated_type:
        return str(stated_type).lower()
    if stem in ('unit', 'opening', 'level', 'footprint', 'venue', 'building'):
        return stem
    indoor = _INDOOR.get(str(properties.get('indoor')))
    if indoor:
        return indoor
    shape = str(geometry.get('type')) if isinstance(geometry, dict) else ''
    if 'door' in properties or str(properties.get('type')) == 'door':
        return 'opening'
    return 'unit' if 'Polygon' in shape else 'wall' if 'LineString' in shape else ''


def _parts(geometry: dict[str, Any]) -> tuple[tuple[Array, ...], ...]:
    """Return the lines of each part of a geometry; rings are open, the exterior first."""
    places, kind = geometry.get('coordinates'), geometry.get('type')
    if not isinstance(places, list):
        return ()
    parts = {
        'Polygon': [places], 'MultiPolygon': places, 'LineString': [[places]],
        'MultiLineString': [[line] for line in places],
    }.get(str(kind), [])  # fmt: skip
    found = []
    for part in parts:
        lines = [_line(line) for line in part] if isinstance(part, list) else []
        if 'Polygon' in str(kind):
            lines = [line[:-1] if (line[0] == line[-1]).all() else line for line in lines
                     if len(line)]  # fmt: skip
        if lines and all(len(line) > (2 if 'Polygon' in str(kind) else 1) for line in lines):
            found.append(tuple(lines))
    return tuple(found)


def _line(line: Any) -> Array:
    """Return the points ``(N, 2)`` of a line; none if one of them is invalid."""
    try:
        points = np.array([(float(place[0]), float(place[1])) for place in line])
    except (TypeError, ValueError, IndexError, KeyError, OverflowError):
        return np.empty((0, 2))
    is_place = points.size > 0 and (np.abs(points) < _LARGEST).all()
    return points if is_place else np.empty((0, 2))


def _levels(features: list[_Feature]) -> list[tuple[str, ModelStorey]]:
    """Return the levels, lowest first, with the keys that features refer to."""
    stated = [
        (_ordinal(each.properties.get('ordinal')), text_of(each.properties.get('name')), each)
        for each in features
        if each.kind == 'level'
    ]
    found = [
        (each.id or each.level, ModelStorey(name or f'level {ordinal:g}', _height(each)))
        for ordinal, name, each in sorted(stated, key=lambda known: known[:2])
    ]
    keys = {key for key, _ in found}
    others = {each.level for each in features if each.kind in ('unit', 'opening', 'wall')} - keys
    return found + [
        (key, ModelStorey(key or 'only level')) for key in sorted(others, key=_ordinal)
    ]


def _ordinal(value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        return 0.0
    return number if np.isfinite(number) else 0.0


def _height(level: _Feature) -> float | None:
    value = level.properties.get('elevation')
    return None if value is None else _ordinal(value)


def text_of(value: Any) -> str:
    """Return a label as text; of several languages English or the first one."""
    if isinstance(value, dict):
        value = value.get('en') or next(iter(value.values()), '')
    return '' if value is None or isinstance(value, dict | list) else str(value).strip()


def _metres(features: list[_Feature], name: str) -> tuple[list[_Feature], list[str]]:
    """Return features in metres, projected about their centre if in degrees, and notes."""
    points = np.concatenate([line for each in features for part in each.parts for line in part])
    low, high = points.min(axis=0), points.max(axis=0)
    if (high - low).max() > _LARGEST_DEG:
        note = 'its coordinates span more than half a degree and were taken for metres'
        return features, [note]
    if (np.abs(points) > _DEGREES).any():
        raise MapFormatError(
            f'{name} has coordinates that are no longitudes and latitudes but span less than '
            'half a metre; export it in WGS 84 as in IMDF'
        )
    longitude, latitude = 0.5 * (low + high)
    about = LocalMetres(float(longitude), float(latitude))
    note = f'metres to the east and north of longitude {longitude:.7f}, latitude {latitude:.7f}'
    return [
        replace(each, parts=tuple(tuple(map(about.to_metres, part)) for part in each.parts))
        for each in features
    ], [note]


def _model(
    features: list[_Feature], storeys: tuple[ModelStorey, ...], number: int
) -> FloorplanModel:
    rooms: list[ModelRoom] = []
    walls: list[ModelWall] = []
    for each in features:
        if each.kind == 'unit' and each.category in _SOLID:
            walls.extend(ModelWall(part, source=_SOURCE) for part in each.parts)
        elif each.kind == 'unit' and each.category not in _NO_FLOOR:
            name = text_of(each.properties.get('name') or each.properties.get('ref'))
            area = _ordinal(each.properties.get('area_m2')) or None
            rooms.extend(
                ModelRoom(part, name, area if area and area > 0.0 else None, each.category,
                          source=_SOURCE)
                for part in each.parts
            )  # fmt: skip
        elif each.kind == 'wall':
            walls.extend(
                ModelWall(part, source=_SOURCE) for part in each.parts if len(part[0]) > 2
            )
    edges = [edges_of(ring) for room in rooms for ring in room.rings[:1]]
    doors = [
        _door(part[0], each, edges)
        for each in features
        for part in each.parts
        if each.kind == 'opening' and (part[0][0] != part[0][-1]).any()
    ]
    outline = [part[0] for each in features if each.kind == 'level' for part in each.parts]
    return FloorplanModel(
        tuple(walls), tuple(doors), (), tuple(rooms), tuple(outline), storeys, number
    )


def edges_of(ring: Array) -> Array:
    """Return the edges ``(V, 2, 2)`` of a ring."""
    return np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)


def _door(line: Array, feature: _Feature, edges: list[Array]) -> ModelDoor:
    """Return a door as deep as the gap between the two rooms beside it."""
    ends = line[[0, -1]]
    middle = ends.mean(axis=0)
    away = sorted(float(_distance(middle, each)) for each in edges)[:2]
    depth = 2.0 * max((each for each in away if each < _FAR_M), default=0.0)
    stated_door = feature.properties.get('door')
    kind = stated_door.get('type') if isinstance(stated_door, dict) else stated_door
    name = text_of(feature.properties.get('name'))
    return ModelDoor(
        ends, depth, _KINDS.get(str(kind), DoorKind.UNKNOWN), name=name, source=_SOURCE
    )


def _distance(point: Array, edges: Array) -> float:
    """Return the distance of a point ``(2,)`` to the nearest of edges ``(V, 2, 2)``."""
    start, along = edges[:, 0], edges[:, 1] - edges[:, 0]
    squares = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip(((point - start) * along).sum(axis=1) / squares, 0.0, 1.0)
    return float(np.hypot(*(start + share[:, None] * along - point).T).min())
