# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate plan``, ``gallery`` and ``stats`` from the outside."""

import json

import cv2
import numpy as np
from PIL import Image
import pytest

from fpnet.cli import main
from fpnet_lab.sim.population.floors import TUNE_FLOORS


def run(*arguments):
    with pytest.raises(SystemExit) as stop:
        main(['simulate', *map(str, arguments)])
    return stop.value.code or 0


def test_a_plan_is_drawn_in_a_style(tmp_path, capsys):
    sizes = []
    for style in ('clean', 'sketch'):
        out = tmp_path / f'{style}.png'
        assert run('plan', '--out', out, '--seed', 3, '--family', 'suites', '--style', style) == 0
        shades = np.array(Image.open(out))
        sizes.append(np.count_nonzero(shades == 0))
        assert out.with_suffix('.yaml').exists()
    assert sizes[0] != sizes[1]
    assert 'suites:' in capsys.readouterr().out


@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        (('--min-rooms', 80, '--max-area', 100), '80 rooms do not fit'),
        (('--style', 'baroque'), 'unknown style'),
        (('--family', 'castle'), 'unknown family'),
    ],
)
def test_an_impossible_plan_is_refused_in_one_line(tmp_path, capsys, arguments, reason):
    assert run('plan', '--out', tmp_path / 'a.png', *arguments) == 1
    message = capsys.readouterr().err.strip()
    assert reason in message
    assert '\n' not in message
    assert not list(tmp_path.iterdir())


def test_a_sheet_of_one_family_shows_every_style(tmp_path):
    out = tmp_path / 'sheet.png'
    assert run('gallery', '--out', out, '--family', 'house', '--seed', 2) == 0
    assert min(Image.open(out).size) > 300


def test_a_sheet_comes_in_every_format(tmp_path, capsys):
    out, figures = tmp_path / 'sheet', tmp_path / 'figures.json'
    words = ('sheet', '--out', out, '--seed', 3, '--kind', 'phone', '--json', figures)
    assert run(*words) == 0
    assert {f'sheet.{suffix}' for suffix in ('png', 'jpg', 'pdf', 'svg', 'dxf')} <= {
        path.name for path in out.iterdir()
    }
    truth = json.loads(figures.read_text())
    assert truth['kind'] == 'phone'
    assert truth == json.loads((out / 'truth.json').read_text())
    assert f'{truth["rooms"]} rooms' in capsys.readouterr().out


def test_the_gallery_shows_sheets_of_every_kind(tmp_path):
    out = tmp_path / 'sheets.png'
    assert run('gallery', '--out', out, '--sheets') == 0
    with Image.open(out) as shown:
        tiles = np.array(shown.convert('L')).reshape(5, shown.height // 5, 4, shown.width // 4)
    # Paper and ink in each tile; the ground between them is grey.
    assert (tiles.max(axis=(1, 3)) > 225).all()
    assert (tiles.min(axis=(1, 3)) < 60).all()


def test_the_drawings_benchmark_refuses_kinds_that_are_none(tmp_path, capsys):
    with pytest.raises(SystemExit) as stop:
        main(['bench', 'drawings', '--kinds', 'office,napkin'])
    assert stop.value.code == 1
    assert "unknown kind 'napkin'; choose from clean,office,brochure" in capsys.readouterr().err


def test_stats_compare_with_labelled_drawings(tmp_path, capsys):
    """Ten drawn storeys of two rooms stand in for real ones."""
    grey, labels = np.zeros((120, 220), np.uint8), np.zeros((120, 220), np.uint8)
    grey[10:110, 10:108] = grey[10:110, 112:210] = grey[40:60, 100:120] = 255
    labels[10:110, 10:108], labels[10:110, 112:210] = 1, 2
    for kind, image in (('floorplan', grey), ('room_labels', labels)):
        (tmp_path / kind).mkdir()
        for name in TUNE_FLOORS:
            cv2.imwrite(str(tmp_path / kind / f'{name}.png'), image)
    out, plot = tmp_path / 'stats.json', tmp_path / 'stats.png'
    code = run('stats', '--data', tmp_path, '--count', 10, '--json', out, '--plot', plot)
    assert code == 0
    result = json.loads(out.read_text())
    assert len(result['percentile_error']) == 15
    assert result['percentiles']['door_width_m']['real'] == pytest.approx([1.0] * 5)
    assert result['percentiles']['room_area_m2']['real'] == pytest.approx([24.6] * 5, abs=0.2)
    assert result['regions_auc'] > 0.9
    assert plot.stat().st_size > 10_000
    assert 'AUC' in capsys.readouterr().out


def test_stats_without_the_real_drawings_say_what_is_missing(tmp_path, capsys):
    assert run('stats', '--data', tmp_path / 'nowhere') == 1
    assert 'does not exist' in capsys.readouterr().err
