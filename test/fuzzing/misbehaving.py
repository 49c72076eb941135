# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Readers that do what no reader may, to see that the harness notices."""

from collections.abc import Callable
import itertools
import os
from pathlib import Path
import pickle

import numpy as np

from fpnet_core.errors import FpnetError
from fuzzing.mutations import MARKER, Payload
from fuzzing.readers import Reader

VALID = b'valid'


def _write(folder: Path) -> Path:
    path = folder / 'input'
    path.write_bytes(VALID)
    return path


def _on_damaged(act: Callable[[], object]) -> Callable[[Path], object]:
    """Return a reader that behaves on the valid input only."""

    def read(path: Path) -> object:
        return None if path.is_file() and path.read_bytes() == VALID else act()

    return read


def _refuse(message: str) -> None:
    raise FpnetError(message)


def _hide_memory_error() -> None:
    try:
        np.zeros(2**33)
    except MemoryError:
        raise FpnetError('the file is damaged') from None


MISBEHAVING: dict[str, Reader] = {
    outcome: Reader('misbehaving', f'{outcome} {number}', _write, _on_damaged(act))
    for number, (outcome, act) in enumerate(
        {
            'accepted': lambda: None,
            'refused': lambda: _refuse('expected one thing, got another'),
            'unclear': lambda: _refuse('\x1b[2J'),
            'exception': lambda: {}['missing'],
            'memory': _hide_memory_error,
            'memory that is used': lambda: np.ones(5 * 2**26).sum(),
            'executed': lambda: os.system('true'),
            'executed from a pickle': lambda: pickle.loads(pickle.dumps(Payload())),
            'executed to a file': lambda: Path(MARKER).touch(),
            'timeout': lambda: sum(0 for _ in itertools.count()),
            'crash': os.abort,
        }.items()
    )
}
