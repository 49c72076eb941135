# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet check-plan`` from the outside."""

import json

import numpy as np
from PIL import Image
from planted import plan_grid
import pytest

from fpnet_core.cli import main
from fpnet_core.io import write_map


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


def test_a_bare_image_is_measured_by_its_doors(tmp_path, capsys):
    """The planted building at 5 cm per pixel, of which the file says nothing."""
    write_map(plan_grid(), tmp_path / 'plan.yaml')
    (tmp_path / 'plan.yaml').unlink()
    assert run(tmp_path / 'plan.png', '--tours', 0) == 0
    said = capsys.readouterr().out
    assert 'The scale was estimated from doors, rooms and walls' in said
    metres = float(said.split(' m per pixel')[0].split()[-1])
    assert metres == pytest.approx(0.05, rel=0.15)


def test_a_picture_without_rooms_is_one_line(tmp_path, capsys):
    Image.fromarray(np.zeros((50, 50), np.uint8)).save(tmp_path / 'black.png')
    assert run(tmp_path / 'black.png', '--tours', 0) == 1
    assert capsys.readouterr().err.count('\n') == 1
