# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images come upright, in colour, on white."""

import numpy as np
from PIL import Image
import pytest

from fpnet_core.drawings.formats.images import open_image

PIXELS = np.random.default_rng(8).integers(0, 256, (5, 7, 3), dtype=np.uint8)


@pytest.mark.parametrize('code', range(1, 9))
def test_turned_photographs_are_upright_and_the_affine_knows(tmp_path, code):
    image = Image.fromarray(PIXELS)
    exif = image.getexif()
    exif[0x0112] = code
    image.save(tmp_path / 'a.png', exif=exif)
    drawing = open_image(tmp_path / 'a.png')
    assert drawing.pixels.shape[:2] == ((5, 7) if code < 5 else (7, 5))
    for x, y in ((0, 0), (6, 0), (2, 4)):
        u, v = drawing.A_pixel_image @ (x, y, 1)
        assert drawing.pixels[int(v), int(u)].tolist() == PIXELS[y, x].tolist()


def test_transparent_is_white_and_16_bits_are_8(tmp_path):
    Image.fromarray(np.dstack([PIXELS, np.zeros((5, 7), np.uint8)])).save(tmp_path / 'a.png')
    assert (open_image(tmp_path / 'a.png').pixels == 255).all()
    deep = np.array([[0, 65535], [32768, 257]], np.uint16)
    Image.fromarray(deep).save(tmp_path / 'b.png')
    assert open_image(tmp_path / 'b.png').pixels[..., 0].tolist() == [[0, 255], [128, 1]]
