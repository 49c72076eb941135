# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""SVG: shapes, styles, clip paths and pictures; nothing is fetched, nothing explodes."""

import base64
import gzip
import io

import numpy as np
from plan_files import (
    DASHED,
    IN_ROOMS,
    LEAF,
    ON_ARC,
    ON_WALLS,
    TEXT,
    Plan,
    _svg_place,
    levels,
    write_svg,
)
import pytest

from fpnet_core.drawings.formats.svg import read_svg
from fpnet_core.drawings.opening import open_drawing
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError

PLAN = Plan(20.0)


def bare(body, head=''):
    return (
        f'{head}<svg xmlns="http://www.w3.org/2000/svg" '
        f'xmlns:xlink="http://www.w3.org/1999/xlink" width="100" height="100">{body}</svg>'
    )


def at(points):
    return _svg_place(points, PLAN)


@pytest.mark.usefixtures('own_process')
def test_walls_are_drawn_where_they_are_and_nothing_else(tmp_path):
    drawing = open_drawing(write_svg(tmp_path / 'a.svg', PLAN))
    assert (levels(drawing, at(ON_WALLS)) == 0).all()
    assert (levels(drawing, at([*IN_ROOMS, LEAF, ON_ARC, TEXT, DASHED[0]])) == 255).all()
    assert [label.text for label in drawing.labels] == ['Office']
    assert drawing.scale is None
    assert len(drawing.door_px) == 1


def test_size_on_paper_is_known_where_it_is_stated(tmp_path):
    body = '<path d="M0 0H100V50Z M20 20h60v9z"/>'
    (tmp_path / 'a.svg').write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="100mm" '
        f'viewBox="0 0 100 50">{body}</svg>'
    )
    drawing = open_drawing(tmp_path / 'a.svg')
    pixels_per_unit = np.sqrt(np.linalg.det(drawing.A_pixel_image[:, :2]))
    assert drawing.paper_m * pixels_per_unit == pytest.approx(0.002, rel=1e-3)
    (tmp_path / 'b.svg').write_text(bare(body))
    assert open_drawing(tmp_path / 'b.svg').paper_m is None


@pytest.mark.parametrize('unit', ['em', 'vw', '%', 'none of any kind'])
def test_a_size_relative_to_anything_is_none(tmp_path, unit):
    body = '<path d="M0 0H100V50Z M20 20h60v9z"/>'
    (tmp_path / 'a.svg').write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="28{unit}" height="18{unit}" '
        f'viewBox="0 0 100 50">{body}</svg>'
    )
    drawing = open_drawing(tmp_path / 'a.svg')
    assert drawing.paper_m is None
    assert (drawing.pixels < 128).any()


@pytest.mark.parametrize(('width', 'box'), [
    ('100', (0.0, 0.0, 100.0, 100.0)), ('0', None), ('1e999', None),
])  # fmt: skip
def test_a_sheet_of_no_or_of_endless_size_is_none(tmp_path, width, box):
    path = tmp_path / 'a.svg'
    path.write_text(bare('<path d="M1 1H40V30Z"/>').replace('width="100"', f'width="{width}"'))
    assert read_svg(path, ReadOptions()).box == box


def test_transforms_styles_and_uses(tmp_path):
    body = (
        '<style>.w { fill: none; stroke: #ff0000; stroke-width: 4 }</style>'
        '<defs><rect id="r" width="10" height="10"/></defs>'
        '<g transform="translate(10 20) rotate(90)"><path class="w" d="M0 0H30"/></g>'
        '<use xlink:href="#r" x="50" y="50" fill="blue"/><path d="M90 0v90"/>'
    )
    (tmp_path / 'a.svg').write_text(bare(body))
    drawing = open_drawing(tmp_path / 'a.svg')
    A = drawing.A_pixel_image
    colours = []
    for point in ((10, 35), (11.5, 40), (55, 55), (30, 30)):
        x, y = np.rint(A[:, :2] @ point + A[:, 2]).astype(int)
        colours.append(tuple(drawing.pixels[y, x].tolist()))
    assert colours == [(255, 0, 0), (255, 0, 0), (0, 0, 255), (255, 255, 255)]


SHAPES = {
    'rect': '<rect x="10" y="20" width="60" height="8"/>',
    'circle': '<circle cx="30" cy="40" r="12"/>',
    'ellipse': '<ellipse cx="30" cy="40" rx="20" ry="8"/>',
    'line': '<line x1="10" y1="20" x2="60" y2="25"/>',
    'polyline': '<polyline points="10,20 60,20 60,70"/>',
    'polygon': '<polygon points="10,20 60,20 60,70"/>',
    'path': '<path d="M10 20L60 25A30 30 0 0 1 20 70Z"/>',
}
TURNED = np.array([[0.0, -1.0], [1.0, 0.0]])
TRANSFORMS = {
    'translate(3 4)': (np.eye(2), (3.0, 4.0)),
    'translate(0 90) scale(1 -1)': (np.diag([1.0, -1.0]), (0.0, 90.0)),
    'translate(0 90) scale(2 -2)': (np.diag([2.0, -2.0]), (0.0, 90.0)),
    'translate(90 0) rotate(90)': (TURNED, (90.0, 0.0)),
    'scale(3) rotate(90)': (3.0 * TURNED, (0.0, 0.0)),
    'matrix(1.6 1.2 -1.2 1.6 5 6)': (np.array([[1.6, -1.2], [1.2, 1.6]]), (5.0, 6.0)),
}


