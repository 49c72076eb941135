# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Atomic file writes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
from pathlib import Path
import tempfile


@contextmanager
def replaced(path: Path, is_durable: bool = False) -> Iterator[Path]:
    """
    Yield a temporary path in the same folder (created if missing) and rename it to ``path``.

    Until the rename, and if the writer is killed, readers find the previous file. An exception
    in the block removes the temporary file. With ``is_durable``, the old or the new file also
    survives a power failure.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    number, name = tempfile.mkstemp(prefix=f'.{path.name}.', suffix='.partial', dir=path.parent)
    os.close(number)
    partial = Path(name)
    try:
        partial.chmod(_MODE)  # mkstemp creates files that only their owner can read
        yield partial
        if is_durable:
            _fsync(partial)
        partial.replace(path)
        if is_durable:
            _fsync(path.parent)
    finally:
        with suppress(OSError):  # the disk may have become read-only
            partial.unlink(missing_ok=True)


def remove_partials(path: Path) -> None:
    """Remove temporary files of killed writers of ``path``; no writer may be running."""
    with suppress(OSError):
        for partial in path.parent.glob(f'.{path.name}.*.partial'):
            partial.unlink(missing_ok=True)


def _fsync(path: Path) -> None:
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _default_mode() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


_MODE = _default_mode()  # read once on import, because os.umask is not thread-safe
