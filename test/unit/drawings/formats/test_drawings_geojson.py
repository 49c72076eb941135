# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""IMDF and GeoJSON: units are rooms, openings doors, levels storeys; nothing explodes."""

import json
import zipfile

import numpy as np
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.formats.geojson_files import MAX_BYTES
from fpnet_core.drawings.formats.worker import pack, read_here, unpack
from fpnet_core.drawings.geodesy import LocalMetres
from fpnet_core.drawings.model import DoorKind
from fpnet_core.drawings.opening import drawing_kind, open_drawing
from fpnet_core.drawings.read import read_drawing
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.segmentation import segment_floorplan

HERE = LocalMetres(30.37, 60.0)
TURN = np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
ROOMS = {'2.14': (0, 0, 5, 4), '2.15': (5.2, 0, 9, 4), 'Hall': (0, 4.2, 9, 7)}
DOORS = (((5.1, 1.0), (5.1, 1.9)), ((2.0, 4.1), (3.0, 4.1)), ((7.0, 4.1), (8.0, 4.1)))


def degrees(points):
    return HERE.to_degrees(np.asarray(points, float) @ TURN).tolist()


def area(box):
    left, low, right, high = box
    ring = [(left, low), (right, low), (right, high), (left, high), (left, low)]
    return {'type': 'Polygon', 'coordinates': [degrees(ring)]}


def feature(kind, geometry, number='', **properties):
    return {'id': number, 'type': 'Feature', 'feature_type': kind, 'geometry': geometry,
            'properties': properties}  # fmt: skip


def units(level='L2'):
    return [
        feature('unit', area(box), f'u{name}', name={'ru': '?', 'en': name}, level_id=level,
                category='room')
        for name, box in ROOMS.items()
    ]  # fmt: skip


def openings(level='L2'):
    return [
        feature('opening', {'type': 'LineString', 'coordinates': degrees(ends)}, f'o{k}',
                level_id=level, door={'type': 'sliding'})
        for k, ends in enumerate(DOORS)
    ]  # fmt: skip


def imdf():
    """Two levels; the lower one has one unit; a unit is solid, another one has no floor."""
    levels = [
        feature('level', area((-0.3, -0.3, 9.3, 7.3)), 'L2', ordinal=1, name={'en': 'First'}),
        feature('level', area((-0.3, -0.3, 9.3, 7.3)), 'L1', ordinal=0, name='Ground'),
    ]
    others = [
        feature('unit', area((2, 1, 2.5, 1.5)), 's', level_id='L2', category='column'),
        feature('unit', area((6, 5, 7, 6)), 'v', level_id='L2', category='opentobelow'),
        feature('unit', area((0, 0, 9, 7)), 'g', level_id='L1', category='room'),
    ]
    return {'level': levels, 'unit': units() + others, 'opening': openings(), 'venue': []}


def collection(features):
    return json.dumps({'type': 'FeatureCollection', 'features': features})


def write(path, files=None):
    files = imdf() if files is None else files
    if path.suffix == '.zip':
        with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as archive:
            for stem, features in files.items():
                archive.writestr(f'venue/{stem}.geojson', collection(features))
    elif path.suffix:
        path.write_text(collection([each for some in files.values() for each in some]))
    else:
        path.mkdir()
        for stem, features in files.items():
            (path / f'{stem}.geojson').write_text(collection(features))
    return path


def read(path, options=ReadOptions()):  # noqa: B008
    drawing = unpack(pack(read_here(path, drawing_kind(path), options)))
    return read_drawing(drawing, options, FpnetConfig().segmentation)


@pytest.mark.parametrize('name', ['venue', 'venue.zip', 'venue.geojson', 'venue.json'])
def test_folders_archives_and_files(tmp_path, name):
    path = write(tmp_path / name)
    assert drawing_kind(path) == 'geojson'
    reading = read(path)
    assert [room.name for room in reading.model.rooms] == list(ROOMS)
    areas = [(c - a) * (d - b) for a, b, c, d in ROOMS.values()]
    assert [room.area_m2 for room in reading.model.rooms] == pytest.approx(areas, rel=1e-4)
    assert [door.width_m for door in reading.model.doors] == pytest.approx([0.9, 1, 1], rel=1e-4)
    assert {door.kind for door in reading.model.doors} == {DoorKind.SLIDING}
    assert [storey.name for storey in reading.model.storeys] == ['Ground', 'First']
    assert reading.model.storey == 1
    assert len(reading.model.walls) == 1
    assert reading.scale.is_known


