# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is exported and read again has the same rooms and doors."""

import json
from pathlib import Path
import zipfile

import cv2
import numpy as np
import pytest

from fpnet.exports.segmented_model import complete_model
from fpnet.exports.writing import export_suffix, write_model
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.formats.worker import pack, read_here, unpack
from fpnet_core.drawings.model import (
    DoorKind,
    FloorplanModel,
    ModelDoor,
    ModelRoom,
    ModelStorey,
    ModelWall,
    ModelWindow,
)
from fpnet_core.drawings.opening import drawing_kind
from fpnet_core.drawings.read import read_drawing
from fpnet_core.drawings.types import (
    Drawing,
    DrawingScale,
    Label,
    Reading,
    ReadOptions,
    ScaleSource,
)
from fpnet_core.errors import ConfigError
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

CONFIG = FpnetConfig().segmentation


def box(left, low, right, high):
    return np.array([[left, low], [right, low], [right, high], [left, high]], float)


WALLS = (
    (0, 0, 10.4, 0.2), (0, 6.2, 10.4, 6.4), (0, 0.2, 0.2, 6.2), (10.2, 0.2, 10.4, 6.2),
    (6, 0.2, 6.2, 2), (6, 2.9, 6.2, 6.2), (6.2, 3.2, 10.2, 3.4),
)  # fmt: skip
ROOMS = {'Hall': (0.2, 0.2, 6, 6.2), '2.14': (6.2, 0.2, 10.2, 3.2), '2.15': (6.2, 3.4, 10.2, 6.2)}
DOORS = (
    ModelDoor(np.array([[6.1, 2.0], [6.1, 2.9]]), 0.2, DoorKind.SWING, 1, np.array([7.0, 2.9])),
    ModelDoor(np.array([[8.0, 3.3], [9.0, 3.3]]), 0.2, DoorKind.SLIDING),
)


def model(walls=WALLS):
    return FloorplanModel(
        tuple(ModelWall((box(*each),)) for each in walls),
        DOORS,
        (ModelWindow(np.array([[2.0, 0.1], [4.0, 0.1]]), 0.2),),
        tuple(ModelRoom((box(*each),), name, 12.5) for name, each in ROOMS.items()),
        (box(0, 0, 10.4, 6.4),),
        (ModelStorey('ground', 0.0), ModelStorey('first', 3.2)),
        1,
    )


def read(path, options=ReadOptions()):  # noqa: B008
    drawing = unpack(pack(read_here(path, drawing_kind(path), options)))
    reading = read_drawing(drawing, options, CONFIG)
    return complete_model(reading), reading


def placed(read_model, reference):
    """Return the model moved so that its rooms start where those of another one do."""
    low = [
        np.min([ring.min(axis=0) for room in each.rooms for ring in room.rings], axis=0)
        for each in (read_model, reference)
    ]
    return read_model.moved(np.column_stack([np.eye(2), low[1] - low[0]]))


def overlap(a, b):
    """Return the area that two rooms share, of what either has."""
    masks = []
    for room in (a, b):
        mask = np.zeros((1400, 2200), np.uint8)
        cv2.fillPoly(mask, [np.rint(ring * 200 + 20).astype(np.int32) for ring in room.rings], 1)
        masks.append(mask > 0)
    return (masks[0] & masks[1]).sum() / (masks[0] | masks[1]).sum()


def assert_same(again, reference, door_m):
    again = placed(again, reference)
    assert len(again.rooms) == len(reference.rooms)
    for room in reference.rooms:
        assert max(overlap(room, other) for other in again.rooms) > 0.95
    assert len(again.doors) == len(reference.doors)
    for door in reference.doors:
        middle = door.ends.mean(axis=0)
        nearest = min(again.doors, key=lambda other: np.hypot(*(other.ends.mean(axis=0) - middle)))
        assert np.hypot(*(nearest.ends.mean(axis=0) - middle)) < door_m
        assert nearest.width_m == pytest.approx(door.width_m, abs=2 * door_m)


@pytest.mark.parametrize('name', ['a.geojson', 'a.zip'])
@pytest.mark.parametrize('walls', [WALLS, ()])
def test_geojson_and_imdf_keep_everything(tmp_path, name, walls):
    write_model(model(walls), tmp_path / 'new' / name, 'house')
    again, _ = read(tmp_path / 'new' / name)
    assert_same(again, model(), 0.001)
    assert [room.name for room in again.rooms] == list(ROOMS)
    assert {room.printed_area_m2 for room in again.rooms} == {12.5}
    assert [door.kind for door in again.doors] == [DoorKind.SWING, DoorKind.SLIDING]
    assert again.storeys == (ModelStorey('first', 3.2),)
    assert len(again.walls) == len(walls)


