# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion between ``sensor_msgs/PointCloud2`` and arrays.

The functions take the message's plain values, so that messages of rclpy and of rosbags both work
and the core needs no message package. Decoding uses one structured view of the buffer: 300,000
points take a few milliseconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.errors import CloudFormatError

DATATYPES = {1: 'i1', 2: 'u1', 3: 'i2', 4: 'u2', 5: 'i4', 6: 'u4', 7: 'f4', 8: 'f8'}
"""NumPy type of each ``sensor_msgs/PointField`` datatype code."""

TIME_FIELDS = ('t', 'time', 'timestamp', 'timestamps', 'time_stamp', 'stamps', 'offset_time')
"""Names that lidar drivers use for the time of a point; the first one present is used."""

VIEWPOINT_FIELDS = ('vp_x', 'vp_y', 'vp_z')
"""Fields for the origin of a point's ray, named as in PCL's ``PointWithViewpoint``."""

LONGEST_SWEEP_S = 2.0
"""
Physical: longest sweep of a lidar; used to find the unit of a time field (see sweep_seconds).
"""

_FLOAT32, _FLOAT64, _UINT16 = 7, 8, 4  # given


class PointFieldLike(Protocol):
    """Attributes of a ``sensor_msgs/PointField``."""

    @property
    def name(self) -> str:
        """Field name."""

    @property
    def offset(self) -> int:
        """Bytes from the start of a point."""

    @property
    def datatype(self) -> int:
        """Key of ``DATATYPES``."""

    @property
    def count(self) -> int:
        """Number of elements; some drivers write 0 for 1."""


@dataclass(frozen=True)
class PointField:
    """One entry of a cloud's field list, with the attributes of ``sensor_msgs/PointField``."""

    name: str
    offset: int
    datatype: int
    count: int = 1


@dataclass(frozen=True, eq=False)
class CloudArrays:
    """
    A decoded cloud.

    ``points (P, 3) float32`` [m] are finite and not zero, which drivers write for no return.
    ``time_s (P,) float64`` is the time since the cloud's first point, None without a usable time
    field. ``viewpoints (P, 3) float32`` [m] are the origins of the rays, None if the cloud has
    none. ``first_s`` is the time of the first point as the driver wrote it, on any clock. A cloud
    without points gives empty arrays.
    """

    points: NDArray[np.float32]
    time_s: NDArray[np.float64] | None
    viewpoints: NDArray[np.float32] | None = None
    first_s: float = 0.0


def decode_cloud(message: Any) -> CloudArrays:
    """Decode a PointCloud2 of rclpy or rosbags; CloudFormatError as :func:`decode_points`."""
    return decode_points(
        message.fields,
        message.data,
        message.point_step,
        message.row_step,
        message.width,
        message.height,
        bool(message.is_bigendian),
    )


def decode_points(
    fields: Sequence[PointFieldLike],
    data: Any,
    point_step: int,
    row_step: int,
    width: int,
    height: int,
    is_bigendian: bool,
) -> CloudArrays:
    """
    Decode a PointCloud2 message given as its plain values.

    Parameters
    ----------
    fields
        Entries with name, offset, datatype and count.
    data
        Bytes-like; may be longer than needed, but not shorter.
    point_step, row_step
        Bytes per point and per row; padding is allowed in both, and a ``row_step`` of 0 (some
        drivers) means rows without padding.
    width, height
        Points per row, and rows.
    is_bigendian
        Byte order of ``data``.

    Raises
    ------
    CloudFormatError
        If a coordinate field is missing or unusable, or lengths contradict each other.
    """
    names = [field.name for field in fields]
    if len(set(names)) != len(names):
        raise CloudFormatError(f'cloud names a field twice: {names}; fix the driver')
    if missing := [name for name in 'xyz' if name not in names]:
        raise CloudFormatError(
            f'cloud lacks field {", ".join(missing)}: expected x, y and z, got {names}; '
            'choose a topic with points'
        )
    time_name = next((name for name in TIME_FIELDS if name in names), None)
    viewed = VIEWPOINT_FIELDS if set(VIEWPOINT_FIELDS) <= set(names) else ()
    wanted = [f for f in fields if f.name in ('x', 'y', 'z', time_name, *viewed)]
    buffer = _as_bytes(data)
    row_step = _check_lengths(len(buffer), point_step, row_step, width, height)
    dtype = _point_dtype(wanted, point_step, '>' if is_bigendian else '<')
    if width == 0 or height == 0:
        empty = np.zeros(0) if time_name else None
        return CloudArrays(np.zeros((0, 3), dtype=np.float32), empty)
    raw: NDArray[Any] = np.ndarray((height, width), dtype, buffer, strides=(row_step, point_step))
    return _returned_points(raw, time_name, viewed)


