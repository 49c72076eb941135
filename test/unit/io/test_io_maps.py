# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""map_server maps and their images: values, orientation, and what is refused."""

import numpy as np
from PIL import Image
import pytest
import yaml

from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import SE2
from fpnet_core.io.images import MAX_PIXELS
from fpnet_core.io.maps import read_map, read_map_part, states_scale, write_map
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

FIELDS = {
    'image': 'map.png', 'resolution': 0.1, 'origin': [-1.5, 2.5, 0.4], 'negate': 0,
    'occupied_thresh': 0.65, 'free_thresh': 0.196,
}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    """Write a map into a temporary folder; returns the YAML's path."""

    def write(pixels, name='map.png', **changes):
        fields = {**FIELDS, 'image': name, **changes}
        Image.fromarray(np.asarray(pixels)).save(tmp_path / name)
        fields = {key: value for key, value in fields.items() if value is not None}
        (tmp_path / 'map.yaml').write_text(yaml.safe_dump(fields))
        return tmp_path / 'map.yaml'

    return write


def grey(rows):
    return np.array(rows, dtype=np.uint8)


def test_trinary_values_rows_and_pose(folder):
    grid = read_map(folder(grey([[0, 254, 205], [254, 254, 254]])))
    # The lower image row is row 0.
    np.testing.assert_array_equal(grid.cells, [[FREE, FREE, FREE], [OCCUPIED, FREE, UNKNOWN]])
    assert grid.resolution == 0.1
    assert grid.frame == 'plan'
    assert (grid.T_frame_grid.x, grid.T_frame_grid.y) == (-1.5, 2.5)
    assert grid.T_frame_grid.yaw == pytest.approx(0.4)


def test_of_a_large_map_the_known_part_is_read_where_it_is(folder):
    pixels = np.full((2100, 2000), 205, np.uint8)
    pixels[1500:1700, 400:700] = 254
    pixels[1500, 400:700] = 0
    part = read_map_part(folder(pixels))
    # 20 cells of what is unknown around it, row 0 at the bottom of the picture
    assert part.grid.shape == (240, 340)
    assert (part.left, part.top, part.size) == (380, 1480, (2000, 2100))
    whole = GridMap(np.zeros((2100, 2000), np.int8), 0.1, SE2.from_xy_yaw(-1.5, 2.5, 0.4))
    np.testing.assert_allclose(part.A_frame_pixel, pixel_to_xy(whole).matrix, atol=1e-9)
    np.testing.assert_allclose(
        part.grid.rc_to_xy([0, 0]), whole.rc_to_xy([2100 - 1480 - 240, 380]), atol=1e-9
    )
    assert (part.grid.cells[219, 20:320] == OCCUPIED).all()
    assert (part.grid.cells[220] == UNKNOWN).all()


def test_negate_swaps_black_and_white(folder):
    grid = read_map(folder(grey([[0, 255]]), negate=1))
    np.testing.assert_array_equal(grid.cells, [[FREE, OCCUPIED]])


def test_thresholds_are_used(folder):
    # 255 - 128 = 127, 127 / 255 = 0.498
    pixels = grey([[128, 255, 0]])
    assert read_map(folder(pixels)).cells[0, 0] == UNKNOWN
    assert read_map(folder(pixels, occupied_thresh=0.45)).cells[0, 0] == OCCUPIED
    assert read_map(folder(pixels, free_thresh=0.55)).cells[0, 0] == FREE


def test_scale_mode_keeps_the_middle_unknown_and_honours_alpha(folder):
    pixels = np.array(
        [[[0, 0, 0, 255], [255] * 4, [120, 120, 120, 255], [255, 255, 255, 7]]], np.uint8
    )
    grid = read_map(folder(pixels, mode='scale'))
    np.testing.assert_array_equal(grid.cells, [[OCCUPIED, FREE, UNKNOWN, UNKNOWN]])


@pytest.mark.parametrize('mode', ['LA', 'RGBA'])
def test_trinary_mode_averages_alpha_with_three_colours(folder, mode):
    """map_server sees red, green, blue and alpha of a grey picture with alpha as well."""
    path = folder(grey([[0, 255, 0]]), 'map.png')
    image = Image.open(path.parent / 'map.png').convert(mode)
    image.putpixel((2, 0), (0,) * len(mode))
    image.save(path.parent / 'map.png')
    np.testing.assert_array_equal(read_map(path).cells, [[OCCUPIED, FREE, OCCUPIED]])


def test_modes_are_words_in_any_case_as_for_map_server(folder):
    path = folder(grey([[0, 100, 50, 255, 90]]), mode='Raw')
    np.testing.assert_array_equal(
        read_map(path).cells, [[FREE, OCCUPIED, UNKNOWN, UNKNOWN, OCCUPIED]]
    )


def test_colours_and_sixteen_bits(folder):
    colour = np.zeros((1, 2, 3), np.uint8)
    colour[0, 1] = 255
    np.testing.assert_array_equal(read_map(folder(colour)).cells, [[OCCUPIED, FREE]])
    deep = np.array([[0, 65535]], dtype=np.uint16)
    np.testing.assert_array_equal(read_map(folder(deep)).cells, [[OCCUPIED, FREE]])


