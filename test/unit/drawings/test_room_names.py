# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of rooms: from the drawing into the map, and along a path."""

import json

import numpy as np
from plan_files import write_svg
import pytest

from fpnet.rooms import NamedRooms, RoomStay
from fpnet_core.drawings.plan_files import write_plan
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.room_names import room_names
from fpnet_core.drawings.types import RoomName
from fpnet_core.errors import MapFormatError
from fpnet_core.trajectory import PlanarTrajectory

LENGTHS = {'type': 'FeatureCollection', 'units': 'm'}


def unit(x, name):
    ring = [[x, 0.0], [x + 4.0, 0.0], [x + 4.0, 5.0], [x, 5.0], [x, 0.0]]
    return {
        'type': 'Feature',
        'feature_type': 'unit',
        'properties': {'category': 'room', 'name': {'en': name} if name else None},
        'geometry': {'type': 'Polygon', 'coordinates': [ring]},
    }


@pytest.fixture(scope='module')
def drawn(tmp_path_factory):
    """A drawing with "Office" printed in one of its rooms."""
    return read_plan(write_svg(tmp_path_factory.mktemp('names') / 'plan.svg'))


def at_text(reading):
    """Where the text stands, in metres of the map: ``plan_files`` draws y upwards."""
    label = reading.drawing.labels[0]
    x, y = (label.box[0] + label.box[2]) / 2, (label.box[1] + label.box[3]) / 2
    point = reading.H_plan_image @ (x, y, 1.0)
    return point[:2] / point[2]


def test_a_printed_name_belongs_to_the_room_around_it(drawn):
    (room,) = room_names(drawn)
    assert room.name == 'Office'
    named = NamedRooms.of(drawn)
    elsewhere = at_text(drawn) + np.array([100.0, 0.0])
    assert named.at([at_text(drawn), room.xy, elsewhere]) == ['Office', 'Office', '']


def test_names_travel_with_the_map(drawn, tmp_path):
    write_plan(drawn, tmp_path / 'plan.yaml')
    again = read_plan(tmp_path / 'plan.yaml')
    assert room_names(again) == room_names(drawn)
    assert NamedRooms.of(again).at([at_text(drawn)]) == ['Office']


def test_names_are_flipped_with_the_map(drawn, tmp_path):
    write_plan(drawn, tmp_path / 'plan.yaml')
    flipped = read_plan(tmp_path / 'plan.yaml').flipped()
    (room,) = room_names(flipped)
    width_m = drawn.grid.shape[1] * drawn.grid.resolution
    assert room.xy == pytest.approx((width_m - room_names(drawn)[0].xy[0], room.xy[1]))
    assert NamedRooms.of(flipped).at([room.xy]) == ['Office']


def test_a_damaged_name_is_refused_by_its_file(drawn, tmp_path):
    record = write_plan(drawn, tmp_path / 'plan.yaml')
    values = json.loads(record.read_text())
    record.write_text(json.dumps(values | {'room_names': [{'name': 'Office', 'xy': ['x', 0]}]}))
    with pytest.raises(MapFormatError, match=r'plan\.json is a damaged record'):
        read_plan(tmp_path / 'plan.yaml')


def test_stated_names_are_those_of_the_file(tmp_path):
    path = tmp_path / 'rooms.geojson'
    path.write_text(json.dumps({**LENGTHS, 'features': [unit(0.0, '2.01'), unit(4.2, '')]}))
    plan = read_plan(path)
    assert [room.name for room in plan.model.rooms] == ['2.01', '']
    named = NamedRooms.of(plan)
    assert len(named) == 1
    assert named.at([(2.0, 2.5)]) == ['2.01']


def test_stays_pass_over_doorways_and_two_names_in_one_room_are_joined(drawn):
    segmentation = drawn.segmentation
    inside = [room.centroid for room in segmentation.rooms[:2]]
    first, second = (tuple(xy.tolist()) for xy in inside)
    names = [RoomName('A', first), RoomName('B', second), RoomName('C', second)]
    named = NamedRooms(segmentation, names)
    outside = (-50.0, -50.0)
    path = np.array([first, outside, first, second, outside, first])
    stamps_ns = np.arange(6) * 1_000_000_000
    stays = named.stays(PlanarTrajectory(stamps_ns, path, np.zeros(6)))
    assert stays == (
        RoomStay('A', 0, 2_000_000_000),
        RoomStay('B / C', 3_000_000_000, 3_000_000_000),
        RoomStay('A', 5_000_000_000, 5_000_000_000),
    )
