# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Point cloud files: PLY, PCD, LAS, NPY, XYZ; through libraries PTS, XYZN, XYZRGB, E57 and LAZ.

Common formats are read with NumPy, because Open3D's readers only print a warning and return an
empty cloud for a damaged file. Open3D reads compressed PCD and the rarer text formats.
"""

from __future__ import annotations

from collections.abc import Callable
import os
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import CloudFormatError
from fpnet_core.io.arrays import read_array
from fpnet_core.io.las import read_las
from fpnet_core.plain_files import regular

_PLY_TYPES = {
    **dict.fromkeys(('char', 'int8'), 'i1'),
    **dict.fromkeys(('uchar', 'uint8'), 'u1'),
    **dict.fromkeys(('short', 'int16'), 'i2'),
    **dict.fromkeys(('ushort', 'uint16'), 'u2'),
    **dict.fromkeys(('int', 'int32'), 'i4'),
    **dict.fromkeys(('uint', 'uint32'), 'u4'),
    **dict.fromkeys(('float', 'float32'), 'f4'),
    **dict.fromkeys(('double', 'float64'), 'f8'),
}
_PLY_ORDERS = {'ascii': '', 'binary_little_endian': '<', 'binary_big_endian': '>'}
_PCD_KINDS = {'I': 'i', 'U': 'u', 'F': 'f'}
_MAX_HEADER_LINES = 200  # numerical
_MOST_PACKED = 100  # numerical: largest ratio of compression; LZF packs up to 264 bytes in 3


def read_cloud(path: Path | str) -> NDArray[np.float64]:
    """
    Return the points ``(P, 3)`` [m] of a point file; :data:`CLOUD_SUFFIXES` lists the formats.

    Other columns are ignored; points with NaN or infinity are dropped. All scans of an E57 file
    are merged in the file's frame. E57 needs the package pye57, LAZ needs laspy.

    Raises
    ------
    CloudFormatError
        If the file is missing, of unknown format, damaged, or has no finite point.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise CloudFormatError(
            f'{path}: unknown point file {path.suffix!r}; expected {", ".join(CLOUD_SUFFIXES)}'
        )
    try:
        points = reader(regular(path))
    except OSError as error:
        raise CloudFormatError(f'cannot read cloud {path}: {error.strerror or error}') from None
    except (ValueError, TypeError, KeyError, EOFError, OverflowError, MemoryError) as error:
        raise CloudFormatError(f'{path} is damaged: {str(error).splitlines()[0]}') from None
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        raise CloudFormatError(f'{path} has no finite points')
    return points


def _read_npy(path: Path) -> NDArray[np.float64]:
    array = read_array(path)
    if array.ndim != 2 or array.shape[1] < 3:
        raise ValueError(f'expected an array (P, 3), got {array.shape}')
    return array[:, :3].astype(np.float64)


def _read_xyz(path: Path) -> NDArray[np.float64]:
    points: NDArray[np.float64] = np.loadtxt(path, dtype=np.float64, ndmin=2, usecols=(0, 1, 2))
    return points


def _read_ply(path: Path) -> NDArray[np.float64]:
    """Read the ``vertex`` element, which must come first, as all common writers put it."""
    with path.open('rb') as file:
        lines = _read_header(file, first='ply', last='end_header')
        order, count, fields = _parse_ply_header(lines)
        if order == '':
            return _columns(_read_text(file, count, len(fields)), [name for name, _ in fields])
        dtype = np.dtype([(name, order + kind) for name, kind in fields])
        return _stack(_read_records(file, dtype, count))


def _parse_ply_header(lines: list[str]) -> tuple[str, int, list[tuple[str, str]]]:
    """Return byte order (empty for text), number of vertices, and (name, type) of their fields."""
    order, count, element = None, None, ''
    fields: list[tuple[str, str]] = []
    for words in (line.split() for line in lines):
        match words:
            case ['format', name, *_] if name in _PLY_ORDERS:
                order = _PLY_ORDERS[name]
            case ['element', name, number]:
                if count is None and name != 'vertex':
                    raise ValueError(f'expected the vertex element first, got {name}')
                element, count = name, int(number) if count is None else count
            case ['property', kind, name] if element == 'vertex':
                fields.append((name, _PLY_TYPES[kind]))
            case ['property', 'list', *_] if element == 'vertex':
                raise ValueError('vertices with list properties are not supported')
    if order is None or count is None:
        raise ValueError('the PLY header has no known format or no vertices')
    return order, count, fields


def _read_pcd(path: Path) -> NDArray[np.float64]:
    with path.open('rb') as file:
        lines = _read_header(file, first=None, last='DATA')
        header = {words[0]: words[1:] for words in (line.split() for line in lines) if words}
        dtype = _pcd_dtype(header)
        count = int(header['POINTS'][0])
        encoding = header['DATA'][0] if header['DATA'] else ''
        if encoding == 'ascii':
            names = [name for name in dtype.names or () for _ in range(dtype[name].shape[0])]
            return _columns(_read_text(file, count, len(names)), names)
        if encoding == 'binary':
            return _stack(_read_records(file, dtype, count))
        if encoding == 'binary_compressed':
            _check_compressed(file, count * dtype.itemsize)
            return _read_with_open3d(path)
    raise ValueError(f'unknown PCD encoding {encoding!r}')


