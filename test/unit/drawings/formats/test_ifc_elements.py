# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Spaces, doors and windows of an IFC that this test makes itself; walls are not guessed again."""

from importlib.util import find_spec

import numpy as np
import pytest
from test_drawings_ifc import _at, _box, _shape

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.formats.worker import pack, read_here, unpack
from fpnet_core.drawings.model import DoorKind
from fpnet_core.drawings.read import read_drawing
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

pytestmark = pytest.mark.skipif(
    find_spec('ifcopenshell') is None, reason='IfcOpenShell is an optional extra'
)

WALLS = (
    (0, 0, 8, 0.3), (0, 4.7, 8, 0.3), (0, 0.3, 0.3, 4.4), (7.7, 0.3, 0.3, 4.4), (4, 0.3, 0.2, 4.4),
)  # fmt: skip
ROOMS = ((0.3, 0.3, 3.7, 4.4), (4.2, 0.3, 3.5, 4.4))
COLUMNS = ((2.0, 2.0, 0.4, 0.4), (6.0, 2.0, 0.4, 0.4))
DOOR = (4.0, 2.0, 0.2, 0.9)
WINDOW = (1.0, 0.0, 1.5, 0.3)


def write(path, walls=WALLS, rooms=ROOMS, door=DOOR, window=WINDOW, columns=COLUMNS):
    """Write a storey of 8 m x 5 m in millimetres, whose door turns about its lower end."""
    from ifcopenshell.api import run

    model = run('project.create_file')
    project = run('root.create_entity', model, ifc_class='IfcProject', name='P')
    run('unit.assign_unit', model, length={'is_metric': True, 'raw': 'MILLIMETERS'})
    context = run('context.add_context', model, context_type='Model')
    body = run(
        'context.add_context', model, context_type='Model', context_identifier='Body',
        target_view='MODEL_VIEW', parent=context,
    )  # fmt: skip
    building = run('root.create_entity', model, ifc_class='IfcBuilding', name='B')
    run('aggregate.assign_object', model, products=[building], relating_object=project)
    storey = run('root.create_entity', model, ifc_class='IfcBuildingStorey', name='Ground')
    run('aggregate.assign_object', model, products=[storey], relating_object=building)
    made = [
        _box(model, run, body, storey, 'IfcWall', (x, y, 0), (dx, dy, 2.8))
        for x, y, dx, dy in walls
    ]
    for x, y, dx, dy in columns:
        _box(model, run, body, storey, 'IfcColumn', (x, y, 0), (dx, dy, 2.8))
    if door:
        _fill(model, run, body, storey, made[-1], 'IfcDoor', (*door[:2], 0), (*door[2:], 2.1))
    if window:
        _fill(model, run, body, storey, made[0], 'IfcWindow', (*window[:2], 0.9), (*window[2:], 1))
    for number, (x, y, dx, dy) in enumerate(rooms, 1):
        space = run('root.create_entity', model, ifc_class='IfcSpace', name=f'1.0{number}')
        run('aggregate.assign_object', model, products=[space], relating_object=storey)
        space.LongName, space.CompositionType = 'Office', 'ELEMENT'
        _shape(model, run, body, space, (x, y, 0), (dx, dy, 2.6))
        qto = run('pset.add_qto', model, product=space, name='Qto_SpaceBaseQuantities')
        run('pset.edit_qto', model, qto=qto, properties={'NetFloorArea': round(dx * dy, 2)})
    model.write(str(path))
    return path


def _fill(model, run, body, storey, wall, kind, at, size):
    """Cut a void and fill it; a door's place is turned, so that its x runs along the wall."""
    opening = run('root.create_entity', model, ifc_class='IfcOpeningElement')
    _shape(model, run, body, opening, at, size)
    run('feature.add_feature', model, feature=opening, element=wall)
    element = run('root.create_entity', model, ifc_class=kind, name='D1')
    run('spatial.assign_container', model, products=[element], relating_structure=storey)
    run('feature.add_filling', model, opening=opening, element=element)
    matrix = _at(*at)
    if kind == 'IfcDoor':
        matrix[:2, :2] = [[0, -1], [1, 0]]
        element.OperationType = 'SINGLE_SWING_LEFT'
        element.OverallWidth = 1000.0 * size[1]
    run('geometry.edit_object_placement', model, product=element, matrix=matrix)


def read(path, options=ReadOptions()):  # noqa: B008
    drawing = unpack(pack(read_here(path, 'ifc', options)))
    return read_drawing(drawing, options, FpnetConfig().segmentation)