@pytest.mark.parametrize('transform', TRANSFORMS)
@pytest.mark.parametrize('shape', SHAPES)
def test_every_shape_is_where_its_groups_put_it(tmp_path, shape, transform):
    """Exported drawings stand in groups that are flipped, scaled to millimetres, or turned."""
    style = 'fill="none" stroke="#000" stroke-width="2"'
    for name, of in (('plain', ''), ('placed', transform)):
        body = f'<g transform="{of}"><g {style}>{SHAPES[shape]}</g></g>'
        (tmp_path / f'{name}.svg').write_text(bare(body))
    plain, placed = (
        read_svg(tmp_path / f'{name}.svg', ReadOptions()) for name in ('plain', 'placed')
    )
    linear, offset = TRANSFORMS[transform]
    np.testing.assert_allclose(placed.points, plain.points @ linear.T + offset, atol=1e-6)
    np.testing.assert_allclose(placed.width, plain.width * np.sqrt(abs(np.linalg.det(linear))))


@pytest.mark.parametrize('background', ['', '<rect width="400" height="300" fill="#fff"/>'])
def test_walls_that_fill_the_sheet_are_no_background(tmp_path, background):
    """Outer walls as one filled area with the rooms cut out, on a page hardly larger than it."""
    walls = 'M10 10H390V290H10Z M20 20V280H190V20Z M200 20V280H380V20Z'
    inner = '<path d="M60 100H150V110H60Z" fill="#000"/>'
    body = f'{background}<path d="{walls}" fill="#000" fill-rule="evenodd"/>{inner}'
    path = tmp_path / 'a.svg'
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 300">{body}</svg>')
    drawing = open_drawing(path)
    dark = drawing.pixels.max(axis=2) < 128
    rows, cols = np.nonzero(dark)
    # The outer wall reaches to the margin on each side, and is as thick as drawn.
    assert np.ptp(cols) / np.ptp(rows) == pytest.approx(380 / 280, rel=0.01)
    assert dark.sum() / np.ptp(cols) ** 2 == pytest.approx(
        (380 * 280 - 170 * 260 - 180 * 260 + 90 * 10) / 380**2, rel=0.03
    )


def test_clip_paths_and_opacity(tmp_path):
    body = (
        '<clipPath id="c"><path d="M10 10L60 10L10 60z"/></clipPath>'
        '<g clip-path="url(#c)"><rect width="100" height="100"/></g>'
        '<rect x="70" y="0" width="30" height="30" fill-opacity="0.5"/>'
        '<path d="M0 95h100v3h-100z"/>'
    )
    (tmp_path / 'a.svg').write_text(bare(body))
    drawing = open_drawing(tmp_path / 'a.svg')
    found = levels(drawing, [(20, 20), (50, 50), (80, 20), (50, 80)])
    assert found == pytest.approx([0.0, 255.0, 127.5, 255.0], abs=1.0)


def test_pictures_within_the_file_are_shown(tmp_path):
    from PIL import Image

    picture = io.BytesIO()
    Image.fromarray(np.array([[0, 255], [255, 0]], np.uint8).repeat(20, 0).repeat(20, 1)).save(
        picture, 'PNG'
    )
    data = base64.b64encode(picture.getvalue()).decode()
    (tmp_path / 'a.svg').write_text(
        bare(f'<image x="20" y="40" width="40" height="40" href="data:image/png;base64,{data}"/>')
    )
    drawing = open_drawing(tmp_path / 'a.svg')
    assert levels(drawing, [(30, 50), (50, 50), (30, 70), (50, 70)]).tolist() == [0, 255, 255, 0]


def test_packed_files(tmp_path):
    text = write_svg(tmp_path / 'a.svg').read_bytes()
    (tmp_path / 'b.svgz').write_bytes(gzip.compress(text))
    packed, plain = open_drawing(tmp_path / 'b.svgz'), open_drawing(tmp_path / 'a.svg')
    assert np.array_equal(packed.pixels, plain.pixels)


