# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files that end: pipes and devices are refused before anybody waits for them."""

from __future__ import annotations

import errno
from pathlib import Path

_SAID = 'it is a pipe, socket or device; name a regular file'


def regular(path: Path) -> Path:
    """
    Return ``path`` unless reading it may never end; a missing file or a folder comes back, too.

    Raises
    ------
    OSError
        As if the system said so, where the path is a pipe, a socket or a device.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise OSError(errno.EINVAL, _SAID, str(path))
    return path
