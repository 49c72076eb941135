# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Export of a floorplan model as GeoJSON or IMDF archive, at longitude 0, latitude 0."""

from __future__ import annotations

from datetime import UTC, datetime
import json
from pathlib import Path
from typing import Any
import uuid
import zipfile

import numpy as np

from fpnet_core.drawings.geodesy import LocalMetres
from fpnet_core.drawings.model import DoorKind, FloorplanModel, Rings, ring_area
from fpnet_core.drawings.types import Array

_HERE = LocalMetres(0.0, 0.0)  # chosen: a plan has no geographic position
_DIGITS = 10  # numerical: of degrees, a hundredth of a millimetre
_DOORS = {
    DoorKind.SWING: 'swinging', DoorKind.DOUBLE: 'swinging', DoorKind.SLIDING: 'sliding',
    DoorKind.REVOLVING: 'revolving', DoorKind.FOLDING: 'movablepartition',
    DoorKind.OPENING: 'open',
}  # fmt: skip

Feature = dict[str, Any]


def write_geojson(model: FloorplanModel, path: Path, name: str) -> None:
    """Write one file with all features."""
    files = features_of(model, name)
    everything = [feature for features in files.values() for feature in features]
    path.write_text(_collection(everything), encoding='utf-8')


def write_imdf(model: FloorplanModel, path: Path, name: str) -> None:
    """Write a ZIP with a file for each type of feature and the manifest."""
    manifest = {
        'version': '1.0.0', 'created': datetime.now(UTC).isoformat(timespec='seconds'),
        'generated_by': 'fpnet_ros', 'language': 'en',
    }  # fmt: skip
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as archive:
        archive.writestr('manifest.json', json.dumps(manifest))
        for kind, features in features_of(model, name).items():
            archive.writestr(f'{kind}.geojson', _collection(features))


def features_of(model: FloorplanModel, name: str) -> dict[str, list[Feature]]:
    """Return the features of each IMDF type, by the type's name."""
    storey = model.storeys[model.storey] if model.storey is not None else None
    level = storey.name if storey is not None else name
    ids = {kind: _id(name, kind) for kind in ('address', 'venue', 'building', 'level')}
    around = [_area((ring,)) for ring in model.outline] or [_area((_box(model.points),))]
    outside = {'type': 'MultiPolygon', 'coordinates': [each['coordinates'] for each in around]}
    address = {'address': name, 'locality': '-', 'country': '-', 'unit': None}
    feature = _Features(name)
    levels = {
        'ordinal': model.storey or 0, 'name': {'en': level}, 'short_name': {'en': level},
        'category': 'unspecified', 'outdoor': False, 'building_ids': [ids['building']],
        'address_id': ids['address'],
    }  # fmt: skip
    if storey is not None and storey.elevation_m is not None:
        levels['elevation'] = storey.elevation_m
    named = {'name': {'en': name}, 'alt_name': None, 'category': 'unspecified'}
    return {
        'address': [feature('address', None, address, ids['address'])],
        'venue': [
            feature('venue', outside, {**named, 'address_id': ids['address']}, ids['venue'])
        ],
        'building': [
            feature('building', None, {**named, 'address_id': ids['address']}, ids['building'])
        ],
        'footprint': [
            feature('footprint', outside, {
                'category': 'ground', 'name': None, 'building_ids': [ids['building']],
            })
        ],
        'level': [feature('level', outside, levels, ids['level'])],
        'unit': _units(model, feature, ids['level']),
        'opening': [
            feature('opening', _line(door.ends), {
                'category': 'pedestrian', 'level_id': ids['level'],
                'name': {'en': door.name} if door.name else None,
                'door': {'type': _DOORS.get(door.kind, 'unspecified'), 'automatic': False,
                         'material': None},
            })
            for door in model.doors
        ],
    }  # fmt: skip


class _Features:
    """Factory of features with ids that are the same for the same plan."""

    def __init__(self, name: str) -> None:
        self._name, self._count = name, 0

    def __call__(
        self, kind: str, geometry: Any, properties: dict[str, Any], number: str = ''
    ) -> Feature:
        """Return a feature; without ``number`` it gets the next id."""
        self._count += 1
        return {
            'id': number or _id(self._name, f'{kind} {self._count}'), 'type': 'Feature',
            'feature_type': kind, 'geometry': geometry, 'properties': properties,
        }  # fmt: skip


def _units(model: FloorplanModel, feature: _Features, level: str) -> list[Feature]:
    """Return rooms, and walls as units of category ``structure``."""
    rooms = [
        feature('unit', _area(room.rings), {
            'category': room.category or 'room', 'level_id': level,
            'name': {'en': room.name} if room.name else None, 'area_m2': room.printed_area_m2,
            'restriction': None, 'accessibility': None,
        })
        for room in model.rooms
    ]  # fmt: skip
    return rooms + [
        feature('unit', _area(wall.rings), {
            'category': 'structure', 'level_id': level, 'name': None,
        })
        for wall in model.walls
    ]  # fmt: skip


def _id(name: str, what: str) -> str:
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f'fpnet:{name}:{what}'))


def _collection(features: list[Feature]) -> str:
    return json.dumps({'type': 'FeatureCollection', 'features': features}, allow_nan=False)


def _degrees(points: Array) -> list[list[float]]:
    degrees: list[list[float]] = _HERE.to_degrees(points).round(_DIGITS).tolist()
    return degrees


def _line(ends: Array) -> dict[str, Any]:
    return {'type': 'LineString', 'coordinates': _degrees(ends)}


def _area(rings: Rings) -> dict[str, Any]:
    """Return a polygon with counter-clockwise exterior and clockwise holes."""
    turned = [
        ring if (ring_area(ring) > 0.0) == (number == 0) else ring[::-1]
        for number, ring in enumerate(rings)
    ]
    closed = [_degrees(np.concatenate([ring, ring[:1]])) for ring in turned]
    return {'type': 'Polygon', 'coordinates': closed}


def _box(points: Array) -> Array:
    """Return the corners (4, 2) of the bounding box of points; a unit square without points."""
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (0.0, 1.0)
    (left, bottom), (right, top) = np.broadcast_to(low, 2), np.broadcast_to(high, 2)
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
