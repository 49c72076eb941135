# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Safe reader for NumPy files (.npy, .npz): a damaged file can neither run code nor fill the memory.

NumPy allocates the size that a header states before it reads, and unpacks archives of any size.
This module first compares that size with the file's. It unpickles nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, Literal, Self
from zipfile import ZipFile

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from fpnet_core.io.atomic import replaced
from fpnet_core.plain_files import regular

MAX_BYTES = 2**30
"""
Numerical: larger arrays and archives (unpacked) are refused. A saved state of 400 m x 400 m is
smaller.
"""

_HEADER_READERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def read_array(path: Path) -> NDArray[Any]:
    """
    Return the array of a ``.npy`` file.

    Raises
    ------
    OSError
        If the file cannot be opened.
    ValueError
        If the file is not a ``.npy`` file of plain numbers or text, is damaged or too large.
    """
    with regular(path).open('rb') as file:
        return _read(file, path.stat().st_size, path.name)


def read_arrays(path: Path | BytesIO) -> dict[str, NDArray[Any]]:
    """
    Return all arrays of a ``.npz`` archive by name, in the order of the archive.

    Raises
    ------
    OSError
        If the file cannot be opened.
    ValueError
        If the file is not a ``.npz`` archive of plain numbers or text, is damaged, or unpacks to
        more than ``MAX_BYTES``.
    """
    with ArrayArchive(path) as archive:
        if archive.size > MAX_BYTES:
            raise ValueError(f'unpacks to {archive.size} bytes, expected at most {MAX_BYTES}')
        return {name: archive.read(name) for name in archive.names}


def write_arrays(path: Path, arrays: Mapping[str, Any], is_durable: bool = False) -> None:
    """Write arrays by name as a compressed ``.npz``, atomically (see :func:`replaced`)."""
    with replaced(path, is_durable) as partial, partial.open('wb') as file:
        np.savez_compressed(file, **arrays)


class ArrayArchive:
    """
    Context manager that reads the arrays of a ``.npz`` archive one by one.

    Raises
    ------
    OSError
        If the file cannot be opened.
    ValueError
        On opening or reading, as :func:`read_arrays`; ``MAX_BYTES`` applies to each array.
    """

    def __init__(self, path: Path | BytesIO) -> None:
        try:
            self._archive = ZipFile(regular(path) if isinstance(path, Path) else path)
        except (OSError, ValueError):
            raise
        except Exception as error:
            raise ValueError(f'not a readable .npz archive ({_detail(error)})') from None
        self._members = {
            member.filename.removesuffix('.npy'): member for member in self._archive.infolist()
        }

    def __enter__(self) -> Self:
        """Return the archive."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self._archive.close()

    @property
    def names(self) -> list[str]:
        """Names of the arrays."""
        return list(self._members)

    @property
    def size(self) -> int:
        """Unpacked size of all arrays [bytes]."""
        return sum(member.file_size for member in self._members.values())

    def read(self, name: str) -> NDArray[Any]:
        """Return one array."""
        member = self._members[name]
        try:
            with self._archive.open(member) as content:
                return _read(content, member.file_size, name)
        except ValueError:
            raise
        except Exception as error:
            # zipfile and the decompressors raise a dozen exception types on damaged members.
            raise ValueError(f'{name} cannot be unpacked: {_detail(error)}') from None


def _read(file: Any, size: int, name: str) -> NDArray[Any]:
    """Read one array of ``size`` bytes, header included."""
    try:
        version = npy.read_magic(file)
        if version not in _HEADER_READERS:
            raise ValueError(f'unsupported version {version}')
        shape, is_fortran, dtype = _HEADER_READERS[version](file)
        if dtype.hasobject:
            raise ValueError('contains pickled objects, which are not read')
        needed, left = dtype.itemsize * _count(shape), size - file.tell()
        if needed > min(left, MAX_BYTES):
            raise ValueError(f'shape {shape} needs {needed} bytes, got {left}')
        data = file.read(needed)
        if len(data) != needed:
            raise ValueError(f'shape {shape} needs {needed} bytes, got {len(data)}')
        order: Literal['F', 'C'] = 'F' if is_fortran else 'C'
        return np.ndarray(shape, dtype, data, order=order).copy()
    except Exception as error:
        # NumPy evaluates the header as a literal, and decompressors do their own checks: damaged
        # files raise a dozen types (TokenError, TypeError, zlib.error, NotImplementedError).
        raise ValueError(f'{name} is not a usable array: {_detail(error)}') from None


def _count(shape: tuple[int, ...]) -> int:
    """Return the number of elements as a Python integer, which cannot overflow."""
    count = 1
    for length in shape:
        if length < 0:
            raise ValueError(f'negative shape {shape}')
        count *= length
    return count


def _detail(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]
