# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The poster of a run: walls, path and robot on the plan, and what it refuses."""

from dataclasses import replace

import numpy as np
from PIL import Image
import pytest

from fpnet.cli import main
from fpnet.report import write_run_report
from fpnet.report.page import read_content
from fpnet.report.poster import _caption
from fpnet.viz.colours import LIDAR_COLOUR
from fpnet_core.types import Status


def poster(run, folder, name='poster.png'):
    write_run_report(folder / 'report.html', run)
    with pytest.raises(SystemExit) as ended:
        main(['view', str(folder), '--poster', str(folder / name)])
    assert not ended.value.code
    return folder / name


def blue_share(path):
    """The share of pixels in the colour of lidar walls."""
    pixels = np.asarray(Image.open(path).convert('RGB')).astype(int)
    blue = np.array([int(LIDAR_COLOUR[k : k + 2], 16) for k in (1, 3, 5)])
    return (np.abs(pixels - blue).max(axis=2) < 60).mean()


def test_it_shows_the_walls_that_were_seen_on_the_plan(made_up_run, tmp_path):
    waiting = replace(made_up_run, outputs=made_up_run.outputs[:1])
    seen = blue_share(poster(made_up_run, tmp_path))
    assert seen > 0.002
    assert blue_share(poster(waiting, tmp_path)) < 0.1 * seen


@pytest.mark.parametrize(('name', 'start'), [('p.svg', b'<?xml'), ('p.pdf', b'%PDF')])
def test_it_is_also_a_vector_drawing(made_up_run, tmp_path, name, start):
    assert poster(made_up_run, tmp_path, name).read_bytes().startswith(start)


def test_a_run_without_a_pose_says_so(made_up_run, tmp_path):
    ambiguous = replace(made_up_run.outputs[1], status=Status.AMBIGUOUS)
    unsure = replace(made_up_run, outputs=(ambiguous,), figures={})
    assert blue_share(poster(unsure, tmp_path)) > 0.002
    said = _caption(read_content(tmp_path / 'report.html')['data'])
    assert said.startswith('a <drive> on a plan. Not localized: ambiguous, p 0.90. Blue: ')
    assert said.endswith('which was not accepted.')


def test_what_cannot_be_made_is_one_line(made_up_run, tmp_path, capsys):
    write_run_report(tmp_path / 'report.html', made_up_run)
    with pytest.raises(SystemExit) as ended:
        main(['view', str(tmp_path), '--poster', 'p.gif'])
    assert ended.value.code == 1
    assert 'expected a name that ends in .png, .svg, .pdf' in capsys.readouterr().err