def _as_bytes(data: Any) -> memoryview:
    try:
        return memoryview(data).cast('B')
    except (TypeError, ValueError):
        raise CloudFormatError(
            f'cloud data must be contiguous bytes, got {type(data).__name__}'
        ) from None


def _check_lengths(size: int, point_step: int, row_step: int, width: int, height: int) -> int:
    """Check that all points lie within the data; return the row step to use."""
    if min(point_step, row_step, width, height) < 0:
        raise CloudFormatError(
            f'cloud has a negative size: point_step {point_step}, row_step {row_step}, '
            f'width {width}, height {height}'
        )
    row_bytes = width * point_step
    row_step = row_step or row_bytes
    if row_step < row_bytes and height > 0:
        raise CloudFormatError(
            f'cloud row_step {row_step} is shorter than width {width} x point_step {point_step} '
            f'= {row_bytes} bytes; the driver sets one of them wrong'
        )
    needed = row_step * (height - 1) + row_bytes if height and width else 0
    if size < needed:
        raise CloudFormatError(
            f'cloud data is truncated: {height} x {width} points of {point_step} bytes need '
            f'{needed} bytes, got {size}'
        )
    return row_step


def _point_dtype(fields: list[PointFieldLike], point_step: int, order: str) -> np.dtype[Any]:
    """Return the structured dtype of one point, restricted to ``fields``."""
    formats = []
    for field in fields:
        if field.datatype not in DATATYPES:
            raise CloudFormatError(
                f'cloud field {field.name}: unknown datatype {field.datatype}, expected 1 to 8'
            )
        if field.count > 1:
            raise CloudFormatError(f'cloud field {field.name}: count {field.count}, expected 1')
        dtype = np.dtype(order + DATATYPES[field.datatype])
        if not 0 <= field.offset <= point_step - dtype.itemsize:
            raise CloudFormatError(
                f'cloud field {field.name} (offset {field.offset}, {dtype.itemsize} bytes) does '
                f'not fit in point_step {point_step}; the point step is wrong'
            )
        formats.append(dtype)
    return np.dtype(
        {
            'names': [field.name for field in fields],
            'formats': formats,
            'offsets': [field.offset for field in fields],
            'itemsize': point_step,
        }
    )


def _returned_points(
    raw: NDArray[Any], time_name: str | None, viewed: tuple[str, ...]
) -> CloudArrays:
    """Copy the coordinates out of the structured view and drop points without a return."""
    points, viewpoints = _columns(raw, 'xyz'), _columns(raw, viewed) if viewed else None
    time = raw[time_name].ravel().astype(np.float64) if time_name else None
    finite = np.isfinite(points)
    if viewpoints is not None:
        finite &= np.isfinite(viewpoints)
    # Zero points often are all-zero records, whose time of zero would lengthen the sweep.
    somewhere = (points[:, 0] != 0.0) | (points[:, 1] != 0.0) | (points[:, 2] != 0.0)
    if not (finite.all() and somewhere.all()):
        kept = finite.all(axis=1) & somewhere
        points = points[kept]
        time = None if time is None else time[kept]
        viewpoints = None if viewpoints is None else viewpoints[kept]
    times = None if time is None else sweep_seconds(time)
    if times is None:
        return CloudArrays(points, None, viewpoints)
    return CloudArrays(points, times.since_first_s, viewpoints, times.first_s)


