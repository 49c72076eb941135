# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Open-RMF buildings read as floorplans, without the drawings that they name."""

import numpy as np
import pytest
import yaml

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.formats.worker import pack, read_here, unpack
from fpnet_core.drawings.model import DoorKind
from fpnet_core.drawings.opening import drawing_kind, open_drawing
from fpnet_core.drawings.read import read_drawing, read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.segmentation import segment_floorplan

# Pixels of 0.02 m, y down: 10 m x 6 m, a wall across with a door of 1 m.
VERTICES = [
    [0, 0], [500, 0], [500, 300], [0, 300], [300, 0], [300, 300], [300, 100], [300, 150],
    [0, 400], [150, 400],
]  # fmt: skip
EDGES = [(0, 4), (4, 1), (1, 2), (2, 5), (5, 3), (3, 0), (4, 6), (7, 5)]


def told(**values):
    return {name: [1, value] for name, value in values.items()}


def building(**others):
    level = {
        'drawing': {'filename': 'nowhere.png'},
        'elevation': 3.0,
        'vertices': [[*each, 0, ''] for each in VERTICES],
        'walls': [[a, b, told(alpha=0.5 if (a, b) == (1, 2) else 1)] for a, b in EDGES],
        'doors': [[6, 7, told(name='D', type='hinged', motion_axis='end')]],
        'measurements': [[8, 9, told(distance=3.0)]],
        'floors': [{'vertices': [0, 1, 2, 3], 'parameters': {}}],
        **others,
    }
    return {'name': 'b', 'levels': {'L2': level, 'L1': {'elevation': 0.0}}, 'lifts': {}}


def write(path, values):
    path.write_text(yaml.safe_dump(values))
    return path


def read(path, options=ReadOptions()):  # noqa: B008
    drawing = unpack(pack(read_here(path, 'rmf', options)))
    return read_drawing(drawing, options, FpnetConfig().segmentation)


def test_walls_and_doors_are_a_map(tmp_path):
    path = write(tmp_path / 'a.building.yaml', building())
    assert drawing_kind(path) == 'rmf'
    reading = read(path)
    (door,) = reading.model.doors
    assert (door.width_m, door.kind, door.hinge) == (pytest.approx(1.0), DoorKind.SWING, 1)
    assert len(reading.model.walls) == 7
    assert len(reading.model.windows) == 1
    assert [storey.name for storey in reading.model.storeys] == ['L1', 'L2']
    low, high = reading.model.points.min(axis=0), reading.model.points.max(axis=0)
    np.testing.assert_allclose(high - low, (10.2, 6.2), atol=0.01)
    segmentation = segment_floorplan(reading.grid, FpnetConfig().segmentation)
    assert sorted(region.area_m2 for region in segmentation.rooms) == pytest.approx(
        [3.8 * 5.8, 5.8 * 5.8], rel=0.05
    )
    assert len(segmentation.doors) == 1


def test_floors_tell_inside_where_walls_leak(tmp_path):
    walls = [[a, b, {}] for a, b in EDGES if (a, b) not in ((1, 2), (3, 0))]
    reading = read(write(tmp_path / 'a.building.yaml', building(walls=walls)))
    area = np.count_nonzero(reading.grid.cells == 0) * reading.grid.resolution**2
    assert area == pytest.approx(10.0 * 6.0 - 2 * 10.0 * 0.1 - 5.0 * 0.2, rel=0.05)


def test_metres_have_y_up_and_need_no_measurement(tmp_path):
    values = building(measurements=[], vertices=[[x / 50, -y / 50] for x, y in VERTICES])
    values['coordinate_system'] = 'cartesian_meters'
    reading = read(write(tmp_path / 'a.building.yaml', values))
    assert reading.model.doors[0].width_m == pytest.approx(1.0)


@pytest.mark.parametrize(
    ('values', 'options', 'message'),
    [
        (building(measurements=[]), ReadOptions(), "level 'L2': it has no measurement"),
        (building(walls=[]), ReadOptions(), 'has no walls'),
        (building(walls=[[0, 99]]), ReadOptions(), "level 'L2': it has an edge from vertex 0 to"),
        (building(doors=[[1]]), ReadOptions(), "level 'L2': it has an edge without two"),
        (building(vertices='x'), ReadOptions(), "level 'L2': its vertices are damaged"),
        (building(), ReadOptions(page=1), 'no elements on storey 1 of 2, L1'),
        (building(), ReadOptions(page=3), 'there is no storey 3'),
        ({**building(), 'coordinate_system': 'wgs84'}, ReadOptions(), "'wgs84' is unknown"),
        ({'levels': 3}, ReadOptions(), 'damaged building'),
        ([1], ReadOptions(), 'damaged building'),
    ],
)
def test_bad_files_are_refused_in_a_line(tmp_path, values, options, message):
    path = write(tmp_path / 'a.building.yaml', values)
    with pytest.raises(MapFormatError, match=rf'\A[^\n]*{message}[^\n]*\Z'):
        read(path, options)


@pytest.mark.usefixtures('own_process')
def test_it_is_no_map_of_map_server(tmp_path):
    path = write(tmp_path / 'a.building.yaml', building())
    assert read_plan(path).how.endswith('as the Open-RMF building states them')
    with pytest.raises(MapFormatError, match='is an Open-RMF building, which has no layers'):
        open_drawing(path, ReadOptions(layers=('walls',)))
