# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files that appear under their name only when they are complete."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import tempfile


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """
    Yield a path in the same folder, which is made; what is written there takes the name ``path``.

    Whoever reads meanwhile, or after the writer was killed, finds what was there before. An error
    inside leaves nothing behind.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    number, name = tempfile.mkstemp(prefix=f'.{path.name}.', suffix='.partial', dir=path.parent)
    os.close(number)
    partial = Path(name)
    try:
        partial.chmod(_MODE)  # mkstemp's are for the owner's eyes only
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _default_mode() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


_MODE = _default_mode()  # asking for it is not thread-safe, so it is asked once
