# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The demo's session: it starts every node, leaves its files, and ends what it started."""

import json
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import time

import pytest

from fpnet.bag_writer import BagWriter
from fpnet_core.io.bags import BagReader
from fpnet_core.io.runs import read_output
from fpnet_core.io.sessions import TICK_NAME
from fpnet_core.types import Status
from fpnet_lab.evaluation.demo import rate_demo
from msg_adapters.clouds import cloud_from_msg

pytestmark = [pytest.mark.ros, pytest.mark.slow]

ROOT = Path(__file__).parents[2]
SCANS = 30


@pytest.fixture(scope='module')
def short_recording(excerpt, tmp_path_factory) -> Path:
    """The first three seconds of the excerpt, beside its floorplan and truth."""
    folder = tmp_path_factory.mktemp('short')
    for path in excerpt.folder.iterdir():
        if path.is_file():
            shutil.copy(path, folder)
    with BagReader(excerpt.folder / 'bag') as whole, BagWriter(folder / 'bag') as bag:
        messages = whole.messages(['/points'])
        for _, (topic, stamp_ns, msg) in zip(range(SCANS), messages, strict=False):
            cloud = cloud_from_msg(msg)
            time_s = cloud.time_s - cloud.time_s.max()
            bag.write_cloud(topic, stamp_ns, 'lidar', cloud.points, time_s=time_s)
    return folder


def _start(recording: Path, floorplan: Path, out: Path) -> subprocess.Popen:
    out.mkdir()
    command = [sys.executable, '-m', 'fpnet_lab.nodes.session', recording / 'bag', floorplan, out]
    return subprocess.Popen(
        list(map(str, command)),
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def _started_for(out: Path) -> list[int]:
    """Return the processes whose command line names the folder ``out``."""
    found = []
    for path in Path('/proc').glob('[0-9]*/cmdline'):
        try:
            words = path.read_bytes()
        except OSError:
            continue
        if str(out).encode() in words and int(path.parent.name) != os.getpid():
            found.append(int(path.parent.name))
    return found


def test_a_session_leaves_its_files_and_no_process(short_recording, tmp_path):
    out = tmp_path / 'session'
    session = _start(short_recording, short_recording / 'floorplan.yaml', out)
    printed, _ = session.communicate(timeout=240)
    assert session.returncode == 0, printed
    assert f'scan {SCANS}/{SCANS}' in printed
    assert _started_for(out) == []
    facts = json.loads((out / 'session.json').read_text())
    assert facts['scans'] == facts['registered_scans'] == SCANS
    assert facts['ticks'][-1]['explored_m2'] > 5.0
    last = read_output(out / TICK_NAME)
    assert last.status is not Status.NO_PLAN
    assert last.submap is not None
    run = rate_demo(short_recording, out)
    assert run.registered_scans == SCANS
    assert run.summary.poses == len(run.published)
    assert {path.stem for path in (out / 'log').iterdir()} == {
        *('floorplan_server', 'localizer', 'odometry', 'replay')
    }


def test_ctrl_c_ends_every_process(short_recording, tmp_path):
    out = tmp_path / 'session'
    session = _start(short_recording, short_recording / 'floorplan.yaml', out)
    log = out / 'log' / 'localizer.log'
    deadline = time.monotonic() + 120.0
    while not (log.exists() and 'received the floorplan' in log.read_text()):
        assert session.poll() is None, session.stdout.read()
        assert time.monotonic() < deadline
        time.sleep(0.1)
    assert len(_started_for(out)) >= 2
    os.killpg(session.pid, signal.SIGINT)
    output, _ = session.communicate(timeout=60)
    assert session.returncode == 130, output
    assert _started_for(out) == []
    assert 'Traceback' not in ''.join(path.read_text() for path in (out / 'log').iterdir())


def test_a_node_that_dies_ends_the_session_with_its_last_words(short_recording, tmp_path):
    out = tmp_path / 'session'
    session = _start(short_recording, tmp_path / 'absent.yaml', out)
    printed, _ = session.communicate(timeout=120)
    assert session.returncode == 1
    assert 'floorplan_server ended with status 1' in printed
    assert 'absent.yaml' in printed.split('last lines')[1]
    assert _started_for(out) == []
