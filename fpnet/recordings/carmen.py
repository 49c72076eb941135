# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
CARMEN laser logs: planar scans with poses, as in the Radish repository.

``FLASER n r_1 .. r_n x y theta odom_x odom_y odom_theta ipc_time host logger_time`` is the
front laser; in corrected logs the first pose is from SLAM. ``ROBOTLASER1`` is its successor
with explicit angles.
"""

from __future__ import annotations

from collections.abc import Iterator
import gzip
from pathlib import Path
from typing import Literal, NamedTuple
import zlib

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry import SE2
from fpnet_core.io.scans import Scan
from fpnet_core.plain_files import regular
from fpnet_core.stamps import NS_PER_S

NOMINAL_PERIOD_NS = NS_PER_S
"""Time between scans if the log's clock is unusable: several logs print 10 digits too few."""

MAX_LOG_BYTES = 10**9
"""Numerical: largest unpacked log that is read: two days of a planar scanner."""

_LONGEST_LINE = 10**6  # numerical: bytes
_FIELD_OF_VIEW_RAD = np.pi  # of the SICK lasers in FLASER messages
# Physical: lasers report 32.8, 50, 51.1 or 81.9 m for no echo; no room is that long.
_NO_RETURN_M = 30.0
_MIN_RANGE_M = 0.05  # chosen
_MAX_READINGS = 10_000  # numerical
_RUNNING = 0.5  # chosen: share of increasing stamps below which the clock counts as stopped
_MIN_STEP_NS = 1_000_000  # numerical: replaces the few backward steps of the stamps in a good log


class _Laser(NamedTuple):
    """One parsed line."""

    time_s: float
    ranges_m: NDArray[np.float64]
    angles_rad: NDArray[np.float64]
    T_odom_sensor: SE2


class CarmenScans:
    """Scans of a CARMEN log, which the constructor parses."""

    kind: Literal['carmen'] = 'carmen'
    has_poses = True

    def __init__(self, path: Path) -> None:
        self._lasers = _read_log(path)
        self._stamps_ns = _increasing_stamps([laser.time_s for laser in self._lasers])

    def __len__(self) -> int:
        """Return the number of scans."""
        return len(self._lasers)

    def __iter__(self) -> Iterator[Scan]:
        """Yield the scans without the readings that had no echo."""
        for stamp_ns, laser in zip(self._stamps_ns, self._lasers, strict=True):
            echo = (laser.ranges_m > _MIN_RANGE_M) & (laser.ranges_m < _NO_RETURN_M)
            ranges, angles = laser.ranges_m[echo], laser.angles_rad[echo]
            points = np.zeros((len(ranges), 3), dtype=np.float32)
            points[:, 0] = ranges * np.cos(angles)
            points[:, 1] = ranges * np.sin(angles)
            yield Scan(stamp_ns, points, None, laser.T_odom_sensor.as_matrix4())


def _read_log(path: Path) -> list[_Laser]:
    parsers = {'FLASER': _parse_flaser, 'ROBOTLASER1': _parse_robotlaser}
    found: dict[str, list[_Laser]] = {name: [] for name in parsers}
    for number, line in enumerate(_lines(path), start=1):
        words = line.split()
        if words and words[0] in parsers:
            try:
                found[words[0]].append(parsers[words[0]](words[1:]))
            except (ValueError, IndexError, OverflowError):
                raise CloudFormatError(
                    f'{path}, line {number}: malformed {words[0]} message; expected the CARMEN '
                    'log format'
                ) from None
    # If a log has both, they are the same laser.
    lasers = found['FLASER'] or found['ROBOTLASER1']
    if not lasers:
        raise CloudFormatError(f'{path} has no laser scans (FLASER or ROBOTLASER1 messages)')
    return lasers


def _lines(path: Path) -> Iterator[str]:
    """Yield the lines of a log one by one, as a few megabytes may unpack to gigabytes."""
    left = MAX_LOG_BYTES
    try:
        regular(path)
        with gzip.open(path) if path.suffix == '.gz' else path.open('rb') as file:
            while line := file.readline(_LONGEST_LINE):
                left -= len(line)
                if left < 0:
                    raise CloudFormatError(
                        f'laser log {path} has more than {MAX_LOG_BYTES} bytes of text; split it'
                    )
                yield line.decode('ascii', errors='replace')
    except (OSError, EOFError, zlib.error) as error:
        raise CloudFormatError(f'cannot read laser log {path}: {error}') from None


def _parse_flaser(words: list[str]) -> _Laser:
    ranges, rest = _take_array(words)
    count = len(ranges)
    # 181 or 361 readings include both ends of the half circle, 180 or 360 only the first.
    step = _FIELD_OF_VIEW_RAD / (count if count % 2 == 0 else count - 1)
    return _laser(_finite(rest[6]), ranges, -0.5 * _FIELD_OF_VIEW_RAD, step, rest[0:3])


def _parse_robotlaser(words: list[str]) -> _Laser:
    start, resolution = _finite(words[1]), _finite(words[3])
    ranges, rest = _take_array(words[7:])
    _, rest = _take_array(rest, minimum=0)
    # Laser pose, robot pose, five values of the base, then the time.
    return _laser(_finite(rest[11]), ranges, start, resolution, rest[0:3])


def _take_array(words: list[str], minimum: int = 2) -> tuple[NDArray[np.float64], list[str]]:
    """Split ``n v_1 .. v_n rest`` into values and rest; NaN means no echo."""
    count = int(words[0])
    if not minimum <= count <= _MAX_READINGS or len(words) <= count:
        raise ValueError
    return np.array(words[1 : count + 1], dtype=np.float64), words[count + 1 :]


def _laser(
    time_s: float, ranges_m: NDArray[np.float64], start: float, step: float, pose: list[str]
) -> _Laser:
    angles_rad = np.empty(len(ranges_m), dtype=np.float64)
    angles_rad[:] = start + step * np.arange(len(ranges_m))
    x, y, yaw = map(_finite, pose)
    return _Laser(time_s, ranges_m, angles_rad, SE2.from_xy_yaw(x, y, yaw))


def _finite(word: str) -> float:
    value = float(word)
    if not np.isfinite(value):
        raise ValueError
    return value


def _increasing_stamps(times_s: list[float]) -> list[int]:
    """Return strictly increasing stamps [ns]; a mostly stopped clock is replaced."""
    times = np.array(times_s)
    if len(times) > 1 and np.mean(np.diff(times) > 0.0) < _RUNNING:
        return [index * NOMINAL_PERIOD_NS for index in range(len(times))]
    stamps: list[int] = []
    for time_s in times_s:
        stamp_ns = round(time_s * NS_PER_S)
        stamps.append(max(stamp_ns, stamps[-1] + _MIN_STEP_NS) if stamps else stamp_ns)
    return stamps
