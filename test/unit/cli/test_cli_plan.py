# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet plan`` and the options that say something about a drawing."""

import json

import numpy as np
from PIL import Image
from planted import plan_grid
import pytest

from fpnet.cli import common, main
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.scaling import with_scale_of
from fpnet_core.drawings.types import ReadOptions, ScaleSource
from fpnet_core.errors import ConfigError
from fpnet_core.io.maps import write_map
from fpnet_core.raster.pixels import map_points
from fpnet_core.types import FREE


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(list(map(str, arguments)))
    return ended.value.code or 0


@pytest.fixture
def drawing(tmp_path):
    """The planted building at 5 cm per pixel, of which the file says nothing."""
    pixels = np.where(plan_grid().cells == FREE, 255, 0).astype(np.uint8)[::-1]
    Image.fromarray(pixels).save(tmp_path / 'sheet.png')
    return tmp_path / 'sheet.png'


def test_it_writes_a_map_a_record_and_a_picture(drawing, tmp_path, capsys):
    out = tmp_path / 'out' / 'plan.yaml'
    assert run('plan', drawing, '--length', '0,0,200,0=10', '--out', out, '--json', '-') == 0
    printed = capsys.readouterr()
    report = json.loads(printed.out)
    assert 'sheet.png: ' in printed.err
    assert 'from a length of 10 m' in printed.err
    assert (report['rooms'], report['doors']) == (7, 6)
    assert report['scale']['source'] == 'length'
    record = json.loads((out.parent / 'plan.json').read_text())
    assert record == {key: report[key] for key in record}
    assert Image.open(out.parent / 'plan_reading.png').width > 900
    again = read_plan(out)
    assert again.grid.resolution == pytest.approx(0.05)
    assert again.scale.source is ScaleSource.LENGTH


def test_rooms_and_doors_are_exported(drawing, tmp_path, capsys):
    out, others = (
        tmp_path / 'out' / 'plan.yaml',
        [tmp_path / 'x' / 'a.geojson', tmp_path / 'a.svg'],
    )
    wanted = [each for path in others for each in ('--export', path)]
    assert run('plan', drawing, '--length', '0,0,200,0=10', '--out', out, *wanted) == 0
    assert f'wrote {others[0]}: 7 rooms and 6 doors' in capsys.readouterr().out
    again = read_plan(others[0])
    assert (len(again.model.rooms), len(again.model.doors)) == (7, 6)
    assert others[1].read_text().startswith('<svg')
    assert run('plan', drawing, '--out', out, '--export', tmp_path / 'a.ifc') == 1


def test_a_slip_in_a_stated_scale_is_doubted(drawing, tmp_path, capsys):
    out = tmp_path / 'out' / 'plan.yaml'
    assert run('plan', drawing, '--length', '0,0,200,0=100', '--out', out, '--json', '-') == 1
    printed = capsys.readouterr()
    assert 'doubtful: its median room has' in printed.err
    verdict = json.loads(printed.out)['verdict']
    assert verdict['fitness'] == 'doubtful'
    assert verdict['reasons'][0]['what'].endswith('m²: implausible at this scale')
    assert out.is_file()


def test_a_plan_that_its_user_accepts_stays_accepted(drawing, tmp_path, capsys):
    out = tmp_path / 'out' / 'plan.yaml'
    slip = ('plan', drawing, '--length', '0,0,200,0=100', '--out', out)
    assert run(*slip, '--accept', ' ') == 1
    assert not out.exists()
    assert run(*slip, '--accept', 'it is  a hall') == 0
    assert 'accepted: it is a hall' in capsys.readouterr().out
    assert json.loads((out.parent / 'plan.json').read_text())['accepted'] == 'it is a hall'
    assert read_plan(out).accepted == 'it is a hall'
    assert run('check-plan', out, '--tours', 0, '--json', '-') == 0
    printed = capsys.readouterr()
    assert 'accepted: it is a hall' in printed.err
    verdict = json.loads(printed.out)['verdict']
    assert (verdict['usable'], verdict['accepted']) == (True, 'it is a hall')
    assert run('check-plan', out, '--tours', 0, '--length', '0,0,200,0=100') == 1


