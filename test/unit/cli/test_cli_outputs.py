# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Outputs that cannot be written are named before the work begins, by every command."""

import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import numpy as np
from PIL import Image
import pytest

from fpnet.cli import main

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def plan(tmp_path):
    picture = np.full((60, 90), 178, np.uint8)
    picture[8:52, 8:82] = 0
    picture[12:48, 12:78] = 255
    Image.fromarray(picture).save(tmp_path / 'plan.png')
    return tmp_path / 'plan.png'


def refused(capsys, *words):
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    said = capsys.readouterr().err.splitlines()
    assert ended.value.code == 1
    assert len(said) == 1
    return said[0]


@pytest.mark.parametrize(
    ('command', 'option'),
    [('segment', '--plot'), ('segment', '--json'), ('check-plan', '--out'), ('plan', '--out')],
)
def test_an_output_below_a_file_is_refused_before_the_plan_is_read(
    command, option, plan, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr('fpnet_core.drawings.read.read_plan', lambda *_: pytest.fail('it began'))
    said = refused(capsys, command, plan, option, plan / 'out.png')
    assert said == f'fpnet: {option} {plan / "out.png"}: {plan} is a file; choose another folder'


@pytest.mark.parametrize('name', ['rooms.docx', 'rooms'])
def test_a_picture_has_a_known_format(name, plan, tmp_path, capsys):
    said = refused(capsys, 'segment', plan, '--plot', tmp_path / name)
    assert f'--plot {tmp_path / name}: expected a name that ends in .png' in said


def test_a_folder_is_no_file_and_a_file_no_folder(plan, tmp_path, capsys):
    assert 'is a folder; name a file' in refused(capsys, 'segment', plan, '--json', tmp_path)
    words = ('localize', tmp_path, '--floorplan', plan, '--out', plan)
    assert f'{plan} is a file' in refused(capsys, *words)


@pytest.mark.skipif(os.geteuid() == 0, reason='root may write everywhere')
def test_a_folder_without_permission_is_named(plan, tmp_path, capsys):
    locked = tmp_path / 'locked'
    locked.mkdir(mode=0o500)
    said = refused(capsys, 'segment', plan, '--plot', locked / 'new' / 'rooms.png')
    assert f'{locked} is not writable' in said


@pytest.mark.skipif(not Path('/proc').is_dir(), reason='a file system that refuses even root')
def test_a_folder_that_refuses_even_root_is_named(plan, capsys):
    said = refused(capsys, 'segment', plan, '--plot', '/proc/rooms.png')
    assert '/proc is not writable' in said


@pytest.mark.parametrize('after_s', [0.1, 0.5])
@pytest.mark.parametrize('words', [['segment'], ['check-plan', '--tours', '1']])
def test_ctrl_c_ends_at_any_time_with_130_and_without_a_traceback(words, after_s, plan):
    code = 'from fpnet.cli import main; print("begun", flush=True); main()'
    process = subprocess.Popen(
        [sys.executable, '-c', code, words[0], str(plan), *words[1:]],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
    )  # fmt: skip
    assert process.stdout.readline() == 'begun\n'
    time.sleep(after_s)  # what is imported takes longer
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    if 'panicked' in said:
        pytest.skip('pydantic 2.7: its compiled part panics where Ctrl-C meets its import')
    assert 'Traceback' not in said
    assert process.returncode == 130, said


def test_a_ctrl_c_that_a_library_throws_away_is_in_the_status(plan):
    code = """
import os, signal
from fpnet import cli

loaded = cli.import_module

def losing(name):
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        return loaded(name)

cli.import_module = losing
cli.main()
"""
    ended = subprocess.run(
        [sys.executable, '-c', code, 'segment', str(plan)], capture_output=True, check=False
    )
    assert ended.returncode == 130, ended.stderr
