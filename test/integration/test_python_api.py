# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The Python interface on files: what docs/python.md promises, with the page's own lines."""

from pathlib import Path
import re
import subprocess
import sys

import matplotlib
import pytest
from short_recording import start_of_recording

import fpnet
from fpnet_core.localizer import MapMatch
from fpnet_core.types import Segmentation
from fpnet_lab.sim.drives.recording import write_recording
from fpnet_lab.sim.lidars.sensors import LidarModel

PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'python.md'


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """A small building and a drive through it, under the names of the page."""
    folder = tmp_path_factory.mktemp('python')
    coarse = LidarModel(beams=16, columns=300)
    write_recording(start_of_recording(20.0, coarse, seed=4), folder / 'drive')
    for suffix in ('.yaml', '.png'):
        (folder / f'robot_map{suffix}').write_bytes(
            (folder / 'drive' / f'floorplan{suffix}').read_bytes()
        )
    text = (folder / 'drive' / 'floorplan.yaml').read_text()
    (folder / 'robot_map.yaml').write_text(text.replace('floorplan.png', 'robot_map.png'))
    return folder


def test_the_pages_lines_run(folder, monkeypatch, capsys):
    matplotlib.use('Agg')
    [lines] = re.findall(r'```python\n(import fpnet\n.*?)```', PAGE.read_text(), re.DOTALL)
    monkeypatch.chdir(folder)
    # The page reads a drawing of the reader's own; here it is the drive's.
    names = {}
    exec(lines.replace('my_plan.pdf', 'drive/floorplan.yaml'), names)
    run = names['run']
    assert run.status is fpnet.Status.LOCALIZED
    assert len(run.poses) == len(run.poses.xy) > 0
    assert re.fullmatch(r'<Run on floorplan.yaml: localized \(p [01].\d\d\): .*>', repr(run))
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == len(run.result.outputs)
    assert printed[-1] == run.last.said
    assert (folder / 'run.png').stat().st_size > 10_000
    matplotlib.pyplot.close('all')


def test_values_are_the_cores_own_and_show_themselves(folder):
    plan = fpnet.read_plan(str(folder / 'drive' / 'floorplan.yaml'))
    rooms = fpnet.segment(plan)
    assert isinstance(rooms, Segmentation)
    assert repr(rooms).startswith(f'<Rooms: {len(rooms.rooms)} rooms, ')
    match = fpnet.match(plan, folder / 'robot_map.yaml')
    assert isinstance(match, MapMatch)
    assert match.status.value == 'matched'
    assert 'explains' in repr(match)
    figure = match.plot()
    caption = figure.texts[0].get_text()
    assert caption.startswith(f'matched (p {match.probability:.2f}): explains')
    assert len(figure.axes[0].lines[-1].get_xdata()) > 100, 'walls on the plan'
    matplotlib.pyplot.close('all')
    for value in (plan, rooms, match):
        assert '<img src="data:image/png;base64,' in value._repr_html_()
        assert len(repr(value)) < 300


def test_a_run_is_read_as_far_as_somebody_asks(folder):
    run = fpnet.localize(folder / 'drive' / 'floorplan.yaml', folder / 'drive' / 'bag')
    assert 'not finished' in repr(run)
    first = next(iter(run))
    assert (first.status, first.A_plan_odom) == (fpnet.Status.WAITING, None)
    rest = list(run)
    assert rest[0].stamp_ns > first.stamp_ns
    assert run.result.outputs == (first, *rest)
    assert run.causes() == ()


def test_what_a_robot_has_seen_is_read_from_recordings_and_images(folder):
    seen = fpnet.read_robot_map(folder / 'drive' / 'bag')
    assert seen.is_metric
    assert repr(seen).endswith('m² of free space>')
    assert seen.plot().get_images()
    assert fpnet.segment(seen).rooms
    (folder / 'bare.png').write_bytes((folder / 'robot_map.png').read_bytes())
    bare = fpnet.read_robot_map(folder / 'bare.png')
    assert 'nominal' in repr(bare)


def test_a_plan_is_checked_without_a_drive(folder):
    check = fpnet.check_plan(folder / 'drive' / 'floorplan.yaml')
    assert check.is_readable
    assert check.tours == ()
    assert re.fullmatch(r'<Check fit: \d+ rooms, \d+ doors, \d+ pieces of advice>', repr(check))
    assert '<img src="data:image/png;base64,' in check._repr_html_()


def test_errors_are_one_line(folder):
    with pytest.raises(fpnet.FpnetError, match=r'none\.yaml'):
        fpnet.match(folder / 'drive' / 'floorplan.yaml', folder / 'none.yaml')
    with pytest.raises(fpnet.FpnetError, match='there_is_no'):
        fpnet.load_config(None, {'there_is_no': 1})
    with pytest.raises(fpnet.FpnetError, match="kiss, robot, both or None, got 'wheels'"):
        fpnet.localize(folder / 'drive' / 'floorplan.yaml', folder / 'drive', odometry='wheels')
    with pytest.raises(fpnet.FpnetError, match='topic /other is missing'):
        fpnet.localize(folder / 'drive' / 'floorplan.yaml', folder / 'drive', topics='/other')
    with pytest.raises(AttributeError, match='no attribute'):
        _ = fpnet.there_is_no


def test_the_reference_is_that_of_the_docstrings():
    tool = PAGE.parents[1] / 'tools' / 'python_page.py'
    made = subprocess.run(
        [sys.executable, tool], capture_output=True, text=True, check=True, cwd=PAGE.parents[1]
    )
    assert made.stdout.strip() in PAGE.read_text(), 'run python tools/python_page.py --write'
