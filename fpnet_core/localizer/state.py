# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What outlives a localizer's process: the submap's counts and the placements, in one file."""

from __future__ import annotations

from dataclasses import dataclass
import hashlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import StateError
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.io.arrays import read_arrays, write_arrays
from fpnet_core.localizer.scale import ScaleHistory
from fpnet_core.types import GridMap

_VERSION = 2  # given
_SUBMAP, _SCALE = 'submap_', 'scale_'  # prefixes of the builder's and the scale's arrays
_KEYS = {'version', 'resolution_m', 'stamp_ns', 'T_odom_sensor', 'placements', 'plan', 'odometry'}


@dataclass(frozen=True, eq=False)
class LocalizerState:
    """
    A localizer between two scans.

    ``resolution_m`` is the submap's, ``T_odom_sensor (4, 4)`` and ``stamp_ns`` are those of the
    last scan, ``placements`` are ``A_plan_odom``, best first, on the floorplan with the
    fingerprint ``plan`` (empty without one), and ``submap`` is the builder's. ``scale`` is what
    was known of that floorplan's (:meth:`ScaleHistory.arrays`). ``odometry`` names the run of the
    odometry in whose frame all this is, in the words of whoever saved it; empty: unknown.
    """

    resolution_m: float
    stamp_ns: int
    T_odom_sensor: NDArray[np.float64]
    placements: Placements
    plan: str
    submap: dict[str, NDArray[Any]]
    scale: dict[str, NDArray[Any]]
    odometry: str = ''


def plan_fingerprint(grid: GridMap) -> str:
    """Return what tells one floorplan from another: a hash of its cells and their place."""
    digest = hashlib.sha256(np.ascontiguousarray(grid.cells).tobytes())
    digest.update(repr((grid.shape, grid.resolution)).encode())
    digest.update(grid.T_frame_grid.matrix.tobytes())
    return digest.hexdigest()


def write_state(path: Path | str, state: LocalizerState) -> None:
    """
    Write a state; a reader sees the old file or the new one, never half of it.

    Raises
    ------
    StateError
        If the folder cannot be made or written.
    """
    arrays = {
        'version': np.array(_VERSION),
        'resolution_m': np.array(state.resolution_m),
        'stamp_ns': np.array(state.stamp_ns, dtype=np.int64),
        'T_odom_sensor': state.T_odom_sensor,
        'placements': state.placements.matrix,
        'plan': np.array(state.plan),
        'odometry': np.array(state.odometry),
        **{_SCALE + name: array for name, array in state.scale.items()},
        **{_SUBMAP + name: array for name, array in state.submap.items()},
    }
    try:
        write_arrays(Path(path), arrays, is_durable=True)
    except OSError as error:
        raise StateError(f'cannot write the state to {path}: {error.strerror}') from None


def read_state(path: Path | str) -> LocalizerState:
    """
    Read a state.

    Raises
    ------
    StateError
        If the file is missing, damaged, or of another version.
    """
    try:
        return _from_arrays(read_arrays(Path(path)))
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise StateError(
            f'{path} is not a saved state: {error}; remove it, or save the state again'
        ) from None


def _from_arrays(arrays: dict[str, NDArray[Any]]) -> LocalizerState:
    if (version := int(arrays['version'])) != _VERSION:
        raise ValueError(f'version {version}, expected {_VERSION}')
    submap, scale = (_below(prefix, arrays) for prefix in (_SUBMAP, _SCALE))
    ours = {name for name in arrays if not name.startswith((_SUBMAP, _SCALE))}
    if unknown := ours ^ _KEYS:
        raise ValueError(f'unexpected or missing {", ".join(sorted(unknown))}')
    pose = np.array(arrays['T_odom_sensor'], dtype=np.float64)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise ValueError(f'T_odom_sensor: expected a finite (4, 4) matrix, got {pose.shape}')
    ScaleHistory.check(scale)
    return LocalizerState(
        float(arrays['resolution_m']),
        int(arrays['stamp_ns']),
        pose,
        Placements.of(map(Affine2D.from_matrix, arrays['placements'])),
        str(arrays['plan']),
        submap,
        scale,
        str(arrays['odometry']),
    )


def _below(prefix: str, arrays: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    names = [name for name in arrays if name.startswith(prefix)]
    return {name.removeprefix(prefix): arrays[name] for name in names}
