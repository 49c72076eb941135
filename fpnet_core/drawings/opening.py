# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One door for all formats of drawings."""

from __future__ import annotations

from pathlib import Path

from fpnet_core.drawings.images import open_image
from fpnet_core.drawings.types import Drawing, ReadOptions


def open_drawing(path: Path, options: ReadOptions) -> Drawing:
    """
    Open a drawing of any format, by what it is called.

    Raises
    ------
    MapFormatError
        If the file cannot be read.
    """
    return open_image(path)
