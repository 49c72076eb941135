# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of a command's output paths before it starts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import os
from pathlib import Path
from typing import Any

from fpnet_core.errors import FpnetError
from fpnet_core.kernel_cache import is_writable

WRITTEN = ('--out', '--plot', '--strips', '--json', '--tum', '--rooms', '--film', '--poster')
"""Options of all commands that name an output."""

_PICTURES = ('.png', '.jpg', '.jpeg', '.pdf', '.svg', '.webp', '.tif', '.tiff', '.eps')
_KNOWN = {'--plot': _PICTURES, '--film': ('.gif',), '--poster': ('.png', '.svg', '.pdf')}


def look_first(command: Any) -> None:
    """
    Make a click command and its subcommands check output paths when they are parsed.

    Outputs are identified by option name, folders by the metavar ``DIR``, so that commands of
    other packages are covered. An output that cannot be written raises FpnetError.
    """
    for each in _commands(command):
        for option in each.params:
            name = next((name for name in option.opts if name in WRITTEN), None)
            if name is not None:
                option.callback = _then(_look(name, option.metavar == 'DIR'), option.callback)


def _commands(command: Any) -> Iterator[Any]:
    yield command
    for child in getattr(command, 'commands', {}).values():
        yield from _commands(child)


def _then(look: Callable[[Path], None], before: Any) -> Callable[[Any, Any, Any], Any]:
    def callback(context: Any, option: Any, value: Any) -> Any:
        if value is not None and not context.resilient_parsing:
            look(Path(value))
        return value if before is None else before(context, option, value)

    return callback


def _look(name: str, is_folder: bool) -> Callable[[Path], None]:
    def look(path: Path) -> None:
        if name == '--json' and str(path) == '-':
            return
        if is_folder:
            check_folder(path, name)
            return
        check_file(path, name)
        known = _KNOWN.get(name)
        if known and path.suffix.lower() not in known:
            raise FpnetError(f'{name} {path}: expected a name that ends in {", ".join(known)}')

    return look


def check_folder(path: Path, name: str) -> None:
    """
    Check that files can be written into a folder, which need not exist yet.

    Raises
    ------
    FpnetError
        If it is a file, lies below one, or is not writable.
    """
    _check_within(path, f'{name} {path}')


def check_file(path: Path, name: str) -> None:
    """
    Check that a file can be written; its folder need not exist yet.

    Raises
    ------
    FpnetError
        If it is a folder, lies below a file, or is not writable.
    """
    if path.is_dir():
        raise FpnetError(f'{name} {path} is a folder; name a file in it')
    _check_within(path.parent, f'{name} {path}')
    if path.exists() and not os.access(path, os.W_OK):
        raise FpnetError(f'{name} {path} is not writable; choose another file')


def _check_within(folder: Path, what: str) -> None:
    """Check a folder or, if it does not exist, its nearest existing parent."""
    nearest = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not nearest.is_dir():
        raise FpnetError(f'{what}: {nearest} is a file; choose another folder')
    if not is_writable(nearest):
        raise FpnetError(f'{what}: {nearest} is not writable; choose another folder')
