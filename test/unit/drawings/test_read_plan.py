# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From drawings to maps: tones, sheets, scale, plausibility, bad input."""

import cv2
import numpy as np
from PIL import Image
from plan_pictures import PX_PER_M, WHITE, sheet, storey
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions, ScaleSource
from fpnet_core.errors import MapFormatError
from fpnet_core.io.images import interpret
from fpnet_core.io.maps import read_map, write_map
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import OCCUPIED, GridMap

GOOD_F1 = 0.85


def saved(tmp_path, picture, name='plan.png'):
    path = tmp_path / name
    Image.fromarray(picture).save(path)
    return path


def truth_on(reading, labels):
    """Room labels of the picture at the cells of the map."""
    grid = reading.grid
    rows, cols = np.indices(grid.shape)
    xy = grid.rc_to_xy(np.stack([rows, cols], axis=-1)).reshape(-1, 2)
    lifted = np.c_[xy, np.ones(len(xy))] @ np.linalg.inv(reading.H_plan_image).T
    places = np.rint(lifted[:, :2] / lifted[:, 2:]).astype(int)
    inside = (places >= 0).all(axis=1) & (places < labels.shape[::-1]).all(axis=1)
    found = np.zeros(len(xy), np.int32)
    found[inside] = labels[places[inside, 1], places[inside, 0]]
    return found.reshape(grid.shape)


def room_f1(reading, labels):
    found = segment_floorplan(reading.grid, SegmentationConfig())
    return room_agreement(found.labels, truth_on(reading, labels)).f1


def test_a_robots_map_without_its_yaml_is_read_exactly(tmp_path):
    picture, labels = storey()
    outside = np.where(picture[..., 0] == WHITE, labels == 0, False)
    picture[outside] = 205
    reading = read_plan(saved(tmp_path, picture), ReadOptions(resolution_m=0.05))
    np.testing.assert_array_equal(reading.grid.cells[::-1], interpret(picture[..., 0], 0.05))
    assert reading.how == 'a robot map'
    assert reading.scale.source is ScaleSource.STATED
    assert reading.grid.resolution == 0.05
    assert reading.is_readable


def test_walls_of_a_clean_plan_stand_where_they_are_drawn(tmp_path):
    picture, _ = storey()
    reading = read_plan(saved(tmp_path, picture), ReadOptions(resolution_m=0.05))
    places = reading.grid.rc_to_xy(np.moveaxis(np.indices(reading.grid.shape), 0, 2))
    lifted = np.c_[places.reshape(-1, 2), np.ones(places[..., 0].size)]
    lifted = lifted @ np.linalg.inv(reading.H_plan_image).T
    x, y = np.rint(lifted[:, :2] / lifted[:, 2:]).astype(int).T
    x, y = x.clip(0, picture.shape[1] - 1), y.clip(0, picture.shape[0] - 1)
    drawn = picture[y, x, 0].reshape(reading.grid.shape) == 0
    found = reading.grid.cells == OCCUPIED
    assert (drawn & found).sum() / (drawn | found).sum() > 0.9


def test_a_map_server_map_is_what_its_thresholds_say(tmp_path):
    picture, _ = storey()
    write_map(GridMap(interpret(picture[..., 0], 0.05)[::-1], 0.05), tmp_path / 'map.yaml')
    reading = read_plan(tmp_path / 'map.yaml')
    np.testing.assert_array_equal(reading.grid.cells, read_map(tmp_path / 'map.yaml').cells)
    assert reading.scale.is_known
    corner = reading.H_plan_image @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose(corner[:2], [0.025, reading.grid.shape[0] * 0.05 - 0.025])


@pytest.mark.parametrize('level', [60, 70, 100, 140])
def test_grey_walls_do_not_vanish(tmp_path, level):
    picture, labels = storey(wall=level)
    reading = read_plan(saved(tmp_path, picture))
    assert room_f1(reading, labels) > GOOD_F1
    assert (reading.grid.cells == 100).mean() > 0.02


