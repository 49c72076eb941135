# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Walls are kept whatever their layer is called; furniture and title blocks are not."""

import numpy as np
from plan_files import FURNITURE, IN_ROOMS, ON_WALLS, WALLS, Plan, corners, levels, write_dxf
import pytest

from fpnet_core.drawings.formats.worker import read_here
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError

NAMES = (
    'Ground floor plan', '1st_Floor_Linework', 'Floor', 'Area', 'rooms', 'space', 'fill', 'Zone',
    'Level 3', 'Grundriss EG', 'A-FLOR', 'Section', 'xref', 'Roof plan', 'Layer 1',
)  # fmt: skip
WALL_LINES = [(3.0, 0.0), (8.0, 6.4), (0.3, 3.0), (6.0, 1.0), (6.2, 4.5)]
SCALE = 20.0


def open_drawing(path, options=ReadOptions()):  # noqa: B008
    return read_here(path, path.suffix[1:], options)


def place(points):
    """Return building points as points of the SVG: y down, half a metre from its edge."""
    points = np.asarray(points, float)
    return SCALE * np.column_stack([points[:, 0] + 0.5, 7.0 - points[:, 1]])


def polygon(box):
    points = ' '.join(f'{x:g},{y:g}' for x, y in place(corners(box)))
    return f'<polygon points="{points}"/>'


WALLS_SVG = ''.join(map(polygon, WALLS))
TABLES = [(x, y, x + 0.8, y + 0.6) for x in (1.0, 2.5, 4.0, 7.0) for y in (1.0, 2.2, 3.4, 4.6)]
ON_TABLES = [(x, y + 0.3) for x, y, _, _ in TABLES]
FURNITURE_SVG = ''.join(map(polygon, TABLES))
TITLE = [(12.0, y, 16.0, y + 0.4) for y in np.arange(0.0, 3.0, 0.4)]
FRAME = (-0.4, -0.4, 16.4, 6.8)


def write(path, body, style='fill="none" stroke="black" stroke-width="0.4"'):
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="350" height="160" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape">'
        f'<g {style}>{body}</g></svg>',
        encoding='utf-8',
    )
    return path


@pytest.mark.parametrize('name', NAMES)
def test_walls_of_an_svg_are_kept_whatever_their_group_is_called(tmp_path, name):
    body = f'<g id="{name}">{WALLS_SVG}</g><g id="furniture">{FURNITURE_SVG}</g>'
    drawing = open_drawing(write(tmp_path / 'a.svg', body))
    assert (levels(drawing, place(WALL_LINES)) == 0).all()
    assert (levels(drawing, place([*IN_ROOMS, *ON_TABLES])) == 255).all()


@pytest.mark.parametrize('name', NAMES)
def test_walls_of_a_dxf_are_kept_whatever_their_layer_is_called(tmp_path, name):
    layers = {'wall': name, 'door': 'A-DOOR', 'furniture': 'A-FURN', 'text': 'A-ANNO-TEXT'}
    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', Plan(layers=layers)))
    assert (levels(drawing, WALL_LINES) == 0).all()
    assert levels(drawing, [(FURNITURE[0], 4.5)]) == 255


@pytest.mark.parametrize('name', ['fill', 'Ground floor plan', 'drawing', 'images'])
def test_one_layer_for_all_is_painted(tmp_path, name):
    body = f'<g id="{name}">{WALLS_SVG}{FURNITURE_SVG}</g>'
    drawing = open_drawing(write(tmp_path / 'a.svg', body, 'fill="black"'))
    assert (levels(drawing, place([*ON_WALLS, (1.4, 1.3)])) == 0).all()


def test_groups_in_a_group_of_the_storey(tmp_path):
    inner = f'<g id="g12">{WALLS_SVG}</g><g id="Mobiliar">{FURNITURE_SVG}</g>'
    drawing = open_drawing(write(tmp_path / 'a.svg', f'<g id="First Floor Area">{inner}</g>'))
    assert (levels(drawing, place(WALL_LINES)) == 0).all()
    assert (levels(drawing, place(ON_TABLES)) == 255).all()


