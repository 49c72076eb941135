# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sheets as PDF, SVG and DXF: the same drawing with texts, curves, layers and units."""

from dataclasses import replace
import json
from xml.etree import ElementTree as ET

import ezdxf
from ezdxf import bbox
import numpy as np
from PIL import Image, ImageOps
import pypdfium2
import pytest

from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import read_map
from fpnet_core.raster.pixels import map_points
from fpnet_core.types import FREE
from fpnet_lab.sim.sheets import draw_sheet
from fpnet_lab.sim.sheets.artwork import Arcs, Letters, Role
from fpnet_lab.sim.sheets.dxf import UNITS, DxfStyle, draw_dxf_style, write_dxf
from fpnet_lab.sim.sheets.files import write_picture, write_sheet, write_vector
from fpnet_lab.sim.sheets.layers import LAYERINGS, SHARES
from fpnet_lab.sim.sheets.looks import Trait
from fpnet_lab.sim.sheets.svg import write_svg

SVG = '{http://www.w3.org/2000/svg}'


@pytest.fixture(scope='module')
def sheet():
    """A CAD plot with texts, dimensions and arcs of doors."""
    wanted = {Trait.TEXTS, Trait.DIMENSIONS, Trait.TITLE}
    unwanted = {Trait.INVERTED, Trait.TRANSPARENT, Trait.TWO_STOREYS}
    sheets = (draw_sheet(seed, 'office') for seed in range(60))
    return next(
        sheet
        for sheet in sheets
        if wanted <= sheet.look.traits
        and not unwanted & sheet.look.traits
        and (sheet.look.doors, sheet.look.walls) == ('arc', 'solid')
    )


def first_text(sheet):
    marks = sheet.artwork.marks
    return next(m for m in marks if isinstance(m, Letters) and m.role is Role.TEXT)


def coarse(image):
    """Mean grey levels of 100 by 100 blocks."""
    return np.array(image.convert('L').resize((100, 100), Image.Resampling.BOX), float)


def wall_extent(sheet):
    """Lower left and upper right of what is built [m, page]."""
    return np.array(sheet.storeys[0].shell(sheet.look.outer_m).bounds).reshape(2, 2)


def test_a_pdf_shows_the_same_and_has_real_text(sheet, tmp_path):
    path = tmp_path / 'sheet.pdf'
    known = write_vector(sheet, path)
    page = pypdfium2.PdfDocument(path)[0]
    assert first_text(sheet).text in page.get_textpage().get_text_range()
    scale = 2000.0 / max(page.get_size())
    shown = coarse(page.render(scale=scale).to_pil())
    drawn = coarse(Image.fromarray(sheet.pixels))
    assert np.abs(shown - drawn).mean() < 3.0 < np.abs(shown[:, ::-1] - drawn).mean()
    A = Affine2D.from_matrix(known['A_file_page'])
    corner = A.apply(np.array([sheet.artwork.size_m[0], 0.0]))
    np.testing.assert_allclose(corner, page.get_size(), atol=0.1)


def test_an_svg_has_layers_texts_arcs_and_widths(sheet, tmp_path):
    path = tmp_path / 'sheet.svg'
    A = write_svg(sheet.artwork, path, LAYERINGS['national'], 2.0)
    root = ET.parse(path).getroot()
    assert {group.get('class') for group in root.iter(f'{SVG}g')} >= {'A-WALL', 'A-DOOR'}
    text = next(e for e in root.iter(f'{SVG}text') if e.text == first_text(sheet).text)
    x, y = A.apply(np.array(first_text(sheet).xy))
    assert float(text.get('x')) == pytest.approx(x, abs=1e-2)
    assert float(text.get('y')) == pytest.approx(y, abs=2.0 * sheet.look.letter_m * 1e3)
    doors = [group for group in root.iter(f'{SVG}g') if group.get('class') == 'A-DOOR']
    arcs = [path for group in doors for path in group if ' A ' in path.get('d', '')]
    drawn = [m for m in sheet.artwork.marks if isinstance(m, Arcs) and m.role is Role.DOOR]
    assert len(arcs) == sum(len(mark.radius) for mark in drawn) > 0
    assert all(float(path.get('stroke-width')) > 0.0 for path in arcs)
    left, top, width, height = map(float, root.get('viewBox').split())
    np.testing.assert_allclose(A.apply(np.array(sheet.artwork.size_m)), [width, 0.0], atol=1e-2)
    assert (left, top) == (0.0, 0.0)
    assert height == pytest.approx(2.0 * float(root.get('height').removesuffix('mm')), abs=1e-2)


@pytest.mark.parametrize('unit', list(UNITS))
def test_a_dxf_has_true_lengths_in_its_units(sheet, tmp_path, unit):
    path = tmp_path / 'sheet.dxf'
    style = DxfStyle(unit, origin=(100.0, -50.0))
    A = write_dxf(sheet.artwork, path, LAYERINGS['german'], style)
    drawing = ezdxf.readfile(path)
    assert drawing.header['$INSUNITS'] == UNITS[unit][0]
    walls = bbox.extents(drawing.modelspace().query('LWPOLYLINE[layer=="Wand"]'))
    found = np.array([walls.extmin, walls.extmax])[:, :2]
    np.testing.assert_allclose(found, A.apply(wall_extent(sheet)), rtol=1e-6, atol=0.05)
    assert not drawing.audit().errors
    assert drawing.modelspace().query('ARC[layer=="Tür"]')
    assert drawing.modelspace().query('DIMENSION[layer=="Bemaßung"]')
    texts = {text.dxf.text for text in drawing.modelspace().query('TEXT')}
    assert first_text(sheet).text in texts


