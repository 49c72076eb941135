# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Where compiled kernels are kept between two starts: read-only installations have no place.

Numba keeps them beside the sources or in the user's cache folder, and raises where it can write
neither. Then they go to a folder of this user among the temporary ones; only a folder that nobody
else can write to is used, as what lies there is run.
"""

from __future__ import annotations

import os
from pathlib import Path
import stat
import sys
import tempfile

_VARIABLE = 'NUMBA_CACHE_DIR'  # given
_PRIVATE = 0o700  # given: for this user alone


def is_writable(folder: Path) -> bool:
    """Tell whether files can be made in a folder, which may have to be made first."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:  # permissions alone do not tell: a file system may refuse even its owner
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def choose(sources: Path, environment: dict[str, str]) -> Path | None:
    """Return where kernels have to be kept; None where Numba finds a place by itself."""
    if environment.get(_VARIABLE):
        return None
    home = environment.get('XDG_CACHE_HOME') or f'{environment.get("HOME", "/")}/.cache'
    if is_writable(sources / '__pycache__') or is_writable(Path(home) / 'numba'):
        return None
    return _private(Path(tempfile.gettempdir()) / f'fpnet_kernels_{os.getuid()}')


def _private(folder: Path) -> Path:
    """Return the folder if it is this user's alone, else a new one for this process."""
    try:
        folder.mkdir(mode=_PRIVATE, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return Path(tempfile.mkdtemp(prefix='fpnet_kernels_'))
    is_own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    if is_own and not found.st_mode & 0o077 and is_writable(folder):
        return folder
    return Path(tempfile.mkdtemp(prefix='fpnet_kernels_'))


def _prepare() -> str:
    """Set it for this process and its children; returns what to say."""
    folder = choose(Path(__file__).parent, dict(os.environ))
    if folder is None:
        return ''
    os.environ[_VARIABLE] = str(folder)
    if 'numba' in sys.modules:  # it has read the environment already
        from numba.core import config

        config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    return (
        f'neither the installation nor a cache folder of this user is writable: compiled kernels '
        f'are in {folder}; set {_VARIABLE} to keep them'
    )


SAID = _prepare()
"""What a user should know of it; empty: nothing."""