def test_an_imdf_has_its_manifest_and_links(tmp_path):
    write_model(model(), tmp_path / 'a.zip', 'house')
    with zipfile.ZipFile(tmp_path / 'a.zip') as archive:
        files = {name: json.loads(archive.read(name)) for name in archive.namelist()}
    assert files['manifest.json']['version'] == '1.0.0'
    (level,) = files['level.geojson']['features']
    assert {u['properties']['level_id'] for u in files['unit.geojson']['features']} == {
        level['id']
    }
    every = [f['id'] for name in files if 'geojson' in name for f in files[name]['features']]
    assert len(set(every)) == len(every)


def test_an_open_rmf_building_has_the_rooms_that_its_walls_leave(tmp_path):
    write_model(model(), tmp_path / 'a.building.yaml', 'house')
    again, reading = read(tmp_path / 'a.building.yaml')
    assert reading.model.storeys == (ModelStorey('first', 3.2),)
    assert_same(again, model(), 0.05)  # rooms are told from cells of 0.025 m
    assert [door.hinge for door in again.doors] == [1, None]


def test_a_dxf_has_walls_doors_and_names(tmp_path):
    write_model(model(), tmp_path / 'a.dxf', 'house')
    drawing = read_here(tmp_path / 'a.dxf', 'dxf', ReadOptions())
    assert {label.text for label in drawing.labels} == set(ROOMS)
    assert 'walls are on A-WALL, A-GLAZ' in drawing.notes
    pixels_per_m = np.sqrt(abs(np.linalg.det(drawing.A_pixel_image[:, :2])))
    np.testing.assert_allclose(
        sorted(drawing.door_px), np.multiply([0.9, 1], pixels_per_m), rtol=0.01
    )


def test_an_svg_has_solid_walls_with_open_doors(tmp_path):
    write_model(model(), tmp_path / 'a.svg', 'a & b')
    drawing = read_here(tmp_path / 'a.svg', 'svg', ReadOptions())
    places = np.array([(3, 0.1), (6.1, 1.0), (7.0, 3.3), (6.1, 2.45), (8.5, 3.3), (3, 3)])
    # At 1:100 a metre has ten millimetres, with one metre around the building.
    millimetres = np.column_stack([places[:, 0] + 1.0, 7.4 - places[:, 1]]) * 10.0
    A = drawing.A_pixel_image
    x, y = np.rint(millimetres @ A[:, :2].T + A[:, 2]).astype(int).T
    assert drawing.pixels[y, x, 0].tolist() == [0, 0, 0, 255, 255, 255]
    assert {label.text for label in drawing.labels} == set(ROOMS)


def drawn_reading():
    """The building as a picture of 0.05 m per pixel, with a text in the hall."""
    cells = np.full((148, 228), UNKNOWN, np.int8)
    for value, boxes in ((FREE, [(0.1, 0.1, 10.3, 6.3)]), (OCCUPIED, WALLS)):
        for left, low, right, high in boxes:
            a, b, c, d = np.rint(np.array([left, low, right, high]) * 20 + 10).astype(int)
            cells[b:d, a:c] = value
    cells[76:78, 170:190] = FREE
    scale = DrawingScale(0.05, 0.05, 0.05, ScaleSource.STATED)
    label = Label('Hall', (60.0, 80.0, 70.0, 84.0))
    drawing = Drawing(np.zeros((148, 228, 3), np.uint8), 'a.png', 'png', labels=(label,))
    H = np.array([[0.05, 0, 0.025], [0, -0.05, 7.375], [0, 0, 1.0]])
    return Reading(GridMap(cells, 0.05), scale, H, 'drawn', drawing)


@pytest.mark.parametrize('suffix', ['.geojson', '.zip', '.building.yaml'])
def test_a_picture_has_a_model_of_what_it_was_cut_into(tmp_path, suffix):
    reading = drawn_reading()
    found = complete_model(reading)
    assert sorted(room.name for room in found.rooms) == ['', '', 'Hall']
    assert_same(found, model(), 0.06)
    path = tmp_path / f'a{suffix}'
    write_model(found, path)
    again, _ = read(path)
    assert_same(again, found, 0.06)


def test_other_names_are_refused():
    assert export_suffix(Path('a.Building.YAML')) == '.building.yaml'
    with pytest.raises(ConfigError, match=r'a\.ifc: expected a name that ends in \.geojson'):
        write_model(model(), 'a.ifc')