def test_blocks_lie_where_the_plain_drawing_has_them(sheet, tmp_path):
    extents = []
    for blocks in (False, True):
        path = tmp_path / f'{blocks}.dxf'
        style = DxfStyle('cm', origin=(7.0, 3.0), blocks=blocks, exploded=True)
        write_dxf(sheet.artwork, path, LAYERINGS['plain'], style)
        space = ezdxf.readfile(path).modelspace()
        assert bool(space.query('INSERT')) is blocks
        doors = bbox.extents(space.query('*[layer=="Doors"]'))
        extents.append(np.array([doors.extmin, doors.extmax]))
        assert not space.query('DIMENSION')
    np.testing.assert_allclose(*extents, atol=1e-3)


def test_paper_space_holds_what_is_no_building(sheet, tmp_path):
    path = tmp_path / 'sheet.dxf'
    write_dxf(sheet.artwork, path, LAYERINGS['plain'], DxfStyle(paper_space=True))
    drawing = ezdxf.readfile(path)
    assert not drawing.modelspace().query('*[layer=="Sheet"]')
    assert drawing.layout('Layout1').query('TEXT[layer=="Sheet"]')


def test_equal_sheets_are_equal_files(sheet, tmp_path):
    for suffix in ('pdf', 'svg', 'dxf'):
        written = []
        for name in ('one', 'two'):
            path = tmp_path / name / f'sheet.{suffix}'
            path.parent.mkdir(exist_ok=True)
            write_vector(sheet, path)
            written.append(path.read_bytes())
        assert written[0] == written[1], suffix


def test_every_layering_names_every_role():
    assert set(LAYERINGS) == set(SHARES)
    assert sum(SHARES.values()) == pytest.approx(1.0)
    for names in LAYERINGS.values():
        assert set(names) == set(Role)
    units = {draw_dxf_style(np.random.default_rng(seed)).unit for seed in range(60)}
    assert units == set(UNITS)


def test_a_sheet_is_written_in_every_format_with_its_truth(tmp_path):
    scan = draw_sheet(1, 'scan')
    truth = write_sheet(scan, tmp_path)
    assert json.loads((tmp_path / 'truth.json').read_text()) == truth
    names = {path.name for path in tmp_path.iterdir()}
    assert {f'sheet.{suffix}' for suffix in ('png', 'jpg', 'pdf', 'svg', 'dxf')} <= names
    with Image.open(tmp_path / 'rooms.png') as rooms:
        assert np.array(rooms).max() == truth['rooms']
    grid = read_map(tmp_path / 'plan.yaml')
    free_m2 = np.count_nonzero(grid.cells == FREE) * grid.resolution**2
    assert free_m2 == pytest.approx(scan.storeys[0].plan.floor_area_m2, rel=0.1)


def test_phones_held_on_their_side_say_so(tmp_path):
    pixels = np.full((90, 140, 3), 230, np.uint8)
    pixels[20:30, 100:110] = 10
    phone = replace(draw_sheet(0, 'phone'), pixels=pixels)
    seen = set()
    for seed in range(30):
        path = tmp_path / 'sheet.jpg'
        H = write_picture(replace(phone, seed=seed), path)
        with Image.open(path) as stored:
            seen.add(stored.getexif().get(0x0112, 1))
            upright = np.array(ImageOps.exif_transpose(stored).convert('L'), float)
            x, y = np.rint(map_points(H, np.array([104.5, 24.5]))).astype(int).tolist()
            assert np.mean(stored.getpixel((x, y))) < 60
        assert np.abs(upright - pixels[..., 0]).mean() < 6.0
    assert seen == {1, 3, 6, 8}


def test_some_pictures_have_a_palette(tmp_path):
    sheet, modes = draw_sheet(0, 'brochure'), set()
    path = tmp_path / 'sheet.png'
    small = replace(sheet, pixels=np.ascontiguousarray(sheet.pixels[::8, ::8, :3]))
    for seed in range(20):
        write_picture(replace(small, seed=seed), path)
        with Image.open(path) as image:
            modes.add(image.mode)
            shown = np.array(image.convert('RGB'), float)
        assert np.abs(shown - small.pixels).mean() < 4.0
    assert modes == {'P', 'RGB'}


def test_a_jpeg_of_a_transparent_sheet_is_on_white(tmp_path):
    sheets = (draw_sheet(seed, 'clean') for seed in range(40))
    clear = next(
        s for s in sheets if s.pixels.shape[2] == 4 and Trait.INVERTED not in s.look.traits
    )
    path = tmp_path / 'sheet.jpg'
    write_picture(clear, path)
    with Image.open(path) as image:
        assert min(image.getpixel((0, 0))) > 240