@pytest.mark.parametrize('title', ['Title block', 'Schriftfeld', 'frame and legend'])
def test_title_blocks_and_frames_are_left_out(tmp_path, title):
    block = ''.join(map(polygon, [*TITLE, FRAME]))
    body = f'<g id="Floor">{WALLS_SVG}</g><g id="{title}">{block}</g>'
    drawing = open_drawing(write(tmp_path / 'a.svg', body))
    assert (levels(drawing, place(WALL_LINES)) == 0).all()
    scale = np.sqrt(np.linalg.det(drawing.A_pixel_image[:, :2])) * SCALE
    # Nothing right of the building is painted, so that its picture ends there.
    assert drawing.pixels.shape[1] / scale < 12.5


def test_columns_do_not_stand_for_walls_on_another_layer(tmp_path):
    columns = ''.join(polygon((x, 3.0, x + 0.3, 3.3)) for x in (2.0, 4.0, 8.0))
    body = f'<g id="S-COLS">{columns}</g><g id="1st_Floor_Linework">{WALLS_SVG}</g>'
    drawing = open_drawing(write(tmp_path / 'a.svg', body))
    assert (levels(drawing, place([*WALL_LINES, (2.0, 3.15)])) == 0).all()


@pytest.mark.parametrize('attribute', ['id', 'class', 'inkscape:label'])
@pytest.mark.parametrize('hidden', ['', 'style="display:none"', 'display="none"'])
def test_groups_of_an_svg_can_be_asked_for(tmp_path, attribute, hidden):
    """As layers of a DXF, with all that is in them, whatever its own groups are called."""
    inner = f'<g id="furniture">{FURNITURE_SVG}</g>'
    body = f'<g id="walls">{WALLS_SVG}</g><g {attribute}="Storey 2" {hidden}>{inner}</g>'
    path = write(tmp_path / 'a.svg', body)
    drawing = open_drawing(path, ReadOptions(layers=('storey 2',)))
    assert (levels(drawing, place(ON_TABLES)) == 0).all()
    with pytest.raises(MapFormatError, match='no layer roof in this drawing; it has walls'):
        open_drawing(path, ReadOptions(layers=('roof',)))


def test_blocks_on_a_layer_that_is_asked_for_belong_to_it(tmp_path):
    def change(document, space):
        block = document.blocks.new('Sofa')
        block.add_lwpolyline(corners((0.0, 0.0, 1.0, 0.5)), close=True)
        space.add_blockref('Sofa', (2.0, 3.0), dxfattribs={'layer': 'A-MISC'})

    path = write_dxf(tmp_path / 'a.dxf', change=change)
    drawing = open_drawing(path, ReadOptions(layers=('A-MISC',)))
    assert levels(drawing, [(2.5, 3.0)]) == 0


def test_optional_content_of_a_pdf_can_be_asked_for(tmp_path):
    from test_drawings_pdf import page

    content = (
        b'/OC /L1 BDC 10 10 m 400 10 l 400 300 l 10 300 l h S EMC '
        b'/OC /L2 BDC 100 100 50 50 re f EMC'
    )
    names = b'<</Properties<</L1<</Type/OCG/Name(Floor)>>/L2<</Type/OCG/Name(A-FURN)>>>>>>'
    (tmp_path / 'a.pdf').write_bytes(page(content, more=b'/Resources' + names))
    plain = open_drawing(tmp_path / 'a.pdf')
    assert levels(plain, [(200, 390), (125, 275)]).tolist() == [0.0, 255.0]
    asked = open_drawing(tmp_path / 'a.pdf', ReadOptions(layers=('a-furn',)))
    assert levels(asked, [(125, 275)]) == 0
