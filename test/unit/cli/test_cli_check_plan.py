# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet check-plan`` from the outside."""

import json
import re

import numpy as np
from PIL import Image
from planted import plan_grid
import pytest

from fpnet.cli import main
from fpnet_core.io.maps import write_map
from fpnet_core.types import FREE, OCCUPIED, GridMap


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(['check-plan', *map(str, arguments)])
    return ended.value.code or 0


def test_json_has_stdout_for_itself_and_the_folder_gets_the_page(tmp_path, capsys):
    write_map(plan_grid(), tmp_path / 'plan.yaml')
    out = tmp_path / 'out'
    options = ('--tours', 0, '--json', '-', '--out', out, '--plot', tmp_path / 'plan_check.png')
    assert run(tmp_path / 'plan.yaml', *options) == 0
    printed = capsys.readouterr()
    report = json.loads(printed.out)
    assert '7 rooms' in printed.err
    assert (report['rooms'], report['tours'], report['scale']['given']) == (7, [], True)
    assert json.loads((out / 'check.json').read_text()) == report
    assert 'Floorplan check: plan.yaml' in (out / 'report.html').read_text(encoding='utf-8')
    assert Image.open(tmp_path / 'plan_check.png').width > 900


def bare_image(folder):
    """The planted building at 5 cm per pixel, of which the file says nothing."""
    write_map(plan_grid(), folder / 'plan.yaml')
    (folder / 'plan.yaml').unlink()
    return folder / 'plan.png'


def test_a_bare_image_is_measured_by_its_rooms_and_doors(tmp_path, capsys):
    assert run(bare_image(tmp_path), '--tours', 0, '--json', '-') == 0
    printed = capsys.readouterr()
    assert 'The drawing states no scale' in printed.err
    report = json.loads(printed.out)
    assert report['verdict'] == {
        'fitness': 'fit', 'usable': True, 'accepted': None, 'reasons': []
    }  # fmt: skip
    assert not report['scale']['given']
    low, high = report['scale_interval']
    assert low < 0.05 < high
    assert report['scale']['metres_per_pixel'] == pytest.approx(0.05, rel=0.3)


def test_a_length_is_a_scale(tmp_path, capsys):
    length = '100,100,300,100=10'
    assert run(bare_image(tmp_path), '--tours', 0, '--length', length, '--json', '-') == 0
    report = json.loads(capsys.readouterr().out)
    assert report['scale']['given']
    assert report['scale_interval'] == pytest.approx([0.05, 0.05])


def test_a_drawing_that_is_misread_is_refused_and_says_what_to_do(tmp_path, capsys):
    """A sheet with a frame around much paper and no walls worth the name."""
    cells = np.full((400, 600), FREE, np.int8)
    cells[[0, -1]] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    write_map(GridMap(cells, 0.1), tmp_path / 'sheet.yaml')
    assert run(tmp_path / 'sheet.yaml', '--tours', 2, '--json', '-') == 1
    printed = capsys.readouterr()
    report = json.loads(printed.out)
    assert report['verdict']['fitness'] == 'doubtful'
    [reason] = report['verdict']['reasons']
    assert reason['what'] == 'it is one room of 2380 m²'
    assert reason['boxes_px'] == [[0, 0, 599, 399]]
    assert 'fpnet plan ' in reason['next']
    assert report['tours'] == report['advice'] == []
    assert 'doubtful: it is one room of 2380 m²' in printed.err


def test_a_scale_of_no_building_is_refused(tmp_path, capsys):
    grid = plan_grid()
    write_map(GridMap(grid.cells, 0.01), tmp_path / 'plan.yaml')
    assert run(tmp_path / 'plan.yaml', '--tours', 0, '--json', '-') == 1
    report = json.loads(capsys.readouterr().out)
    doors, whole = report['verdict']['reasons']
    assert doors['what'].startswith('its median door is 0.1')
    assert 'doors and walls suggest 0.0' in whole['what']
    for reason in (doors, whole):
        assert '--length X1,Y1,X2,Y2=METRES' in reason['next']


@pytest.mark.parametrize('slip', [10.0, 100.0])
def test_a_slip_in_the_unit_is_told_by_its_true_size(slip, tmp_path, capsys):
    write_map(GridMap(plan_grid().cells, 0.05 * slip), tmp_path / 'plan.yaml')
    assert run(tmp_path / 'plan.yaml', '--tours', 0, '--json', '-') == 1
    scale = json.loads(capsys.readouterr().out)['scale']
    assert scale['low'] <= 1.0 / slip <= scale['high']


def test_a_picture_without_rooms_is_one_line(tmp_path, capsys):
    Image.fromarray(np.zeros((50, 50), np.uint8)).save(tmp_path / 'black.png')
    assert run(tmp_path / 'black.png', '--tours', 0, '--json', tmp_path / 'check.json') == 1
    assert capsys.readouterr().err.count('\n') == 1
    report = json.loads((tmp_path / 'check.json').read_text())
    assert report['verdict']['fitness'] == 'not a floorplan'
    assert '--crop' in report['verdict']['reasons'][0]['next']


@pytest.mark.parametrize('options', [(), ('--resolution', 0.04), ('--length', '40,40,440,40=12')])
def test_it_speaks_of_the_same_square_metres_as_segment(options, tmp_path, capsys):
    said = []
    for command, more in (('check-plan', ('--tours', 0)), ('segment', ())):
        with pytest.raises(SystemExit):
            main([command, str(bare_image(tmp_path)), *map(str, (*options, *more))])
        printed = capsys.readouterr().out
        said += re.findall(r'^(\d+ rooms, \d+ m², \d+ doors)', printed, re.MULTILINE)
    assert len(said) == 2
    assert said[0] == said[1]
