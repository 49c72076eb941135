# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How long something takes on a machine that has nothing else to do."""

from pathlib import Path
import time

_PRESSURE = Path('/proc/pressure/cpu')
_MOST = 10.0  # chosen: times as long as on a quiet machine; a limit has to be reached at last


def _stalled_s() -> float:
    """Return for how long somebody has waited for a processor since the start of the machine."""
    if not _PRESSURE.is_file():
        return 0.0
    return float(_PRESSURE.read_text().splitlines()[0].rpartition('total=')[2]) * 1e-6


class Stopwatch:
    """Measures what a quiet machine would have taken: without stalls, as far as they explain."""

    def __init__(self) -> None:
        self._began_s, self._stalled_s = time.monotonic(), _stalled_s()

    @property
    def elapsed_s(self) -> float:
        wall_s = time.monotonic() - self._began_s
        return max(wall_s - (_stalled_s() - self._stalled_s), wall_s / _MOST)
