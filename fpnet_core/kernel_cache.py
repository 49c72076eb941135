# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Folder of the compiled kernels, also for read-only installations.

An environment that ``make setup`` made has a folder of its own, where set-up has compiled them.
Elsewhere Numba stores kernels beside the sources or in the user's cache folder and raises if it
can write to neither. Then they go to a folder of this user below the temporary folder. Only a
folder that no other user can write to is used, because its contents are executed.
"""

from __future__ import annotations

import os
from pathlib import Path
import stat
import sys
import tempfile

_VARIABLE = 'NUMBA_CACHE_DIR'  # given
_PRIVATE = 0o700  # given: access for this user only


def is_writable(folder: Path) -> bool:
    """Return whether files can be created in a folder, which need not exist yet."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:  # permissions are not enough: a file system may refuse even the owner
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def choose(sources: Path, environment: dict[str, str]) -> Path | None:
    """Return the folder to use for kernels; None if Numba finds one by itself."""
    if environment.get(_VARIABLE):
        return None
    at_setup = Path(sys.prefix) / 'numba'
    if at_setup.is_dir() and is_writable(at_setup):
        return at_setup
    if is_writable(sources / '__pycache__') or is_writable(_of_user(environment)):
        return None
    return _private(Path(tempfile.gettempdir()) / f'fpnet_kernels_{os.getuid()}')


def _of_user(environment: dict[str, str]) -> Path:
    """Return Numba's folder in the user's cache folder."""
    home = environment.get('XDG_CACHE_HOME') or f'{environment.get("HOME", "/")}/.cache'
    return Path(home) / 'numba'


def is_filled() -> bool:
    """Return whether any kernel was compiled before, maybe of an older version."""
    chosen = os.environ.get(_VARIABLE)
    folders = [Path(chosen)] if chosen else [Path(__file__).parent, _of_user(dict(os.environ))]
    return any(True for folder in folders for _ in folder.glob('**/*.nbi'))


def _private(folder: Path) -> Path:
    """Return the folder if only this user can access it, else a new one for this process."""
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
    """Set the folder for this process and its children; return the message for the user."""
    folder = choose(Path(__file__).parent, dict(os.environ))
    if folder is None:
        return ''
    os.environ[_VARIABLE] = str(folder)
    if 'numba' in sys.modules:  # Numba has already read the environment
        from numba.core import config

        config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    if folder.is_relative_to(sys.prefix):
        return ''
    return (
        f'neither the installation nor a cache folder of this user is writable: compiled '
        f'kernels are in {folder}; set {_VARIABLE} to keep them'
    )


SAID = _prepare()
"""Message for the user; empty: none."""
