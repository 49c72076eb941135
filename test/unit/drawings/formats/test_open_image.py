# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images as they come: turned by a camera, transparent, with palettes, of 16 bits."""

import numpy as np
from PIL import Image
import pytest

from fpnet_core.drawings.formats.images import open_image
from fpnet_core.errors import MapFormatError

ORIENTATION = 0x0112


def marked():
    """A picture with one black pixel at (x 5, y 2)."""
    picture = np.full((20, 30, 3), 255, np.uint8)
    picture[2, 5] = 0
    return picture


@pytest.mark.parametrize('turn', range(1, 9))
def test_the_cameras_turn_is_undone_and_kept(tmp_path, turn):
    exif = Image.Exif()
    exif[ORIENTATION] = turn
    path = tmp_path / 'photo.png'
    Image.fromarray(marked()).save(path, exif=exif)
    drawing = open_image(path)
    x, y = drawing.A_pixel_image @ [5.0, 2.0, 1.0]
    assert (drawing.pixels[round(y), round(x)] == 0).all()
    assert drawing.pixels.shape[:2] == ((20, 30) if turn < 5 else (30, 20))
    assert bool(drawing.notes) == (turn > 1)


def test_transparent_places_are_white(tmp_path):
    rgba = np.zeros((10, 10, 4), np.uint8)
    rgba[3, 3] = (10, 20, 30, 255)
    Image.fromarray(rgba).save(tmp_path / 'a.png')
    pixels = open_image(tmp_path / 'a.png').pixels
    assert pixels[3, 3].tolist() == [10, 20, 30]
    assert (pixels[0] == 255).all()


@pytest.mark.parametrize('is_hole', [False, True])
def test_what_is_light_and_transparent_lies_on_black(tmp_path, is_hole):
    rgba = np.full((10, 10, 4), 255, np.uint8)
    rgba[..., 3] = 255 * is_hole
    rgba[3, 3, 3] = 255 * (not is_hole)
    Image.fromarray(rgba).save(tmp_path / 'a.png')
    pixels = open_image(tmp_path / 'a.png').pixels
    assert (pixels[3, 3] == (0 if is_hole else 255)).all()
    assert (pixels[0] == (255 if is_hole else 0)).all()


def test_transparent_palettes_and_16_bits(tmp_path):
    image = Image.new('P', (8, 6), 1)
    image.putpalette([0, 0, 0, 200, 100, 50])
    image.putpixel((2, 1), 0)
    image.save(tmp_path / 'p.png', transparency=1)
    pixels = open_image(tmp_path / 'p.png').pixels
    assert pixels[1, 2].tolist() == [0, 0, 0]
    assert pixels[0, 0].tolist() == [255, 255, 255]
    deep = np.full((6, 8), 65535, np.uint16)
    deep[4, 4] = 257 * 40
    Image.fromarray(deep).save(tmp_path / 'deep.png')
    assert open_image(tmp_path / 'deep.png').pixels[4, 4].tolist() == [40, 40, 40]


def test_no_image_is_one_clear_line(tmp_path):
    (tmp_path / 'x.png').write_bytes(b'not an image')
    with pytest.raises(MapFormatError, match='not a readable image'):
        open_image(tmp_path / 'x.png')
    with pytest.raises(MapFormatError, match='does not exist'):
        open_image(tmp_path / 'y.png')
