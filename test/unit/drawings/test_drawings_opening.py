# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a file is, and one line on each that is not read."""

import dataclasses

import numpy as np
from PIL import Image
from plan_files import write_dxf, write_svg
import pytest

from fpnet_core.drawings.formats import worker
from fpnet_core.drawings.opening import drawing_kind, open_drawing
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError

pytestmark = pytest.mark.usefixtures('own_process')
PLAIN = np.random.default_rng(3).integers(0, 256, (20, 30, 3), dtype=np.uint8)


@pytest.mark.parametrize(
    ('name', 'head', 'kind'),
    [
        ('a.pdf', b'%PDF-1.7\n', 'pdf'),
        ('a.ai', b'\n\n%PDF-1.4', 'pdf'),
        ('a.dxf', b'  0\r\nSECTION\r\n  2\r\nHEADER', 'dxf'),
        ('a.dxf', b'999\nmade by hand\n0\nSECTION\n', 'dxf'),
        ('a.dxf', b'AutoCAD Binary DXF\r\n', 'dxf'),
        ('a.svg', b'<?xml version="1.0"?><!-- a --><svg xmlns="x">', 'svg'),
        ('a.svg', '<svg width="1">'.encode('utf-16'), 'svg'),
        ('a.svgz', b'\x1f\x8b\x08', 'svg'),
        ('a.ifc', b'ISO-10303-21;\nHEADER;', 'ifc'),
        ('a.png', b'\x89PNG\r\n', 'image'),
        ('plan', b'\xff\xd8\xff\xe0', 'image'),
        ('a.pgm', b'P5 3 3 255\n', 'image'),
        ('a.webp', b'RIFF\1\0\0\0WEBP', 'image'),
        ('a.gif', b'GIF89a', 'image'),
    ],
)
def test_the_content_says_what_a_file_is(tmp_path, name, head, kind):
    (tmp_path / name).write_bytes(head)
    assert drawing_kind(tmp_path / name) == kind