@pytest.mark.parametrize(
    ('wall', 'paper', 'fill'),
    [
        ((40, 60, 120), WHITE, [(255, 230, 210), (210, 240, 220), (225, 215, 250)]),
        (WHITE, 0, None),
        ((235, 240, 255), (20, 40, 120), [(20, 40, 120)]),
        ((190, 120, 20), WHITE, None),
        (0, WHITE, [(255, 0, 0), (255, 255, 0), (0, 160, 255), (255, 255, 255)]),
    ],
)
def test_colours_fills_and_light_lines_on_dark(tmp_path, wall, paper, fill):
    picture, labels = storey(wall=wall, paper=paper, fill=fill)
    reading = read_plan(saved(tmp_path, picture))
    assert room_f1(reading, labels) > GOOD_F1
    assert reading.is_readable


def test_what_is_on_the_sheet_beside_the_building_is_no_building(tmp_path):
    picture, labels = sheet(*storey(fill=[(255, 235, 215), (215, 235, 255)]))
    reading = read_plan(saved(tmp_path, picture))
    assert room_f1(reading, labels) > GOOD_F1
    rows, cols = np.nonzero(labels)
    ((left, top, right, bottom),) = reading.storeys
    np.testing.assert_allclose(
        [left, top, right, bottom], [cols.min(), rows.min(), cols.max(), rows.max()], atol=25
    )


def test_two_storeys_are_offered_by_number(tmp_path):
    picture, labels = storey()
    other, other_labels = storey()
    keep = other_labels <= 8
    keep[:, 460:] = False
    other[:, 460:] = WHITE
    cv2.line(other, (459, 40), (459, 280), (0, 0, 0), 4)
    both = np.concatenate([picture, np.full_like(picture[:160], WHITE), other])
    first = np.pad(labels, ((0, len(both) - len(labels)), (0, 0)))
    path = saved(tmp_path, both)
    reading = read_plan(path)
    assert len(reading.storeys) == 2
    assert room_f1(reading, first) > GOOD_F1
    assert any('--storey' in note for note in reading.notes)
    second = read_plan(path, ReadOptions(storey=2))
    assert (truth_on(second, first) == 0).all()
    with pytest.raises(MapFormatError, match='expected 1 to 2'):
        read_plan(path, ReadOptions(storey=3))


def test_perspective_and_shade_are_undone(tmp_path):
    picture, labels = sheet(*storey())
    height, width = labels.shape
    corners = np.float32([[0, 0], [width, 0], [width, height], [0, height]])
    seen = np.float32([[60, 90], [width - 20, 10], [width - 90, height - 20], [10, height - 70]])
    H = cv2.getPerspectiveTransform(corners, seen)
    photo = cv2.warpPerspective(picture, H, (width, height), borderValue=(70, 60, 50))
    shade = np.linspace(0.6, 1.0, width)[None, :, None]
    photo = (photo * shade).astype(np.uint8)
    seen_labels = cv2.warpPerspective(
        labels.astype(np.uint8), H, (width, height), flags=cv2.INTER_NEAREST
    )
    reading = read_plan(saved(tmp_path, photo, 'photo.jpg'))
    assert room_f1(reading, seen_labels) > GOOD_F1
    # The four corners of the building are square again.
    rows, cols = np.nonzero(labels)
    box = np.array([[cols.min(), rows.min()], [cols.max(), rows.min()], [cols.max(), rows.max()]])
    lifted = np.c_[box, np.ones(3)] @ H.T @ reading.H_plan_image.T
    a, b, c = lifted[:, :2] / lifted[:, 2:]
    cosine = (a - b) @ (c - b) / np.linalg.norm(a - b) / np.linalg.norm(c - b)
    assert abs(cosine) < np.sin(np.radians(1.0))


def test_a_length_and_a_resolution_say_the_scale(tmp_path):
    picture, _ = sheet(*storey(wall=80, fill=[(255, 235, 215)]))
    path = saved(tmp_path, picture)
    stated = read_plan(path, ReadOptions(resolution_m=1.0 / PX_PER_M))
    assert stated.scale.source is ScaleSource.STATED
    length = (160.0, 160.0, 160.0 + 28.0 * PX_PER_M, 160.0, 28.0)
    measured = read_plan(path, ReadOptions(length=length))
    assert measured.scale.source is ScaleSource.LENGTH
    assert measured.scale.resolution_m == pytest.approx(1.0 / PX_PER_M, rel=1e-6)
    assert measured.grid.resolution == pytest.approx(stated.grid.resolution, rel=1e-6)
    estimated = read_plan(path)
    assert estimated.scale.source is ScaleSource.ESTIMATED
    assert estimated.scale.low_m < 1.0 / PX_PER_M < estimated.scale.high_m