def test_what_is_no_floorplan_is_one_line_and_nothing_is_written(tmp_path, capsys):
    noise = np.random.default_rng(4).integers(0, 256, (300, 400), dtype=np.uint8)
    Image.fromarray(noise).save(tmp_path / 'noise.png')
    out = tmp_path / 'out' / 'plan.yaml'
    assert run('plan', tmp_path / 'noise.png', '--out', out, '--json', tmp_path / 'a.json') == 1
    printed = capsys.readouterr()
    assert printed.out == ''
    assert printed.err.count('\n') == 1
    assert not out.parent.exists()
    verdict = json.loads((tmp_path / 'a.json').read_text())['verdict']
    assert verdict['fitness'] == 'not a floorplan'


def test_rooms_of_a_slip_in_the_scale_are_doubted_as_well(drawing, capsys):
    assert run('segment', drawing, '--length', '0,0,200,0=100', '--json', '-') == 0
    printed = capsys.readouterr()
    assert 'warning: its median room has' in printed.err
    reasons = json.loads(printed.out)['verdict']['reasons']
    assert reasons[0]['what'].endswith('m²: implausible at this scale')


def test_every_command_reads_the_map_as_it_reads_the_drawing(drawing, tmp_path):
    out = tmp_path / 'out' / 'plan.yaml'
    assert run('plan', drawing, '--out', out) == 0
    first, again = read_plan(drawing), read_plan(out)
    np.testing.assert_array_equal(first.grid.cells, again.grid.cells)
    assert first.grid.resolution == again.grid.resolution
    assert again.scale.source is ScaleSource.ESTIMATED
    assert again.estimate.low == pytest.approx(first.estimate.low)
    rooms = []
    for source in (drawing, out):
        assert run('segment', source, '--json', tmp_path / 'rooms.json') == 0
        rooms.append(json.loads((tmp_path / 'rooms.json').read_text())['rooms'])
    assert rooms[0] == rooms[1]


def test_a_map_without_a_room_says_what_to_look_at(drawing, tmp_path, capsys):
    fields = {'image': 'sheet.png', 'resolution': 0.05, 'origin': [0.0, 0.0, 0.0], 'negate': 1}
    (tmp_path / 'sheet.yaml').write_text(json.dumps(fields))
    assert run('plan', tmp_path / 'sheet.yaml', '--out', tmp_path / 'out' / 'plan.yaml') == 1
    assert (
        'no room was found at 0.05 m per cell: check the scale and, for a map_server map, negate'
        in capsys.readouterr().out
    )


@pytest.mark.parametrize('ends', ['0,0,4000,0', '0,-9,100,0', '0,0,0,4000'])
@pytest.mark.parametrize('is_map', [False, True])
def test_a_length_off_the_drawing_is_no_scale(drawing, tmp_path, capsys, ends, is_map):
    if is_map:
        drawing = tmp_path / 'sheet.yaml'
        write_map(plan_grid(), drawing)
    out = tmp_path / 'out' / 'plan.yaml'
    assert run('plan', drawing, '--length', f'{ends}=10', '--out', out) == 1
    assert 'lies outside the drawing; expected both points within 0, 0' in capsys.readouterr().err


def test_a_mirrored_drawing_is_flipped(drawing, tmp_path):
    assert run('plan', drawing, '--mirrored', '--out', tmp_path / 'out.yaml') == 0
    flipped, plain = read_plan(tmp_path / 'out.yaml'), read_plan(drawing)
    np.testing.assert_array_equal(flipped.grid.cells, plain.grid.cells[:, ::-1])
    record = json.loads((tmp_path / 'out.json').read_text())
    at = np.array(record['H_plan_image']) @ [100.0, 50.0, 1.0]
    ((x, y),) = map_points(plain.H_plan_image, np.array([[100.0, 50.0]]))
    width_m = plain.grid.shape[1] * plain.grid.resolution
    np.testing.assert_allclose(at[:2] / at[2], [width_m - x, y], atol=1e-6)