def _columns(raw: NDArray[Any], names: Iterable[str]) -> NDArray[np.float32]:
    """Return three fields of a structured view as ``(P, 3)``."""
    columns = np.empty((raw.size, 3), dtype=np.float32)
    with np.errstate(over='ignore', invalid='ignore'):
        # A float64 out of the range of float32 becomes infinite here and is dropped later.
        for column, name in enumerate(names):
            columns[:, column] = raw[name].ravel()
    return columns


class SweepSeconds(NamedTuple):
    """Times ``(P,)`` since the earliest point, and that point's time on the driver's clock."""

    since_first_s: NDArray[np.float64]
    first_s: float


def sweep_seconds(time: NDArray[np.float64]) -> SweepSeconds | None:
    """
    Turn a time field ``(P,)`` of any unit into seconds since its earliest point.

    Drivers write relative or absolute times, floats or integers, from seconds to nanoseconds. The
    unit is the coarsest for which the sweep lasts at most ``LONGEST_SWEEP_S``. Returns None if a
    time is not finite or no unit fits.
    """
    if not time.size:
        return SweepSeconds(time, 0.0)
    first, last = float(time.min()), float(time.max())
    for unit_s in (1.0, 1e-3, 1e-6, 1e-9):
        if (last - first) * unit_s <= LONGEST_SWEEP_S:
            relative = time - first
            relative *= unit_s
            return SweepSeconds(relative, first * unit_s)
    return None


def encode_points(
    points: ArrayLike,
    intensity: ArrayLike | None = None,
    ring: ArrayLike | None = None,
    time_s: ArrayLike | None = None,
    viewpoints: ArrayLike | None = None,
) -> tuple[list[PointField], int, bytes]:
    """
    Return field list, point step [bytes] and little-endian data of an unpadded cloud.

    Parameters
    ----------
    points : (P, 3)
        Written as float32 [m].
    intensity : (P,)
        Written as float32.
    ring : (P,)
        Written as uint16.
    time_s : (P,)
        Written as ``time``: as float64 if given as such, else as float32 [s].
    viewpoints : (P, 3)
        Written as ``VIEWPOINT_FIELDS`` in float32 [m].
    """
    points = np.asarray(points)
    if points.ndim != 2 or points.shape[1] != 3:
        raise CloudFormatError(f'points to encode: expected shape (P, 3), got {points.shape}')
    columns: list[tuple[str, int, NDArray[Any]]] = [
        (name, _FLOAT32, points[:, column]) for column, name in enumerate('xyz')
    ]
    if intensity is not None:
        columns.append(('intensity', _FLOAT32, np.asarray(intensity)))
    if ring is not None:
        columns.append(('ring', _UINT16, np.asarray(ring)))
    if time_s is not None:
        time = np.asarray(time_s)
        columns.append(('time', _FLOAT64 if time.dtype == np.float64 else _FLOAT32, time))
    if viewpoints is not None:
        begins = np.asarray(viewpoints)
        if begins.shape != points.shape:
            raise CloudFormatError(
                f'viewpoints to encode: expected shape {points.shape}, got {begins.shape}'
            )
        columns += [(n, _FLOAT32, begins[:, axis]) for axis, n in enumerate(VIEWPOINT_FIELDS)]
    dtype = np.dtype([(name, '<' + DATATYPES[code]) for name, code, _ in columns])
    packed = np.empty(len(points), dtype)
    for name, _, values in columns:
        if values.shape != (len(points),):
            raise CloudFormatError(
                f'{name} to encode: expected shape ({len(points)},), got {values.shape}'
            )
        packed[name] = values
    offsets = [dtype.fields[name][1] for name, _, _ in columns] if dtype.fields else []
    fields = [
        PointField(name, offset, code)
        for (name, code, _), offset in zip(columns, offsets, strict=True)
    ]
    return fields, dtype.itemsize, packed.tobytes()
