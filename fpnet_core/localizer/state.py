# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Saved state of a localizer: submap counts and placements, in one file."""

from __future__ import annotations

from dataclasses import dataclass
import hashlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import StateError
from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import Placements
from fpnet_core.io.arrays import read_arrays, write_arrays
from fpnet_core.io.frozen import from_arrays, to_arrays
from fpnet_core.localizer.scale import ScaleHistory
from fpnet_core.types import GridMap

_VERSION = 3  # given


@dataclass(frozen=True, eq=False)
class SavedState:
    """
    State of a localizer between two scans.

    ``resolution_m`` is the submap's, ``T_odom_sensor (4, 4)`` and ``stamp_ns`` are those of the
    last scan, ``placements`` are ``A_plan_odom``, best first, on the floorplan with the
    fingerprint ``plan`` (empty without one), and ``submap`` is the builder's. ``scale`` is the
    estimate for that floorplan (:meth:`ScaleHistory.arrays`). ``odometry`` identifies the run of
    the odometry whose frame is used, as given by the caller; empty: unknown.

    Raises
    ------
    ValueError, KeyError
        If a value does not belong to this version of the localizer.
    """

    resolution_m: float
    stamp_ns: int
    T_odom_sensor: NDArray[np.float64]
    placements: Placements
    plan: str
    submap: dict[str, NDArray[Any]]
    scale: dict[str, NDArray[Any]]
    odometry: str = ''
    version: int = _VERSION

    def __post_init__(self) -> None:
        """Validate the values, which may come from a file."""
        if self.version != _VERSION:
            raise ValueError(f'version {self.version}, expected {_VERSION}')
        freeze_field(self, 'T_odom_sensor', np.float64, (4, 4))
        tuple(self.placements)  # raises on invalid placements
        ScaleHistory.check(self.scale)


def plan_fingerprint(grid: GridMap) -> str:
    """Return a hash that identifies a floorplan by its cells and pose."""
    digest = hashlib.sha256(np.ascontiguousarray(grid.cells).tobytes())
    digest.update(repr((grid.shape, grid.resolution)).encode())
    digest.update(grid.T_frame_grid.matrix.tobytes())
    return digest.hexdigest()


def write_state(path: Path | str, state: SavedState) -> None:
    """
    Write a state atomically: a reader sees the old file or the new one.

    Raises
    ------
    StateError
        If the folder cannot be created or written.
    """
    try:
        write_arrays(Path(path), to_arrays(state), is_durable=True)
    except OSError as error:
        raise StateError(f'cannot write the state to {path}: {error.strerror}') from None


def read_state(path: Path | str) -> SavedState:
    """
    Read a state.

    Raises
    ------
    StateError
        If the file is missing, damaged, or of another version.
    """
    try:
        return from_arrays(SavedState, read_arrays(Path(path)))
    except (OSError, ValueError) as error:
        raise StateError(
            f'{path} is not a saved state: {error}; remove it, or save the state again'
        ) from None
