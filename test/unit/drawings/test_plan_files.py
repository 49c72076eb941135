# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A reading written as a map, and the map read again."""

import json

import numpy as np
from planted import plan_grid
import pytest

from fpnet_core.drawings.plan_files import as_json, record_path, recorded, write_plan
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import (
    Drawing,
    DrawingScale,
    Reading,
    ReadOptions,
    ScaleSource,
)
from fpnet_core.errors import MapFormatError

GUESS = DrawingScale(0.025, 0.02, 0.035, ScaleSource.ESTIMATED, 'doors and rooms')


@pytest.fixture
def reading():
    """A drawing whose pixels are half as large as the cells of what was read."""
    H = np.array([[0.025, 0.0, -3.0], [0.0, -0.025, 12.0], [1e-5, 0.0, 1.0]])
    return Reading(
        plan_grid(),
        GUESS,
        H,
        'dark walls on light paper',
        Drawing(np.full((40, 60, 3), 255, np.uint8), 'sheet.png', 'png'),
        storeys=((0, 0, 30, 40), (30, 0, 60, 40)),
        notes=('The sheet lay askew.',),
        doubts=('No door was found.',),
    )


def test_the_map_is_the_grid_and_says_how_surely_its_scale_is_known(reading, tmp_path):
    write_plan(reading, tmp_path / 'new' / 'plan.yaml')
    again = read_plan(tmp_path / 'new' / 'plan.yaml')
    np.testing.assert_array_equal(again.grid.cells, reading.grid.cells)
    assert again.grid.resolution == reading.grid.resolution
    np.testing.assert_allclose(
        again.grid.T_frame_grid.matrix, reading.grid.T_frame_grid.matrix, atol=1e-12
    )
    assert again.scale == DrawingScale(0.05, 0.04, 0.07, ScaleSource.ESTIMATED, 'doors and rooms')
    assert again.doubts == reading.doubts
    assert again.estimate == reading.estimate


def test_the_record_has_all_but_the_map(reading, tmp_path):
    record = write_plan(reading, tmp_path / 'plan.yaml')
    assert record == tmp_path / 'plan.json'
    values = json.loads(record.read_text())
    assert values == as_json(reading)
    assert values['H_plan_image'] == reading.H_plan_image.tolist()
    assert values['scale']['interval'] == [0.02, 0.035]
    assert values['storeys'] == [[0, 0, 30, 40], [30, 0, 60, 40]]


def test_a_scale_that_somebody_states_later_is_stated(reading, tmp_path):
    path = tmp_path / 'plan.yaml'
    write_plan(reading, path)
    assert read_plan(path, ReadOptions(resolution_m=0.06)).scale.is_known
    path.write_text(path.read_text().replace('resolution: 0.05', 'resolution: 0.06'))
    assert recorded(path, 0.06) is None
    edited = read_plan(path)
    assert edited.scale.source is ScaleSource.STATED
    assert edited.grid.resolution == 0.06


def test_a_length_on_a_map_is_its_scale(reading, tmp_path):
    write_plan(reading, tmp_path / 'plan.yaml')
    measured = read_plan(tmp_path / 'plan.yaml', ReadOptions(length=(0, 0, 30, 40, 5.0)))
    expected = DrawingScale(0.1, 0.1, 0.1, ScaleSource.LENGTH, 'from a length of 5 m')
    assert measured.scale == expected
    assert measured.grid.resolution == 0.1


@pytest.mark.parametrize(
    'options', [ReadOptions(layers=('WALLS',)), ReadOptions(storey=2), ReadOptions(page=2)]
)
def test_a_map_has_no_parts(reading, tmp_path, options):
    write_plan(reading, tmp_path / 'plan.yaml')
    with pytest.raises(MapFormatError, match='used as it is'):
        read_plan(tmp_path / 'plan.yaml', options)


def test_a_crop_of_a_map_stays_where_it_is(reading, tmp_path):
    write_plan(reading, tmp_path / 'plan.yaml')
    whole = read_plan(tmp_path / 'plan.yaml')
    height, width = whole.grid.shape
    part = read_plan(tmp_path / 'plan.yaml', ReadOptions(crop=(30, 40, width - 20, height - 10)))
    np.testing.assert_array_equal(part.grid.cells, whole.grid.cells[10:-40, 30:-20])
    cells = [[0, 0], [7, 5]]
    np.testing.assert_allclose(
        part.grid.rc_to_xy(cells), whole.grid.rc_to_xy(np.add(cells, [10, 30])), atol=1e-9
    )
    np.testing.assert_allclose(part.H_plan_image, whole.H_plan_image, atol=1e-9)
    assert part.drawing.size == (width, height)
    with pytest.raises(MapFormatError, match='crop'):
        read_plan(tmp_path / 'plan.yaml', ReadOptions(crop=(0, 0, width + 1, height)))


@pytest.mark.parametrize('text', ['', '{', '[]', '{"cells": 3}', '1' * 2_000_000])
def test_other_files_of_that_name_are_none_of_ours(reading, tmp_path, text):
    write_plan(reading, tmp_path / 'plan.yaml')
    record_path(tmp_path / 'plan.yaml').write_text(text)
    assert read_plan(tmp_path / 'plan.yaml').scale.source is ScaleSource.STATED


@pytest.mark.parametrize(
    'change',
    [
        {'scale': 3},
        {'scale': {}},
        {'doubts': None},
        {'cell_m': 'wide'},
        {'scale': {'metres_per_pixel': 1, 'interval': [2, 3], 'source': 'units', 'why': ''}},
        {'scale': {'metres_per_pixel': 1, 'interval': [1, 1], 'source': 'hearsay', 'why': ''}},
    ],
)
def test_a_damaged_record_is_one_line(reading, tmp_path, change):
    record = write_plan(reading, tmp_path / 'plan.yaml')
    record.write_text(json.dumps(json.loads(record.read_text()) | change))
    with pytest.raises(MapFormatError, match='damaged record'):
        read_plan(tmp_path / 'plan.yaml')


def test_a_flipped_reading_takes_its_pixels_along(reading):
    flipped = reading.flipped()
    here, there = reading.grid.rc_to_xy([[3, 7]]), flipped.grid.rc_to_xy([[3, 792]])
    assert reading.grid.cells[3, 7] == flipped.grid.cells[3, 792]
    pixel = np.linalg.inv(reading.H_plan_image) @ [*here[0], 1.0]
    moved = flipped.H_plan_image @ pixel
    np.testing.assert_allclose(moved[:2] / moved[2], there[0], atol=1e-9)
    twice = flipped.flipped()
    np.testing.assert_array_equal(twice.grid.cells, reading.grid.cells)
    np.testing.assert_allclose(twice.H_plan_image, reading.H_plan_image, atol=1e-9)
