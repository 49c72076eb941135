# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader for LAS files (ASPRS, versions 1.0 to 1.4); compressed LAZ files are read by laspy.

A LAS file has a header, optional records, and points of equal length that start with x, y and z
as integers. The header holds their scale and offset.
"""

from __future__ import annotations

from pathlib import Path
import struct

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import CloudFormatError

_MAGIC, _LEAST_HEADER = b'LASF', 227  # given: by the format
_VERSION_AT, _SIZES_AT, _SCALES_AT, _LONG_COUNT_AT = 24, 94, 131, 247  # given: by the header
_PACKED = 0x80  # given: bit of the point format that marks compressed points
_COUNT_IS_LONG = (1, 4)  # given: first version with a 64-bit point count
_XYZ_BYTES = 12  # given: at the beginning of each point
_MOST_PACKED = 200  # numerical: largest ratio of compression that is accepted


def read_las(path: Path) -> NDArray[np.float64]:
    """
    Return the points ``(P, 3)`` of a file, with the header's scale and offset applied.

    Raises
    ------
    CloudFormatError
        If the points are compressed and laspy is not installed.
    ValueError
        If the file is damaged.
    """
    data = path.read_bytes()
    if data[:4] != _MAGIC or len(data) < _LEAST_HEADER:
        raise ValueError('expected the file to begin with a LAS header')
    start, _, kind, length, count = struct.unpack_from('<IIBHI', data, _SIZES_AT + 2)
    if struct.unpack_from('<BB', data, _VERSION_AT) >= _COUNT_IS_LONG:
        count = struct.unpack_from('<Q', data, _LONG_COUNT_AT)[0]
    if kind & _PACKED:
        return _unpacked(path, count, len(data))
    if length < _XYZ_BYTES or start < _LEAST_HEADER:
        raise ValueError(f'the header states points of {length} bytes from byte {start}')
    if start + count * length > len(data):
        raise ValueError(f'truncated: {count} points need {start + count * length} bytes')
    scale, offset = np.frombuffer(data, '<f8', 6, _SCALES_AT).reshape(2, 3)
    dtype = np.dtype({'names': ['xyz'], 'formats': ['(3,)<i4'], 'itemsize': length})
    return np.asarray(np.frombuffer(data, dtype, count, start)['xyz'] * scale + offset)


def _unpacked(path: Path, count: int, size: int) -> NDArray[np.float64]:
    """Return the points of a LAZ file whose header states ``count``."""
    try:
        import laspy
    except ImportError:
        raise CloudFormatError(
            f"{path}: LAZ needs the package laspy; run pip install 'laspy[lazrs]', or unpack it "
            'to .las'
        ) from None
    if count * _XYZ_BYTES > _MOST_PACKED * size:
        raise ValueError(f'{size} bytes cannot hold {count} points')
    try:
        return np.asarray(laspy.read(path).xyz, dtype=np.float64)
    except BaseException as error:  # laspy's unpacker raises panics that are not Exceptions
        if isinstance(error, (KeyboardInterrupt, SystemExit)):
            raise
        raise ValueError(str(error) or type(error).__name__) from None
