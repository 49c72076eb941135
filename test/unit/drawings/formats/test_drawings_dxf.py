# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""DXF: layers, blocks, units that lie, what is left out, what is refused."""

import re

import numpy as np
from plan_files import (
    DASHED,
    FURNITURE,
    IN_ROOMS,
    LEAF,
    ON_ARC,
    TEXT,
    Plan,
    corners,
    levels,
    write_dxf,
)
import pytest

from fpnet_core.drawings.formats.dxf import MAX_ENTITIES
from fpnet_core.drawings.opening import open_drawing
from fpnet_core.drawings.types import ReadOptions, ScaleSource
from fpnet_core.errors import MapFormatError

WALL_LINES = [(3.0, 0.0), (8.0, 6.4), (0.3, 3.0), (6.0, 1.0), (6.2, 4.5)]


@pytest.mark.usefixtures('own_process')
def test_walls_are_drawn_where_they_are_and_nothing_else(tmp_path):
    plan = Plan(turn=0.4, origin=(4500.0, -120.0))
    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', plan))
    assert (levels(drawing, plan.place(WALL_LINES)) == 0).all()
    white = [*IN_ROOMS, LEAF, ON_ARC, TEXT, DASHED[0], FURNITURE[:2]]
    assert (levels(drawing, plan.place(white)) == 255).all()
    assert [label.text for label in drawing.labels] == ['Office']


@pytest.mark.parametrize(
    ('per_m', 'units', 'is_lie'),
    [(1.0, 6, False), (1000.0, 4, False), (1.0, 4, True), (100.0, 4, True), (1000.0, 0, True),
     (1 / 0.3048, 2, False), (1 / 0.0254, 1, False), (1 / 0.0254, 6, True)],
)  # fmt: skip
def test_true_scale_even_where_the_header_lies(tmp_path, per_m, units, is_lie):
    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', Plan(per_m), units))
    scale = drawing.scale
    pixels_per_unit = np.sqrt(abs(np.linalg.det(drawing.A_pixel_image[:, :2])))
    assert scale is not None
    assert scale.source is ScaleSource.UNITS
    assert scale.resolution_m * pixels_per_unit * per_m == pytest.approx(1.0, rel=0.002)
    assert scale.low_m < scale.resolution_m < scale.high_m
    assert any('door widths imply' in note for note in drawing.notes) == is_lie
    assert np.median(drawing.door_px) * scale.resolution_m == pytest.approx(0.9, rel=0.01)


def test_units_that_nothing_bears_out_are_not_believed(tmp_path):
    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', Plan(0.1), 4))
    assert drawing.scale is None
    assert any('its scale is unknown' in note for note in drawing.notes)


def test_frozen_and_switched_off_layers_are_left_out(tmp_path):
    def change(document, space):
        for name, hide in (('Alt', 'freeze'), ('Neu', 'off')):
            getattr(document.layers.add(f'Wand {name}'), hide)()
            space.add_lwpolyline(
                corners((2.0, 2.0, 3.0, 3.0)), close=True, dxfattribs={'layer': f'Wand {name}'}
            )

    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', change=change))
    assert levels(drawing, [(2.0, 2.5), (2.5, 2.0)]).tolist() == [255.0, 255.0]
    assert '2 layers are frozen or off and left out' in drawing.notes


def test_layers_that_are_asked_for_are_the_only_ones(tmp_path):
    path = write_dxf(tmp_path / 'a.dxf')
    drawing = open_drawing(path, ReadOptions(layers=('a-furn',)))
    assert levels(drawing, [(FURNITURE[0], 4.5)]) == 0
    with pytest.raises(MapFormatError, match=r'no layer Beton.*A-WALL'):
        open_drawing(path, ReadOptions(layers=('Beton',)))


def test_without_names_everything_is_kept_but_doors_and_texts(tmp_path):
    plan = Plan(layers={'wall': 'L1', 'door': 'L2', 'furniture': 'L3', 'text': 'L4'})
    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', plan))
    assert (levels(drawing, WALL_LINES) == 0).all()
    assert levels(drawing, [(FURNITURE[0], 4.5)]) == 0
    assert (levels(drawing, [LEAF, ON_ARC, TEXT]) == 255).all()


def test_things_forgotten_far_away_do_not_shrink_the_building(tmp_path):
    def change(document, space):
        space.add_line((90_000.0, 5.0), (90_000.5, 5.0), dxfattribs={'layer': 'A-WALL'})

    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', change=change))
    assert drawing.scale.resolution_m == pytest.approx(0.025)
    assert any('far from the building' in note for note in drawing.notes)


