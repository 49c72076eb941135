# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What bare pictures mean: drawings on white, on grey, scans, robot maps."""

import io

import numpy as np
from PIL import Image
import pytest
from scipy import ndimage

from fpnet_core.errors import MapFormatError
from fpnet_core.io.images import grey_levels, interpret, load_pixels
from fpnet_core.io.outside import outside_as_unknown
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

RESOLUTION_M = 0.05
INSIDE = (slice(43, 157), slice(43, 257))


def building(outside=255, line=0, free=255):
    """Two rooms of 5.5 m with 3-pixel walls, joined by a door of 1 m, a 1 m exit to the right."""
    picture = np.full((200, 300), outside, np.uint8)
    picture[40:160, 40:260] = line
    picture[43:157, 43:148] = free
    picture[43:157, 151:257] = free
    picture[90:110, 148:151] = free
    picture[90:110, 257:260] = free
    return picture


@pytest.mark.parametrize('outside', [255, 205, 180, 127])
@pytest.mark.parametrize('line', [0, 100])
def test_outside_is_unknown_whatever_its_shade(outside, line):
    cells = interpret(building(outside, line), RESOLUTION_M)
    assert (cells[:35] == UNKNOWN).all()
    assert (cells[60, 43:148] == FREE).all()
    assert (cells[60, 148:151] == OCCUPIED).all()
    assert (cells[100, 148:151] == FREE).all()
    assert (cells[40, 60:200] == OCCUPIED).all()


def test_light_walls_on_a_darker_outside():
    """As several published plans are drawn: walls at 170 in a surrounding of 178."""
    cells = interpret(building(outside=178, line=170), RESOLUTION_M)
    assert (cells[60, 148:151] == OCCUPIED).all()
    assert cells[5, 5] == UNKNOWN


def test_a_robot_map_of_two_tones_has_walls_where_its_free_space_ends():
    """Free 255 on 153 and nothing else, as some robot maps are published."""
    picture = building(outside=153, line=153)
    cells = interpret(picture, RESOLUTION_M)
    assert (cells[picture == 255] == FREE).all()
    assert (cells[60, 148:151] == OCCUPIED).all()
    assert cells[5, 5] == UNKNOWN


def test_black_surroundings_are_walls_at_the_surface_only():
    picture = building(outside=0)
    cells = interpret(picture, RESOLUTION_M)
    assert cells[42, 100] == OCCUPIED
    assert cells[5, 5] == UNKNOWN


@pytest.mark.parametrize('fill', [204, 211])
def test_walls_filled_lighter_than_the_outside(fill):
    """Outlines at 164, walls filled lighter than the surrounding 180."""
    picture = building(outside=180)
    drawn = picture == 0
    picture[drawn] = fill
    picture[drawn & ~ndimage.binary_erosion(drawn)] = 164
    picture[20:36, 20:280] = fill
    cells = interpret(picture, RESOLUTION_M)
    assert (cells[drawn] == OCCUPIED).all()


def test_shaded_confidence_between_unknown_and_free_is_unknown():
    picture = building(outside=127)
    picture[43:157, 200:257] = np.linspace(135, 185, 57).astype(np.uint8)
    cells = interpret(picture, RESOLUTION_M)
    assert (cells[60:140, 205:250] == UNKNOWN).all()


def test_scanned_paper_with_noise_and_compression():
    rng = np.random.default_rng(8)
    clean = building()
    noisy = np.clip(clean * (240 / 255) + rng.normal(0, 5, clean.shape), 0, 255).astype(np.uint8)
    data = io.BytesIO()
    Image.fromarray(noisy).save(data, 'JPEG', quality=70)
    cells = interpret(np.asarray(Image.open(data)), RESOLUTION_M)
    wanted = interpret(clean, RESOLUTION_M)
    agreement = (cells == wanted)[INSIDE].mean()
    assert agreement > 0.97


def test_wide_open_picture_is_left_alone():
    """Without an enclosing wall, removing the outside would remove everything."""
    picture = np.full((100, 100), 255, np.uint8)
    picture[20:80, 50] = 0
    cells = interpret(picture, RESOLUTION_M)
    assert (cells != UNKNOWN).all()