def cells_at(reading, points):
    """Return the cells at points of the file, which are metres, y up."""
    A = reading.drawing.A_pixel_image
    pixels = np.asarray(points, float) @ A[:, :2].T + A[:, 2]
    xy = pixels @ reading.H_plan_image[:2, :2].T + reading.H_plan_image[:2, 2]
    rows, cols = np.rint(reading.grid.xy_to_rc(xy)).astype(int).T
    return reading.grid.cells[rows, cols].tolist()


@pytest.fixture(scope='module')
def stated(tmp_path_factory):
    return read(write(tmp_path_factory.mktemp('ifc') / 'a.ifc'))


def test_spaces_are_rooms_with_names_and_areas(stated):
    rooms = stated.model.rooms
    assert [room.name for room in rooms] == ['1.01 Office', '1.02 Office']
    assert [room.area_m2 for room in rooms] == pytest.approx([3.7 * 4.4, 3.5 * 4.4])
    assert [room.printed_area_m2 for room in rooms] == pytest.approx([16.28, 15.4])


def test_doors_have_a_line_a_hinge_and_a_leaf(stated):
    (door,) = stated.model.doors
    assert door.width_m == pytest.approx(0.9)
    assert door.depth_m == pytest.approx(0.2)
    assert door.kind is DoorKind.SWING
    assert door.name == 'D1'
    x, y = np.min([w.rings[0].min(axis=0) for w in stated.model.walls], axis=0)
    np.testing.assert_allclose(door.ends - (x, y), [(4.1, 2.0), (4.1, 2.9)], atol=1e-6)
    assert door.hinge == 0
    np.testing.assert_allclose(door.leaf - (x, y), (3.2, 2.0), atol=1e-6)
    (window,) = stated.model.windows
    np.testing.assert_allclose(window.ends - (x, y), [(1.0, 0.15), (2.5, 0.15)], atol=1e-6)


def test_the_map_is_the_geometry(stated):
    assert stated.how == 'walls, doors and rooms as the IFC states them'
    assert stated.doubts == ()
    on_walls = [(0.15, 2.5), (4.1, 1.0), (4.1, 4.0), (6.0, 4.85), (1.5, 0.15), (2.2, 2.2)]
    assert cells_at(stated, on_walls) == [OCCUPIED] * 6
    assert cells_at(stated, [(1.0, 1.0), (6.0, 3.0), (4.1, 2.45), (4.02, 2.8)]) == [FREE] * 4
    assert cells_at(stated, [(-0.2, 2.5), (4.0, 5.2)]) == [UNKNOWN] * 2
    segmentation = segment_floorplan(stated.grid, FpnetConfig().segmentation)
    assert len(segmentation.rooms) == 2
    assert len(segmentation.doors) == 1


def test_a_room_with_columns_and_nothing_else(tmp_path):
    """Walls that close around floor need no spaces; windows and doors shut them."""
    reading = read(write(tmp_path / 'a.ifc', WALLS[:4], (), None))
    assert reading.how == 'walls, doors and the floor within walls as the IFC states them'
    assert cells_at(reading, [(1.0, 1.0), (6.2, 2.2), (1.5, 0.15)]) == [FREE, OCCUPIED, OCCUPIED]
    assert len(segment_floorplan(reading.grid, FpnetConfig().segmentation).rooms) == 1


def test_a_door_to_the_outside_shuts_the_floor_in(tmp_path):
    walls = (*WALLS[:3], WALLS[3])
    reading = read(write(tmp_path / 'a.ifc', walls, (), (7.7, 2.0, 0.3, 0.9), None))
    assert cells_at(reading, [(7.0, 1.0), (7.85, 2.4), (8.3, 2.4)]) == [FREE, FREE, UNKNOWN]


def test_a_part_and_a_mirror_image_keep_the_model_in_place(stated, tmp_path):
    flipped = stated.flipped()
    np.testing.assert_allclose(flipped.H_plan_image, flipped.model.H_plan_image)
    width_m = stated.grid.shape[1] * stated.grid.resolution
    straight = stated.model.doors[0].ends
    np.testing.assert_allclose(
        flipped.model.doors[0].ends, [(width_m, 0.0)] * 2 + straight * (-1, 1)
    )
    height, width = stated.drawing.pixels.shape[:2]
    options = ReadOptions(crop=(0, 0, width // 2, height))
    part = read(write(tmp_path / 'a.ifc'), options)
    assert cells_at(part, [(1.0, 1.0), (0.15, 2.5)]) == [FREE, OCCUPIED]
    assert abs(part.grid.shape[1] - stated.grid.shape[1] // 2) <= 1