def test_a_crop_is_all_that_is_read(tmp_path):
    picture, labels = storey()
    both = np.concatenate([picture, np.full_like(picture[:40], WHITE), picture])
    offset = len(picture) + 40
    path = saved(tmp_path, both)
    crop = (0, offset, both.shape[1], both.shape[0])
    reading = read_plan(path, ReadOptions(crop=crop))
    shifted = np.pad(labels, ((offset, 0), (0, 0)))
    assert room_f1(reading, shifted) > GOOD_F1
    with pytest.raises(MapFormatError, match='crop'):
        read_plan(path, ReadOptions(crop=(0, 0, 5, 5)))


def _cat(rng):
    """Blurred noise of all sizes: what photographs look like to a reader of plans."""
    picture = np.zeros((600, 800, 3))
    for sigma in (2, 8, 30):
        picture += sigma * cv2.GaussianBlur(rng.normal(size=picture.shape), (0, 0), sigma)
    low, high = picture.min(), picture.max()
    return ((picture - low) / (high - low) * 255).astype(np.uint8)


@pytest.mark.parametrize('kind', ['white', 'black', 'pixel', 'noise', 'cat', 'line', 'box'])
def test_what_is_no_plan_is_refused_or_doubted(tmp_path, kind):
    rng = np.random.default_rng(5)
    picture = {
        'white': np.full((300, 400, 3), 255, np.uint8),
        'black': np.zeros((300, 400, 3), np.uint8),
        'pixel': np.zeros((1, 1, 3), np.uint8),
        'noise': rng.integers(0, 256, (500, 600, 3)).astype(np.uint8),
        'cat': _cat(rng),
        'line': cv2.line(np.full((300, 400, 3), 255, np.uint8), (20, 20), (380, 200), 0, 3),
        'box': cv2.rectangle(np.full((300, 400, 3), 255, np.uint8), (50, 50), (350, 250), 0, 3),
    }[kind]
    try:
        reading = read_plan(saved(tmp_path, picture))
    except MapFormatError as error:
        assert '\n' not in str(error)  # noqa: PT017
    else:
        assert reading.doubts


@pytest.mark.parametrize(
    ('options', 'message'),
    [
        (ReadOptions(length=(0.0, 0.0, 10.0, 10.0)), 'length: expected 5 numbers'),
        (ReadOptions(crop=(0, 0)), 'crop: expected 4 numbers'),
        (ReadOptions(storey=0), 'storey: expected a number of at least 1, got 0'),
        (ReadOptions(page=0), 'page: expected a number of at least 1, got 0'),
        (ReadOptions(1.0, (0.0, 0.0, 9.0, 9.0, 1.0)), 'resolution and length both state'),
        (ReadOptions(np.inf), 'resolution must be positive metres per pixel, got inf'),
    ],
)
def test_options_that_cannot_be_are_named(tmp_path, options, message):
    with pytest.raises(MapFormatError, match=message):
        read_plan(tmp_path / 'any.png', options)


@pytest.mark.parametrize(
    'options',
    [
        ReadOptions(resolution_m=1e-6),
        ReadOptions(resolution_m=1e9),
        ReadOptions(length=(0.0, 0.0, 200.0, 0.0, 1e-4)),
    ],
)
@pytest.mark.parametrize('is_map', [False, True])
def test_a_scale_of_no_building_is_refused(tmp_path, options, is_map):
    picture, _ = storey()
    path = saved(tmp_path, picture)
    if is_map:
        path = path.with_suffix('.yaml')
        path.write_text('image: plan.png\nresolution: 0.05\norigin: [0, 0, 0]\n')
    with pytest.raises(MapFormatError, match=r'm long, implausible for a building; give'):
        read_plan(path, options)


def test_a_cover_is_no_building_but_there_are_other_pages(tmp_path):
    path, picture = tmp_path / 'plan.tif', Image.fromarray(storey()[0])
    cover = Image.new('L', picture.size, 255)
    cover.save(path, save_all=True, append_images=[picture.convert('L')])
    with pytest.raises(MapFormatError, match=r'shows no building.*; page 1 of 2 was read.*--page'):
        read_plan(path)
    assert read_plan(path, ReadOptions(page=2)).is_readable