def test_outside_reaches_through_wide_gaps_only():
    cells = np.where(building() == 255, FREE, OCCUPIED).astype(np.int8)
    closed = outside_as_unknown(cells, RESOLUTION_M)
    assert closed[100, 200] == FREE
    cells[50:150, 257:260] = FREE
    opened = outside_as_unknown(cells, RESOLUTION_M)
    assert opened[100, 200] == UNKNOWN
    assert opened[100, 100] == FREE


def test_niches_of_the_outer_wall_leave_no_crumbs():
    picture = building()
    picture[20:40, 100:103] = picture[20:40, 110:113] = 0
    cells = interpret(picture, RESOLUTION_M)
    labels, count = ndimage.label(cells == FREE)
    assert count == 1
    assert labels[100, 100] == 1


@pytest.mark.parametrize('porch', [0, 20])
def test_a_hall_behind_an_open_entrance_is_inside(porch):
    """1.6 m wide, its other doors drawn shut; the entrance at its end, or set back in a porch."""
    cells = np.full((220, 200), FREE, np.int8)
    cells[40:200, 20:180] = OCCUPIED
    cells[46:195, 26:76] = cells[46:195, 79:111] = cells[46:195, 114:175] = FREE
    cells[40:46, 79:111] = FREE if porch else OCCUPIED
    cells[46 + porch - 6 : 46 + porch, 79:111] = OCCUPIED
    cells[40 + porch : 46 + porch, 85:104] = FREE
    closed = outside_as_unknown(cells, RESOLUTION_M)
    assert (closed[150, 80:110] == FREE).all()
    assert closed[30, 95] == UNKNOWN


def test_a_room_with_one_wide_gate_is_inside():
    """4 m wide and deep, and open to the ground by 3 m."""
    cells = np.full((220, 200), FREE, np.int8)
    cells[40:200, 20:180] = OCCUPIED
    cells[46:126, 26:106] = cells[132:195, 26:175] = cells[46:126, 112:175] = FREE
    cells[40:46, 36:96] = FREE
    closed = outside_as_unknown(cells, RESOLUTION_M)
    assert (closed[70:126, 26:106] == FREE).all()
    assert closed[20, 66] == UNKNOWN


def test_a_house_that_is_open_wherever_one_looks_is_left_alone():
    """One side of it has a gap of 6 m, and rooms are open to one another by 2.5 m and more."""
    cells = np.full((220, 330), FREE, np.int8)
    cells[30:190, 30:300] = OCCUPIED
    cells[36:184, 36:96] = cells[36:184, 100:294] = FREE
    cells[30:36, 170:290] = cells[80:135, 96:100] = cells[80:140, 30:36] = FREE
    np.testing.assert_array_equal(outside_as_unknown(cells, RESOLUTION_M), cells)


def test_a_recess_as_wide_as_its_mouth_is_outside():
    cells = np.where(building() == 255, FREE, OCCUPIED).astype(np.int8)
    cells[40:90, 190:230] = OCCUPIED
    cells[40:87, 194:226] = FREE
    closed = outside_as_unknown(cells, RESOLUTION_M)
    assert (closed[42:87, 194:226] == UNKNOWN).all()
    assert closed[100, 210] == FREE


@pytest.mark.parametrize('level', [0, 60, 120])
def test_dark_picture_has_no_free_space(level):
    with pytest.raises(MapFormatError, match='no free space'):
        interpret(np.full((50, 50), level, np.uint8), RESOLUTION_M)


@pytest.mark.parametrize(
    ('mode', 'channels'), [('L', 1), ('LA', 2), ('RGB', 3), ('RGBA', 4), ('1', 1), ('P', 3)]
)
def test_every_image_mode_gives_the_same_grey(tmp_path, mode, channels):
    image = Image.fromarray(building()).convert(mode)
    image.save(tmp_path / 'plan.png')
    pixels = load_pixels(tmp_path / 'plan.png')
    assert pixels.shape == (200, 300, channels)
    np.testing.assert_array_equal(grey_levels(pixels), building())


def test_transparent_is_white():
    pixels = np.zeros((2, 2, 4), np.float32)
    pixels[0, 0, 3] = 1.0
    np.testing.assert_array_equal(grey_levels(pixels), [[0, 255], [255, 255]])
