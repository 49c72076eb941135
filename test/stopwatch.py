# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How long something takes on a machine that has nothing else to do."""

from pathlib import Path
import time

_PRESSURE = Path('/proc/pressure/cpu')


def _stalled_s() -> float:
    """Return for how long somebody has waited for a processor since the start of the machine."""
    if not _PRESSURE.is_file():
        return 0.0
    return float(_PRESSURE.read_text().splitlines()[0].rpartition('total=')[2]) * 1e-6


class Stopwatch:
    """Measures what a quiet machine would have taken: without its stalls."""

    def __init__(self) -> None:
        self._began_s, self._stalled_s = time.monotonic(), _stalled_s()

    @property
    def elapsed_s(self) -> float:
        return time.monotonic() - self._began_s - (_stalled_s() - self._stalled_s)
