# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Serialization of a running localizer's output for viewers in other processes."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from typing import TypeVar
import zlib

import numpy as np

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.io.arrays import MAX_BYTES, read_arrays
from fpnet_core.io.frozen import from_arrays, to_arrays
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput, Segmentation

Value = TypeVar('Value')

_LEVEL = 1  # numerical: rasters are mostly runs of one value, and an update waits for the result


@dataclass(frozen=True, eq=False)
class ShownPlan:
    """Rooms of a floorplan; each plan of a localizer has a different ``number``."""

    number: int
    name: str
    rooms: Segmentation


@dataclass(frozen=True, eq=False)
class ShownTick:
    """
    An update on the plan with that ``number``.

    ``T_odom_base`` is the odometry pose at the newest scan of the update's submap; None if
    unknown. ``poses`` are those published since the previous update, plan frame.
    """

    number: int
    output: LocalizerOutput
    T_odom_base: SE2 | None
    poses: PlanarTrajectory


def packed(value: object) -> bytes:
    """Return a frozen value as bytes."""
    file = BytesIO()
    np.savez(file, **to_arrays(value))  # type: ignore[arg-type]
    return zlib.compress(file.getbuffer(), _LEVEL)


def unpacked(kind: type[Value], data: bytes) -> Value:
    """
    Return the value of type ``kind`` from the bytes of :func:`packed`.

    Raises
    ------
    FpnetError
        If the bytes are damaged or of another type.
    """
    try:
        opened = zlib.decompressobj()
        file = BytesIO(opened.decompress(data, MAX_BYTES))
        if not opened.eof:
            raise ValueError(f'is cut off, or unpacks to more than {MAX_BYTES} bytes')
        return from_arrays(kind, read_arrays(file))
    except (ValueError, OSError, zlib.error) as error:
        raise FpnetError(
            f'cannot read {len(data)} bytes as {kind.__name__}: {error}; '
            'both sides need the same version of fpnet'
        ) from None
