# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One tick of the localizer, to and from a file: what reports and pictures are made from."""

from __future__ import annotations

from pathlib import Path

from fpnet_core.errors import FpnetError
from fpnet_core.io.arrays import read_arrays, write_arrays
from fpnet_core.io.frozen import from_arrays, to_arrays
from fpnet_core.types import LocalizerOutput


def write_output(path: Path | str, output: LocalizerOutput) -> None:
    """
    Write a tick, whole, as compressed arrays (.npz), creating the folder.

    Raises
    ------
    FpnetError
        If it cannot be written; nothing of it is left.
    """
    try:
        write_arrays(Path(path), to_arrays(output))
    except OSError as error:
        raise FpnetError(f'cannot write {path}: {error.strerror}') from None


def read_output(path: Path | str) -> LocalizerOutput:
    """
    Read a tick.

    Raises
    ------
    FpnetError
        If the file is missing, damaged, or not one of :func:`write_output`.
    """
    try:
        return from_arrays(LocalizerOutput, read_arrays(Path(path)))
    except (OSError, ValueError) as error:
        raise FpnetError(
            f'{path} is not a written tick: {error}; run the localizer again'
        ) from None
