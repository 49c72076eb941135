# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import os
from pathlib import Path
import subprocess
import sys
import tempfile

import pytest

from fpnet_core import kernel_cache
from fpnet_core.kernel_cache import choose

NOWHERE = Path('/proc/fpnet')  # not even root can make files there
COMPILE = """
import sys
sys.prefix = '/proc/fpnet'
import fpnet_core.kernel_cache as kept
from numba import njit
from fpnet_core.raster.rays import njit
print(kept.SAID)
"""


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))
    monkeypatch.setattr(sys, 'prefix', str(NOWHERE))
    return tmp_path


def test_where_numba_finds_a_place_nothing_is_changed(tmp_path, temporary):
    nowhere = {'HOME': str(NOWHERE)}
    assert choose(tmp_path, nowhere) is None
    assert choose(NOWHERE, {'HOME': str(tmp_path)}) is None
    assert choose(NOWHERE, {'XDG_CACHE_HOME': str(tmp_path), **nowhere}) is None
    assert choose(NOWHERE, {'NUMBA_CACHE_DIR': '/kept', **nowhere}) is None
    assert os.listdir(temporary) == []


def test_what_set_up_has_compiled_is_found(temporary, monkeypatch):
    (temporary / 'numba').mkdir()
    monkeypatch.setattr(sys, 'prefix', str(temporary))
    assert choose(temporary, {'HOME': str(temporary)}) == temporary / 'numba'
    assert choose(temporary, {'NUMBA_CACHE_DIR': '/kept'}) is None


def test_without_a_place_a_private_folder_is_taken_and_found_again(temporary):
    folder = choose(NOWHERE, {'HOME': str(NOWHERE)})
    assert folder.parent == temporary
    assert folder.stat().st_mode & 0o777 == 0o700
    assert choose(NOWHERE, {'HOME': str(NOWHERE)}) == folder


def test_a_folder_that_others_can_write_to_is_not_trusted(temporary):
    folder = choose(NOWHERE, {'HOME': str(NOWHERE)})
    folder.chmod(0o777)
    other = choose(NOWHERE, {'HOME': str(NOWHERE)})
    assert other not in (folder, None)
    folder.rmdir()
    folder.symlink_to(other)
    assert choose(NOWHERE, {'HOME': str(NOWHERE)}) not in (folder, other)


def test_a_folder_that_cannot_be_made_is_not_writable():
    assert not kernel_cache.is_writable(NOWHERE / 'deep')


def test_an_installation_that_nobody_may_write_to_compiles_all_the_same(tmp_path):
    """On a read-only file system, where the kernel lets a test make one."""
    root = Path(kernel_cache.__file__).parents[1]
    command = (
        f'mount --bind {root}/fpnet_core {root}/fpnet_core && '
        f'mount -o remount,bind,ro {root}/fpnet_core && '
        f'exec {sys.executable} -c "$COMPILE"'
    )
    namespace = ['unshare', '--map-root-user', '--mount']
    if subprocess.run([*namespace, 'true'], check=False, capture_output=True).returncode:
        pytest.skip('no mount namespaces here')
    environment = {k: v for k, v in os.environ.items() if not k.startswith(('NUMBA_', 'XDG_'))}
    environment |= {'COMPILE': COMPILE, 'HOME': str(NOWHERE), 'TMPDIR': str(tmp_path)}
    done = subprocess.run(
        [*namespace, 'sh', '-c', command],
        check=False, capture_output=True, text=True, env={**environment, 'PYTHONPATH': str(root)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert 'set NUMBA_CACHE_DIR to keep them' in done.stdout