def test_resolution_argument_overrides(folder):
    assert read_map(folder(grey([[0, 254]])), resolution_m=0.02).resolution == 0.02


def test_round_trip_through_files(tmp_path):
    rng = np.random.default_rng(11)
    cells = rng.choice(np.array([FREE, OCCUPIED, UNKNOWN], np.int8), (13, 8))
    grid = GridMap(cells, 0.05, SE2.from_xy_yaw(3.25, -7.5, -1.1))
    write_map(grid, tmp_path / 'new' / 'plan.yaml')
    back = read_map(tmp_path / 'new' / 'plan.yaml')
    np.testing.assert_array_equal(back.cells, grid.cells)
    np.testing.assert_allclose(back.T_frame_grid.matrix, grid.T_frame_grid.matrix)
    assert back.resolution == grid.resolution


def test_pixel_to_xy_puts_the_top_left_pixel_highest():
    grid = GridMap(np.zeros((40, 30), np.int8), 0.1)
    A = pixel_to_xy(grid)
    np.testing.assert_allclose(A.apply([0, 0]), [0.05, 3.95])
    np.testing.assert_allclose(A.apply([29, 39]), [2.95, 0.05])
    assert A.is_mirrored


def test_pixel_to_xy_agrees_with_the_raster_in_a_turned_frame():
    grid = GridMap(np.zeros((40, 30), np.int8), 0.07, SE2.from_xy_yaw(5.0, -2.0, 0.83))
    u, v = 21.0, 4.0
    np.testing.assert_allclose(pixel_to_xy(grid).apply([u, v]), grid.rc_to_xy([39.0 - v, u]))


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'resolution': None}, 'resolution is missing'),
        ({'resolution': 0.0}, 'resolution must be positive'),
        ({'resolution': 'fine'}, "finite number, got 'fine'"),
        ({'origin': None}, 'origin must be'),
        ({'origin': [0.0, 1.0]}, 'origin must be'),
        ({'origin': [0.0, 1.0, float('nan')]}, 'finite'),
        ({'image': None}, 'image must name'),
        ({'image': 'a\0b'}, 'image must name'),
        ({'image': 'nowhere.png'}, 'nowhere.png does not exist'),
        ({'mode': 'fuzzy'}, 'mode must be one of'),
        ({'free_thresh': 0.7}, 'free_thresh <= occupied_thresh'),
        ({'negate': 1, 'occupied_thresh': 0.9, 'free_thresh': 0.0}, 'no free space'),
    ],
)
def test_bad_yaml_is_named(folder, changes, message):
    with pytest.raises(MapFormatError, match=message):
        read_map(folder(grey([[0, 254], [254, 254]]), **changes))


@pytest.mark.parametrize(
    'text', ['', '- 1', 'image: [', '\x00', 'image: &a [*a]', '!!python/object:os.system {}']
)
def test_yaml_that_is_none(tmp_path, text):
    path = tmp_path / 'map.yaml'
    path.write_text(text)
    with pytest.raises(MapFormatError):
        read_map(path)


@pytest.mark.parametrize('value', [0, 205, 254])
def test_maps_of_one_value_hold_nothing(folder, value):
    with pytest.raises(MapFormatError, match=r'no free space|only free space'):
        read_map(folder(np.full((20, 30), value, np.uint8)))


def test_absurd_size_is_refused_before_decoding(tmp_path):
    """A few hundred bytes claim 10 gigapixels."""
    side = 100_000
    path = tmp_path / 'huge.pgm'
    path.write_bytes(f'P5 {side} {side} 255\n'.encode() + b'\0' * 100)
    with pytest.raises(MapFormatError, match=f'at most {MAX_PIXELS // 1_000_000} million'):
        read_map(path)


@pytest.mark.parametrize('resolution_m', [0.0, -0.1, float('nan'), float('inf')])
def test_bad_resolution_argument(folder, resolution_m):
    with pytest.raises(MapFormatError, match='resolution'):
        read_map(folder(grey([[0, 254]])), resolution_m)


def test_missing_files(tmp_path):
    for name in ('none.yaml', 'none.png'):
        with pytest.raises(MapFormatError, match='none'):
            read_map(tmp_path / name)
    with pytest.raises(MapFormatError):
        read_map(tmp_path)


@pytest.mark.parametrize('name', ['a.yaml', 'A.YML', 'scan.ply', 'scan.npy', 'b.tar.pcd'])
def test_maps_of_map_server_and_clouds_state_their_scale(tmp_path, name):
    assert states_scale(tmp_path / name)
    assert states_scale(str(tmp_path / name))


@pytest.mark.parametrize('name', ['a.png', 'a.PGM', 'a.yaml.jpg', 'a.webp', 'yaml', 'a.yaml/b'])
def test_bare_images_do_not_state_their_scale(tmp_path, name):
    assert not states_scale(tmp_path / name)


def test_raw_mode_takes_pixels_as_percent(folder):
    grid = read_map(folder(grey([[0, 100, 50, 255, 90]]), mode='raw'))
    np.testing.assert_array_equal(grid.cells, [[FREE, OCCUPIED, UNKNOWN, UNKNOWN, OCCUPIED]])