def _check_compressed(file: BinaryIO, needed: int) -> None:
    """Check the header's size, the two sizes before the data, and the file's size."""
    sizes = file.read(8)
    packed, unpacked = int.from_bytes(sizes[:4], 'little'), int.from_bytes(sizes[4:], 'little')
    left = os.fstat(file.fileno()).st_size - file.tell()
    if unpacked != needed or packed > left or unpacked > _MOST_PACKED * packed:
        raise ValueError(
            f'the header describes {needed} bytes of points; {left} bytes are left, which state '
            f'{unpacked} bytes packed in {packed}'
        )


def _pcd_dtype(header: dict[str, list[str]]) -> np.dtype[Any]:
    """Return the dtype of one point; every field is an array of length COUNT."""
    names, sizes, kinds = header['FIELDS'], header['SIZE'], header['TYPE']
    counts = header.get('COUNT', ['1'] * len(names))
    if not len(names) == len(sizes) == len(kinds) == len(counts):
        raise ValueError('FIELDS, SIZE, TYPE and COUNT have different lengths')
    if min(map(int, counts)) < 1:
        raise ValueError(f'COUNT is {" ".join(counts)}; expected at least 1 for each field')
    fields: list[Any] = []
    for index, name in enumerate(names):
        # PCD files may contain several padding fields, all named "_".
        unique = f'_{index}' if name == '_' else name
        kind = f'<{_PCD_KINDS[kinds[index]]}{int(sizes[index])}'
        fields.append((unique, kind, (int(counts[index]),)))
    return np.dtype(fields)


def _read_with_open3d(path: Path) -> NDArray[np.float64]:
    try:
        import open3d as o3d
    except ImportError:
        raise CloudFormatError(
            f"{path}: this format needs Open3D; run pip install 'fpnet_ros[clouds]', or "
            'convert it to a binary .ply'
        ) from None
    if not path.is_file():
        raise FileNotFoundError(2, 'No such file')
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        cloud = o3d.io.read_point_cloud(path, format=path.suffix.lower().removeprefix('.'))
    return np.asarray(cloud.points, dtype=np.float64).reshape(-1, 3)


def _read_e57(path: Path) -> NDArray[np.float64]:
    try:
        import pye57
    except ImportError:
        raise CloudFormatError(
            f'{path}: E57 needs the package pye57; run pip install pye57, or convert it to .ply'
        ) from None
    if not path.is_file():
        raise FileNotFoundError(2, 'No such file')
    try:
        file = pye57.E57(str(path))
        scans = [file.read_scan(k, ignore_missing_fields=True) for k in range(file.scan_count)]
    except Exception as error:  # the library does not export its own exception type
        raise ValueError(str(error) or type(error).__name__) from None
    points = [np.stack([scan[f'cartesian{a}'] for a in 'XYZ'], axis=1) for scan in scans]
    return np.concatenate(points).astype(np.float64)


def _read_header(file: BinaryIO, first: str | None, last: str) -> list[str]:
    lines: list[str] = []
    while not lines or lines[-1].split()[:1] != [last]:
        raw = file.readline(1000)
        if not raw or len(lines) > _MAX_HEADER_LINES:
            raise ValueError(f'the header has no {last} line')
        lines.append(raw.decode('ascii', errors='replace').strip())
        if first is not None and lines[0] != first:
            raise ValueError(f'expected the file to begin with {first!r}')
    return lines


def _read_text(file: BinaryIO, count: int, columns: int) -> NDArray[np.float64]:
    if count == 0:
        return np.zeros((0, columns))
    table: NDArray[np.float64] = np.loadtxt(file, dtype=np.float64, ndmin=2, max_rows=count)
    if table.shape != (count, columns):
        raise ValueError(f'expected {count} lines of {columns} values, got {table.shape}')
    return table


def _read_records(file: BinaryIO, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
    if count < 0 or dtype.itemsize == 0:
        raise ValueError('the header describes no points')
    needed, left = count * dtype.itemsize, os.fstat(file.fileno()).st_size - file.tell()
    if left < needed:  # checked first, so that a damaged count cannot allocate too much memory
        raise ValueError(f'truncated: {count} points need {needed} bytes, got {left}')
    return np.frombuffer(file.read(needed), dtype=dtype)


def _stack(records: NDArray[Any]) -> NDArray[np.float64]:
    _require_xyz(records.dtype.names or ())
    columns = [records[axis].reshape(len(records), -1)[:, 0] for axis in 'xyz']
    return np.stack(columns, axis=1).astype(np.float64)


def _columns(table: NDArray[np.float64], names: list[str]) -> NDArray[np.float64]:
    _require_xyz(names)
    return table[:, [names.index(axis) for axis in 'xyz']]


def _require_xyz(names: list[str] | tuple[str, ...]) -> None:
    if not set('xyz') <= set(names):
        raise ValueError(f'expected fields x, y and z, got {", ".join(names)}')


_READERS: dict[str, Callable[[Path], NDArray[np.float64]]] = {
    '.ply': _read_ply,
    '.pcd': _read_pcd,
    '.npy': _read_npy,
    '.xyz': _read_xyz,
    **dict.fromkeys(('.pts', '.xyzn', '.xyzrgb'), _read_with_open3d),
    '.e57': _read_e57,
    **dict.fromkeys(('.las', '.laz'), read_las),
}

CLOUD_SUFFIXES = tuple(_READERS)
"""Suffixes of the point files that :func:`read_cloud` reads."""