def test_widths_hatches_and_arcs_of_walls(tmp_path):
    def change(document, space):
        wall = {'layer': 'A-WALL'}
        space.add_lwpolyline([(1.0, 1.0), (1.0, 5.0)], dxfattribs={'const_width': 0.4, **wall})
        hatch = space.add_hatch(dxfattribs=wall)
        hatch.paths.add_polyline_path(corners((7.0, 2.0, 7.4, 5.0)), is_closed=True)
        space.add_lwpolyline([(8.0, 2.0, 0.3), (9.0, 2.0)], format='xyb', dxfattribs=wall)
        space.add_arc((4.0, 2.5), 2.2, 90.0, 180.0, dxfattribs=wall)

    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', change=change))
    # A bulge of 0.3 rises to 0.3 times half the chord; no door is 2.2 m wide.
    curved = (4.0 - 2.2 * 0.5**0.5, 2.5 + 2.2 * 0.5**0.5)
    on = [(0.85, 3.0), (1.15, 3.0), (7.2, 3.5), (8.5, 1.85), curved]
    assert levels(drawing, on).tolist() == [0.0] * 5
    assert levels(drawing, [(1.4, 3.0), (7.6, 3.5)]).tolist() == [255.0, 255.0]


def test_references_to_other_files_are_never_followed(tmp_path):
    def change(document, space):
        document.add_xref_def('/etc/passwd', 'OTHER')
        space.add_blockref('OTHER', (0, 0))
        picture = document.add_image_def('http://127.0.0.1:9/plan.png', (10, 10))
        space.add_image(picture, (0, 0), (1, 1))

    drawing = open_drawing(write_dxf(tmp_path / 'a.dxf', change=change))
    assert sum('never followed' in note for note in drawing.notes) == 2


@pytest.mark.usefixtures('own_process')
def test_blocks_that_multiply_are_refused_at_once(tmp_path):
    def change(document, space):
        document.blocks.new('B0').add_line((0, 0), (1, 1))
        for k in range(1, 8):
            block = document.blocks.new(f'B{k}')
            for n in range(20):
                block.add_blockref(f'B{k - 1}', (n, 0))
        space.add_blockref('B7', (0, 0))

    with pytest.raises(MapFormatError, match=f'at most {MAX_ENTITIES:,} entities'):
        open_drawing(write_dxf(tmp_path / 'a.dxf', change=change))


def test_a_screw_is_doubted(tmp_path):
    import ezdxf

    document = ezdxf.new()
    document.header['$INSUNITS'] = 4
    space = document.modelspace()
    space.add_circle((0, 0), 4)
    for k in range(20):
        space.add_line((20 + k, -3), (20.5 + k, 3))
    document.saveas(tmp_path / 'screw.dxf')
    drawing = open_drawing(tmp_path / 'screw.dxf')
    assert any('in its stated unit: implausible' in doubt for doubt in drawing.doubts)
    assert drawing.scale is None


def test_a_building_is_not_doubted(tmp_path):
    assert open_drawing(write_dxf(tmp_path / 'a.dxf', Plan(turn=0.4))).doubts == ()


@pytest.mark.parametrize('share', [0.02, 0.3])
def test_truncated_files_are_refused_in_a_line(tmp_path, share):
    data = write_dxf(tmp_path / 'a.dxf').read_bytes()
    (tmp_path / 'b.dxf').write_bytes(data[: int(share * len(data))])
    with pytest.raises(MapFormatError, match=r'\Ab\.dxf [^\n]*\Z'):
        open_drawing(tmp_path / 'b.dxf')


def test_a_file_that_was_cut_off_among_its_walls_is_not_read_in_part(tmp_path):
    data = write_dxf(tmp_path / 'a.dxf').read_bytes()
    assert open_drawing(tmp_path / 'a.dxf').doubts == ()
    lines = [at.start() for at in re.finditer(rb'  0\r?\n(LINE|LWPOLYLINE)\r?\n', data)]
    (tmp_path / 'b.dxf').write_bytes(data[: lines[len(lines) // 2]])
    with pytest.raises(MapFormatError, match=r'\Ab\.dxf is truncated: [^\n]*EOF[^\n]*\Z'):
        open_drawing(tmp_path / 'b.dxf')
