# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import os
from pathlib import Path
import resource
import signal
import subprocess
import sys

import pytest

from fpnet_core.io.atomic import remove_partials, replaced

ENDLESS_WRITER = """
import sys, time
from pathlib import Path
from fpnet_core.io.atomic import replaced
with replaced(Path(sys.argv[1]), is_durable=True) as partial:
    with partial.open('w') as file:
        file.write('half')
        file.flush()
        print('writing', flush=True)
        time.sleep(600)
"""


def test_a_writer_that_is_killed_leaves_the_old_file_and_what_it_left_is_removed(tmp_path):
    path = tmp_path / 'state'
    path.write_text('old')
    writer = subprocess.Popen([sys.executable, '-c', ENDLESS_WRITER, path], stdout=subprocess.PIPE)
    assert writer.stdout.readline() == b'writing\n'
    writer.kill()
    writer.wait(timeout=30)
    writer.stdout.close()
    assert path.read_text() == 'old'
    assert len(os.listdir(tmp_path)) == 2
    remove_partials(path)
    assert os.listdir(tmp_path) == ['state']


@pytest.mark.parametrize('is_durable', [False, True])
def test_a_disk_that_is_full_leaves_the_old_file_and_nothing_else(tmp_path, is_durable):
    path = tmp_path / 'state'
    path.write_text('old')
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match='too large'), replaced(path, is_durable) as partial:
            partial.write_bytes(b'x' * 2000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
    assert path.read_text() == 'old'
    assert os.listdir(tmp_path) == ['state']


def test_a_durable_file_is_whole_and_readable_by_others(tmp_path):
    path = tmp_path / 'new' / 'state'
    with replaced(path, is_durable=True) as partial:
        partial.write_text('new')
        assert not path.exists()
    assert path.read_text() == 'new'
    assert Path(path).stat().st_mode & 0o400
