# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Regular files only: opening a pipe or device could block forever."""

from __future__ import annotations

import errno
from pathlib import Path

_REFUSAL = 'it is a pipe, socket or device; name a regular file'


def regular(path: Path) -> Path:
    """
    Return ``path`` unless it is a pipe, socket or device; missing files and folders pass.

    Raises
    ------
    OSError
        EINVAL, if the path is a pipe, a socket or a device.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise OSError(errno.EINVAL, _REFUSAL, str(path))
    return path
