# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reader and writer for the output of one localizer update, as used by reports and pictures."""

from __future__ import annotations

from pathlib import Path

from fpnet_core.errors import FpnetError
from fpnet_core.io.arrays import read_arrays, write_arrays
from fpnet_core.io.frozen import from_arrays, to_arrays
from fpnet_core.types import LocalizerOutput


def write_output(path: Path | str, output: LocalizerOutput) -> None:
    """
    Write the output of an update as compressed arrays (.npz), atomically; create the folder.

    Raises
    ------
    FpnetError
        If it cannot be written; no partial file is left.
    """
    try:
        write_arrays(Path(path), to_arrays(output))
    except OSError as error:
        raise FpnetError(f'cannot write {path}: {error.strerror}') from None


def read_output(path: Path | str) -> LocalizerOutput:
    """
    Read the output of an update.

    Raises
    ------
    FpnetError
        If the file is missing, damaged, or not written by :func:`write_output`.
    """
    try:
        return from_arrays(LocalizerOutput, read_arrays(Path(path)))
    except (OSError, ValueError) as error:
        raise FpnetError(
            f'{path} is not a saved update: {error}; run the localizer again'
        ) from None