def test_the_map_has_its_rooms_and_doors(tmp_path):
    files = imdf()
    files['unit'] = units()
    reading = read(write(tmp_path / 'venue', files))
    assert reading.how == 'walls, doors and rooms as the GeoJSON states them'
    segmentation = segment_floorplan(reading.grid, FpnetConfig().segmentation)
    assert len(segmentation.rooms) == 3
    assert len(segmentation.doors) == 3
    # Rooms are 0.2 m apart, and doors lead through all of it.
    assert [door.depth_m for door in reading.model.doors] == pytest.approx([0.2] * 3, abs=0.01)


@pytest.mark.usefixtures('own_process')
def test_levels_are_pages(tmp_path):
    path = write(tmp_path / 'venue')
    first = open_drawing(path, ReadOptions(page=1))
    assert [room.category for room in first.model.rooms] == ['room']
    with pytest.raises(MapFormatError, match='has 2 storeys; there is no storey 3'):
        open_drawing(path, ReadOptions(page=3))


def test_indoor_tags_of_other_geojson(tmp_path):
    features = [
        {'type': 'Feature', 'geometry': area(box),
         'properties': {'indoor': 'room', 'level': 2, 'ref': name}}
        for name, box in ROOMS.items()
    ]  # fmt: skip
    features.append({
        'type': 'Feature', 'properties': {'door': 'yes', 'level': 2},
        'geometry': {'type': 'LineString', 'coordinates': degrees(DOORS[0])},
    })  # fmt: skip
    reading = read(write(tmp_path / 'a.geojson', {'any': features}))
    assert [room.name for room in reading.model.rooms] == list(ROOMS)
    assert len(reading.model.doors) == 1


def test_metres_of_a_grid_are_taken_for_such(tmp_path):
    ring = [[400.0, 7000.0], [440.0, 7000.0], [440.0, 7020.0], [400.0, 7020.0], [400.0, 7000.0]]
    unit = feature('unit', {'type': 'Polygon', 'coordinates': [ring]})
    reading = read(write(tmp_path / 'a.geojson', {'unit': [unit]}))
    assert reading.model.rooms[0].area_m2 == pytest.approx(800.0)
    assert any('taken for metres' in note for note in reading.notes)


BAD = {
    'cut.geojson': (b'{"type": "FeatureCollection", "features": [', 'damaged GeoJSON'),
    'none.geojson': (b'{"type": "FeatureCollection", "features": []}', 'has no units'),
    'odd.geojson': (b'{"features": [1, null, {"geometry": 3}, {"properties": []}]}', 'no units'),
    'nan.geojson': (
        b'{"type": "FeatureCollection", "features": [{"geometry": {"type": "Polygon", '
        b'"coordinates": [[[NaN, 1], [2, 1e999], [3, "x"], [NaN, 1]]]}}]}', 'has no units',
    ),
    'deep.geojson': (b'{"Features":' + b'[' * 100_000, 'damaged'),
    'a.zip': (b'PK\3\4' + bytes(50), 'unpack it'),
}  # fmt: skip


@pytest.mark.usefixtures('own_process')
@pytest.mark.parametrize('name', BAD)
def test_bad_files_are_refused_in_a_line(tmp_path, name):
    data, message = BAD[name]
    (tmp_path / name).write_bytes(data)
    with pytest.raises(MapFormatError, match=rf'\A[^\n]*{message}[^\n]*\Z'):
        open_drawing(tmp_path / name)


def test_an_archive_that_grows_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / 'a.zip', 'w', zipfile.ZIP_DEFLATED) as archive:
        archive.writestr('unit.geojson', b' ' * (MAX_BYTES + 1000))
    with pytest.raises(MapFormatError, match='too large'):
        open_drawing(tmp_path / 'a.zip')


def test_metres_about_a_place_and_back():
    # Sixty degrees north: half as long to the east as at the equator, and a little more.
    np.testing.assert_allclose(HERE.metres_per_degree, [55800.2, 111412.2], atol=0.5)
    points = np.array([[12.0, -7.0], [0.0, 300.0]])
    np.testing.assert_allclose(HERE.to_metres(HERE.to_degrees(points)), points, atol=1e-6)