@pytest.mark.parametrize('name', ['sheet.yaml', 'plan.png', 'plan'])
def test_the_drawing_is_never_overwritten(drawing, tmp_path, capsys, name):
    before = drawing.read_bytes()
    assert run('plan', drawing, '--out', tmp_path / name) == 1
    assert capsys.readouterr().err.count('\n') == 1
    assert drawing.read_bytes() == before


def test_a_record_is_no_part_of_a_drawing_that_was_asked_for(drawing, tmp_path, capsys):
    assert run('plan', drawing, '--resolution', 0.05, '--length', '0,0,9,9=1') == 1
    assert 'give one of them' in capsys.readouterr().err


@pytest.mark.parametrize(
    'text', ['', '1,2,3,4', '1,2,3=4', '1,2,3,4=', '1,2,3,4=a', '1,2,3,4=1,2', 'nan,2,3,4=1']
)
def test_what_is_no_length_is_one_line(text):
    with pytest.raises(ConfigError, match='120,80,520,80=6'):
        common.parse_length(text)


def test_a_crop_is_four_numbers():
    assert common.parse_crop('40,60,900,700') == (40, 60, 900, 700)
    for text in ('', '1,2,3', 'a,b,c,d', '1,2,3,4,5', 'inf,0,1,1'):
        with pytest.raises(ConfigError, match='40,60,900,700'):
            common.parse_crop(text)


def test_an_unknown_scale_is_searched_unless_somebody_decides(drawing):
    reading = common.DrawingOptions().read(drawing, common.load(None))
    free, set_ = common.load(None), common.load(None, ['localizer.scale_policy=trusted'])
    assert with_scale_of(reading, free).localizer.scale_policy == 'unknown'
    assert with_scale_of(reading, set_).localizer.scale_policy == 'trusted'
    stated = common.DrawingOptions(resolution=0.05).read(drawing, free)
    assert with_scale_of(stated, free) is free


def test_the_pixels_of_a_file_that_has_none_are_named(tmp_path):
    """Six rooms of 4 m in a file whose unit is 5 cm; the picture it is painted as is larger."""
    walls = ''.join(
        f'<rect x="{40 + 80 * k}" y="{y}" width="80" height="80"/>'
        f'<path d="M{70 + 80 * k} {door}h18" stroke="white" stroke-width="6"/>'
        for k in range(6)
        for y, door in ((40, 120), (160, 160))
    )
    (tmp_path / 'a.svg').write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="560" height="280">'
        f'<g fill="none" stroke="black" stroke-width="4">{walls}'
        '<path d="M40 120V160M520 120V160"/></g></svg>'
    )
    bare = read_plan(tmp_path / 'a.svg')
    height, width = bare.drawing.pixels.shape[:2]
    stated = read_plan(tmp_path / 'a.svg', ReadOptions(resolution_m=0.01))
    assert not [note for note in bare.notes if 'Pixels are' in note]
    per_unit = bare.drawing.A_pixel_image[0, 0]
    assert per_unit > 1.5
    said = f'{width} x {height} image rendered from the SVG, {per_unit:.4g} per unit'
    assert said in stated.notes[-1]


def test_what_was_typed_is_typed_again(tmp_path):
    said = common.DrawingOptions(resolution=0.05, page=2, layer=['A', 'B c'], mirrored=True)
    typed = said.invocation(('fpnet', 'plan'), tmp_path / 'a.dxf')
    assert typed.again() == (
        f"fpnet plan {tmp_path / 'a.dxf'} --resolution 0.05 --page 2 --layer A --layer 'B c' "
        '--mirrored'
    )
    assert '--resolution 0.06' in typed.again('--resolution', '0.06')
    assert '0.05' not in typed.again('--resolution', '0.06')
