# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sheets as PDF, SVG and DXF: the same drawing with texts, curves, layers and units."""

from xml.etree import ElementTree as ET

import ezdxf
from ezdxf import bbox
import numpy as np
from PIL import Image
import pypdfium2
import pytest

from fpnet_core.geometry import Affine2D
from fpnet_lab.sim.sheets import draw_sheet
from fpnet_lab.sim.sheets.artwork import Arcs, Letters, Role
from fpnet_lab.sim.sheets.dxf import UNITS, DxfStyle, write_dxf
from fpnet_lab.sim.sheets.files import write_vector
from fpnet_lab.sim.sheets.layers import LAYERINGS
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


def test_equal_sheets_are_equal_files(sheet, tmp_path):
    for suffix in ('pdf', 'svg', 'dxf'):
        written = []
        for name in ('one', 'two'):
            path = tmp_path / name / f'sheet.{suffix}'
            path.parent.mkdir(exist_ok=True)
            write_vector(sheet, path)
            written.append(path.read_bytes())
        assert written[0] == written[1], suffix
