# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files that appear under their name only when they are complete."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
from pathlib import Path
import tempfile


@contextmanager
def replaced(path: Path, is_durable: bool = False) -> Iterator[Path]:
    """
    Yield a path in the same folder, which is made; what is written there takes the name ``path``.

    Whoever reads meanwhile, or after the writer was killed, finds what was there before. An error
    inside leaves nothing behind. ``is_durable`` files are there after a power failure, too: the
    old one or the new one.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    number, name = tempfile.mkstemp(prefix=f'.{path.name}.', suffix='.partial', dir=path.parent)
    os.close(number)
    partial = Path(name)
    try:
        partial.chmod(_MODE)  # mkstemp's are for the owner's eyes only
        yield partial
        if is_durable:
            _reach_disk(partial)
        partial.replace(path)
        if is_durable:
            _reach_disk(path.parent)
    finally:
        with suppress(OSError):  # a disk that became read-only keeps it
            partial.unlink(missing_ok=True)


def remove_partials(path: Path) -> None:
    """Remove what writers of ``path`` left that were killed; nobody may be writing it."""
    with suppress(OSError):
        for partial in path.parent.glob(f'.{path.name}.*.partial'):
            partial.unlink(missing_ok=True)


def _reach_disk(path: Path) -> None:
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _default_mode() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


_MODE = _default_mode()  # asking for it is not thread-safe, so it is asked once
