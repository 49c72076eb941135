# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Large pictures are read from a smaller copy, and all places are in pixels of the picture."""

import struct
import zlib

import numpy as np
from PIL import Image
from planted import plan_grid
import pytest
from scipy.spatial.distance import pdist

from fpnet_core.drawings.formats import images
from fpnet_core.drawings.formats.images import open_image
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.raster.pixels import map_points
from fpnet_core.types import FREE


def test_places_are_those_of_the_picture_itself(tmp_path, monkeypatch):
    """The planted building at 2.5 cm per pixel, read at 5 cm, with a length and a crop."""
    walls = np.where(plan_grid().cells == FREE, 255, 0).astype(np.uint8)[::-1]
    Image.fromarray(np.kron(walls, np.ones((2, 2), np.uint8))).save(tmp_path / 'a.png')
    height, width = (2 * side for side in walls.shape)
    options = ReadOptions(length=(0, 0, 400, 0, 10.0))
    whole = read_plan(tmp_path / 'a.png', options)
    monkeypatch.setattr(images, 'WORK_PIXELS', walls.size)
    small = read_plan(tmp_path / 'a.png', options)
    assert small.drawing.is_reduced
    assert small.drawing.size == (width, height)
    assert small.grid.resolution == pytest.approx(0.05)
    assert small.scale.resolution_m == pytest.approx(whole.scale.resolution_m)
    places = np.array([[0.0, 0.0], [width - 1.0, 10.0], [300.0, height - 1.0]])
    # Each has a frame of its own.
    apart = [pdist(map_points(reading.H_plan_image, places)) for reading in (small, whole)]
    np.testing.assert_allclose(*apart, rtol=0.01)
    stated = read_plan(tmp_path / 'a.png', ReadOptions(resolution_m=0.025))
    assert stated.grid.resolution == pytest.approx(0.05)
    assert any(f'image of {width} x {height} pixels' in note for note in stated.notes)
    with pytest.raises(MapFormatError, match=f'within 0, 0, {width}, {height}'):
        read_plan(tmp_path / 'a.png', ReadOptions(crop=(0, 0, width + 1, 40)))


def chunk(name, body):
    return struct.pack('>I', len(body)) + name + body + struct.pack('>I', zlib.crc32(name + body))


def png_of(width, height):
    """A PNG of such a size, whose pixels are missing."""
    head = struct.pack('>IIBBBBB', width, height, 8, 0, 0, 0, 0)
    return b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) + chunk(b'IDAT', zlib.compress(b''))


@pytest.mark.parametrize('size', [(14_000, 14_000), (60_000, 60_000)])
def test_what_cannot_be_reduced_is_refused_before_it_is_decoded(tmp_path, size):
    (tmp_path / 'a.png').write_bytes(png_of(*size))
    with pytest.raises(MapFormatError, match='too large: expected at most 1'):
        open_image(tmp_path / 'a.png')


@pytest.fixture
def jpeg_of(tmp_path):
    """Write a grey JPEG of a size, most of whose pixels are missing."""
    Image.fromarray(np.full((16, 16), 200, np.uint8)).save(tmp_path / 'a.jpg')
    data = (tmp_path / 'a.jpg').read_bytes()
    at = data.index(b'\xff\xc0') + 5

    def write(width, height):
        size = struct.pack('>HH', height, width)
        (tmp_path / 'a.jpg').write_bytes(data[:at] + size + data[at + 4 :])
        return tmp_path / 'a.jpg'

    return write


def test_a_jpeg_is_decoded_at_a_fraction_of_its_size(jpeg_of):
    drawing = open_image(jpeg_of(15_000, 14_000))
    assert drawing.size == (15_000, 14_000)
    assert max(drawing.pixels.shape) == pytest.approx(4140, abs=2)
    with pytest.raises(MapFormatError, match='expected at most 500 million'):
        open_image(jpeg_of(40_000, 20_000))


GREY = np.kron(np.random.default_rng(8).integers(0, 256, (40, 60), np.uint8), np.ones((2, 2)))


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(images, 'WORK_PIXELS', 40 * 60)
    monkeypatch.setattr(images, '_STRIP_ROWS', 7)


@pytest.mark.parametrize('code', [1, 3, 6, 8])
def test_a_reduced_photograph_is_upright_as_well(few, tmp_path, code):
    image = Image.fromarray(GREY.astype(np.uint8))
    exif = image.getexif()
    exif[0x0112] = code
    image.save(tmp_path / 'a.png', exif=exif)
    drawing = open_image(tmp_path / 'a.png')
    assert drawing.size == ((120, 80) if code < 5 else (80, 120))
    for x, y in ((0, 0), (118, 0), (40, 70)):
        u, v = (drawing.A_pixel_image @ (x, y, 1) / 2).astype(int)
        assert drawing.pixels[v, u, 0] == GREY[y, x]


def test_a_part_is_read_with_all_its_pixels(few, tmp_path):
    Image.fromarray(GREY.astype(np.uint8)).save(tmp_path / 'a.png')
    assert not open_image(tmp_path / 'a.png', crop=(10, 10, 50, 50)).is_reduced
    assert open_image(tmp_path / 'a.png', crop=(0, 0, 120, 70)).is_reduced