@pytest.mark.parametrize(
    ('name', 'data', 'message'),
    [
        ('a.dwg', b'AC1032' + bytes(50), 'ODA File Converter or LibreCAD'),
        ('a.bin', b'AC1027' + bytes(50), 'ODA File Converter or LibreCAD'),
        ('a.heic', b'\0\0\0\x18ftypheic' + bytes(9), 'heif-convert'),
        ('a.jpg', b'\0\0\0\x18ftypheic' + bytes(9), 'heif-convert'),
        ('a.rvt', b'\xd0\xcf\x11\xe0' + bytes(50), 'export it as IFC'),
        ('a.docx', b'PK\3\4' + bytes(50), 'LibreOffice'),
        ('a.vsdx', b'PK\3\4' + bytes(50), 'Visio'),
        ('a.ai', b'%!PS-Adobe-3.0', 'ps2pdf'),
        ('a.avif', b'hello', 'ImageMagick'),
        ('a.cdr', b'RIFF\1\0\0\0CDR9', 'CorelDRAW'),
        ('a.wav', b'RIFF\1\0\0\0WAVE', 'expected PNG'),
        ('a.xyz', b'PK\3\4' + bytes(50), 'unpack it'),
        ('a.pdf', b'hello', 'not PDF despite its suffix'),
        ('a.step', b'ISO-10303-21;', 'expected PNG'),
        ('a.xyz', b'hello', 'expected PNG'),
        ('a.dxf', b'', 'is empty'),
        ('a.png', bytes(100), 'is empty'),
    ],
)
def test_other_files_are_refused_with_what_to_do(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(MapFormatError, match=rf'\A[^\n]*{message}[^\n]*\Z'):
        open_drawing(tmp_path / name)


def test_missing_files_and_folders(tmp_path):
    with pytest.raises(MapFormatError, match='does not exist'):
        open_drawing(tmp_path / 'a.pdf')
    with pytest.raises(MapFormatError, match='is a folder'):
        open_drawing(tmp_path)


@pytest.mark.parametrize(
    ('options', 'name'), [(ReadOptions(page=3), 'page'), (ReadOptions(layers=('A',)), 'layers')]
)
def test_images_have_no_pages_and_layers(tmp_path, options, name):
    Image.fromarray(PLAIN).save(tmp_path / 'a.png')
    with pytest.raises(MapFormatError, match=f'a.png is an image, which has no {name}'):
        open_drawing(tmp_path / 'a.png', options)


@pytest.mark.parametrize(('write', 'kind'), [(write_svg, 'an SVG'), (write_dxf, 'a DXF')])
def test_formats_without_pages_say_so(tmp_path, write, kind):
    path = write(tmp_path / 'a.x')
    with pytest.raises(MapFormatError, match=f'a.x is {kind}, which has no pages; omit the page'):
        open_drawing(path, ReadOptions(page=2))


def test_a_tiff_has_pages(tmp_path):
    path, cover = tmp_path / 'a.tif', np.full((40, 50, 3), 255, np.uint8)
    Image.fromarray(cover).save(path, save_all=True, append_images=[Image.fromarray(PLAIN)])
    first = open_drawing(path)
    assert first.pixels.shape == cover.shape
    assert first.notes == ('page 1 of 2 was read; select others by --page',)
    second = open_drawing(path, ReadOptions(page=2))
    assert np.array_equal(second.pixels, PLAIN)
    assert second.notes == ()
    with pytest.raises(MapFormatError, match=r'a\.tif has 2 pages; there is no page 3'):
        open_drawing(path, ReadOptions(page=3))


@pytest.mark.parametrize('suffix', ['webp', 'gif'])
def test_pictures_that_browsers_save(tmp_path, suffix):
    """Of several in one file the first counts."""
    pixels = PLAIN // 64 * 64  # a GIF holds 256 colours
    path, other = tmp_path / f'a.{suffix}', Image.fromarray(255 - pixels)
    Image.fromarray(pixels).save(path, lossless=True, save_all=True, append_images=[other])
    assert np.array_equal(open_drawing(path).pixels, pixels)


def test_a_wrong_name_is_no_obstacle(tmp_path):
    Image.fromarray(PLAIN).save(tmp_path / 'a.pdf', 'PNG')
    drawing = open_drawing(tmp_path / 'a.pdf')
    assert np.array_equal(drawing.pixels, PLAIN)
    assert drawing.notes == ('its suffix is .pdf, but it contains an image',)


def test_a_drawing_survives_the_way_between_processes(tmp_path):
    from fpnet_core.drawings.formats.svg import read_svg
    from fpnet_core.drawings.formats.vector import drawing_of
    from fpnet_core.drawings.model import model_to_json
    from fpnet_core.drawings.types import DrawingScale, ScaleSource

    page = read_svg(write_svg(tmp_path / 'a.svg'), ReadOptions())
    drawing = dataclasses.replace(
        drawing_of(page, 'a.svg', 'svg', ReadOptions()),
        scale=DrawingScale(0.02, 0.019, 0.021, ScaleSource.UNITS, 'why'),
        doubts=('a', 'b'),
    )
    found = worker.unpack(worker.pack(drawing))
    for field in dataclasses.fields(drawing):
        old, new = getattr(drawing, field.name), getattr(found, field.name)
        if field.name == 'strokes':
            assert all(np.array_equal(old.__dict__[k], new.__dict__[k]) for k in old.__dict__)
        elif isinstance(old, np.ndarray):
            assert np.array_equal(old, new)
        elif field.name == 'model':
            assert old.doors
            assert model_to_json(old) == model_to_json(new)
        else:
            assert old == new


READER = '''
"""A reader that misbehaves."""


def load_libraries():
    pass


def read_harm(path, options):
    {act}
'''


@pytest.mark.parametrize(
    ('act', 'message'),
    [
        ('bytearray(4 * 2**30)', 'memory'),
        ('import os; os.abort()', 'damaged, or takes more'),
        ('import socket; socket.create_connection(("127.0.0.1", 9))', 'blocked while reading'),
        ('import os; os.system("true")', 'blocked while reading'),
        ('import subprocess; subprocess.run(["true"])', 'blocked while reading'),
        ('open(path + ".out", "w").write("x" * 99999)', 'damaged HARM'),
        ('any(iter(int, 1))', 'takes more than 2 s'),
        ('{}["missing"]', 'damaged HARM file .KeyError'),
    ],
)
def test_readers_cannot_do_harm(tmp_path, monkeypatch, act, message):
    package = tmp_path / 'extra'
    package.mkdir()
    (package / 'sitecustomize.py').write_text(
        'import fpnet_core.drawings.formats\n'
        f'fpnet_core.drawings.formats.__path__.append({str(package)!r})\n'
        'import fpnet_core.drawings.formats.worker as w\n'
    )
    (package / 'harm.py').write_text(READER.format(act=act))
    monkeypatch.setenv('PYTHONPATH', str(package))
    monkeypatch.setattr(worker, 'CPU_S', 2)
    with pytest.raises(MapFormatError, match=rf'\A[^\n]*{message}[^\n]*\Z'):
        worker.read_apart(tmp_path / 'a.harm', 'harm', ReadOptions())
