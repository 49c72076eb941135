# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a running localizer shows to those who watch from another process, as bytes."""

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

_LEVEL = 1  # numerical: rasters are mostly runs of one value, and a tick waits for it


@dataclass(frozen=True, eq=False)
class ShownPlan:
    """A floorplan's rooms; each that a localizer shows has another ``number``."""

    number: int
    name: str
    rooms: Segmentation


@dataclass(frozen=True, eq=False)
class ShownTick:
    """
    A tick on the plan of that ``number``.

    ``T_odom_base`` is where odometry had the robot at the newest scan of the tick's submap; None
    if nobody knows. ``poses`` are those that were published since the tick before, plan frame.
    """

    number: int
    output: LocalizerOutput
    T_odom_base: SE2 | None
    poses: PlanarTrajectory


def packed(value: object) -> bytes:
    """Return a frozen value, whole, as bytes."""
    file = BytesIO()
    np.savez(file, **to_arrays(value))  # type: ignore[arg-type]
    return zlib.compress(file.getbuffer(), _LEVEL)


def unpacked(kind: type[Value], data: bytes) -> Value:
    """
    Return the value of type ``kind`` that :func:`packed` took apart.

    Raises
    ------
    FpnetError
        If it is another one's, or damaged.
    """
    try:
        opened = zlib.decompressobj()
        file = BytesIO(opened.decompress(data, MAX_BYTES))
        if not opened.eof:
            raise ValueError(f'is cut off, or unpacks to more than {MAX_BYTES} bytes')
        return from_arrays(kind, read_arrays(file))
    except (ValueError, OSError, zlib.error) as error:
        raise FpnetError(
            f'{len(data)} bytes describe no {kind.__name__}: {error}; both sides need the same '
            'version of fpnet'
        ) from None