def test_names_of_groups_are_layers(tmp_path):
    body = (
        '<g id="walls"><path d="M0 0h90v90h-90z" fill="none" stroke="black"/></g>'
        '<g id="furniture"><path d="M30 30h20v20h-20z"/></g>'
    )
    (tmp_path / 'a.svg').write_text(bare(body))
    drawing = open_drawing(tmp_path / 'a.svg')
    assert levels(drawing, [(45, 0), (40, 40)]).tolist() == [0.0, 255.0]


def test_what_a_plotting_library_writes_is_read(tmp_path):
    """All of it lies in a group that is named like axes of a building; a space has no path."""
    body = (
        '<defs><path id="space" transform="scale(0.1)"/><clipPath id="all"><path/>'
        '<rect width="100" height="100"/></clipPath></defs>'
        '<path d="M0 0h100v100h-100z" fill="white"/><g id="axes_1">'
        '<path d="M10 10h80v80h-80z" fill="none" stroke="black" clip-path="url(#all)"/>'
        '<path d="M50 10v80" fill="none" stroke="black"/><use xlink:href="#space"/></g>'
    )
    (tmp_path / 'a.svg').write_text(bare(body))
    drawing = open_drawing(tmp_path / 'a.svg')
    assert levels(drawing, [(50, 40), (50, 10), (30, 40)]).tolist() == [0.0, 0.0, 255.0]


@pytest.mark.usefixtures('own_process')
def test_nothing_outside_of_the_file_is_touched(tmp_path):
    (tmp_path / 'secret.png').write_bytes(b'not to be read')
    body = (
        '<image xlink:href="http://127.0.0.1:9/x.png" width="100" height="100"/>'
        '<image href="secret.png" width="10" height="10"/>'
        '<use xlink:href="file:///etc/passwd#b"/>'
        '<style>@import url(http://127.0.0.1:9/a.css);</style>'
        '<script>alert(1)</script><path d="M10 10h80v80h-80z" fill="none" stroke="black"/>'
    )
    (tmp_path / 'a.svg').write_text(bare(body))
    drawing = open_drawing(tmp_path / 'a.svg')
    assert any('nothing is fetched' in note for note in drawing.notes)


LAUGHS = ''.join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10))
USES = ''.join(
    f'<g id="g{k}">' + f'<use xlink:href="#g{k - 1}"/>' * 10 + '</g>' for k in range(1, 10)
)


@pytest.mark.usefixtures('own_process')
@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (bare('&a9;', f'<!DOCTYPE svg [<!ENTITY a0 "lol">{LAUGHS}]>'), "entity 'a1'"),
        (bare('&x;', '<!DOCTYPE svg [<!ENTITY x SYSTEM "/etc/passwd">]>'), "entity 'x'"),
        (bare(f'<g id="g0"><path d="M0 0h9"/></g>{USES}<use xlink:href="#g9"/>'), '<use>'),
        (bare('<g id="a"><use xlink:href="#a"/></g>'), '<use>'),
        (bare('<g>' * 5000 + '</g>' * 5000), 'too large'),
        (bare('<path d="M0 0h9')[:150], 'damaged SVG'),
        (bare(''), 'no lines'),
        (bare('<path d="' + 'M0 0h9' * 2_000_000 + '"/>'), 'too large'),
    ],
)
def test_bombs_and_damaged_files_are_refused_in_a_line(tmp_path, text, message):
    (tmp_path / 'a.svg').write_text(text)
    with pytest.raises(MapFormatError, match=rf'\Aa\.svg [^\n]*{message}[^\n]*\Z'):
        open_drawing(tmp_path / 'a.svg')


@pytest.mark.usefixtures('own_process')
def test_packed_bombs_are_refused(tmp_path):
    bomb = gzip.compress(bare(' ' * 80_000_000).encode(), 1)
    (tmp_path / 'a.svgz').write_bytes(bomb)
    with pytest.raises(MapFormatError, match='too large'):
        open_drawing(tmp_path / 'a.svgz')


def test_a_billion_pixels_are_none(tmp_path):
    text = bare('<path d="M0 0h1000000000v1000000000" stroke="black"/>')
    (tmp_path / 'a.svg').write_text(text.replace('"100"', '"1000000000"'))
    assert max(open_drawing(tmp_path / 'a.svg').pixels.shape) < 4000


@pytest.mark.parametrize('ground', ['', '<rect width="100" height="100" fill="#10202c"/>'])
def test_light_lines_without_a_ground_are_drawn_to_lie_on_a_dark_one(tmp_path, ground):
    lines = '<path d="M10 10H90V90H10Z M50 10V60" fill="none" stroke="white" stroke-width="3"/>'
    (tmp_path / 'a.svg').write_text(bare(ground + lines))
    pixels = open_drawing(tmp_path / 'a.svg').pixels
    dark, light = (pixels.max(axis=2) < 60).mean(), (pixels.min(axis=2) > 200).mean()
    assert min(dark, light) > 0.02
    assert (dark > 0.5) == bool(ground)
