# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A shard of a library: the words of some plans, memory-mapped from disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass
import os
from pathlib import Path
import shutil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet.library.keypoints import PERIOD, Keypoints
from fpnet.library.voting import LENGTH_UNIT_M, TURN_UNIT, count_partners, count_votes
from fpnet.library.walls import area_of, direction_of, packed, unpacked
from fpnet.library.words import WORDS, pairs_of_plan, pairs_of_query
from fpnet_core.errors import LibraryError
from fpnet_core.geometry import SE2
from fpnet_core.types import GridMap

_ARRAYS: dict[str, Any] = {
    'starts': np.int64,
    'plan': np.uint32,
    'middle': np.int16,
    'bearing': np.uint16,
    'firsts': np.int64,
    'xy': np.int16,
    'angle': np.uint16,
    'kind': np.uint8,
    'firsts_of_walls': np.int64,
    'walls': np.uint8,
    'shape': np.uint16,
    'frame': np.float32,
    'direction': np.float32,
    'area': np.float32,
}

_VOTES_A_PLAN = 300
"""
Chosen: average number of pairs of equal words per plan that vote, rarest words first; more cost
time and do not improve the results (docs/sites.md).
"""


@dataclass(frozen=True, eq=False)
class Shard:
    """
    Words of ``N`` plans: ``plan``, ``middle`` and ``bearing`` of ``E`` pairs, ordered by word.

    ``starts (W + 1,)`` is the first pair of each word. ``xy``, ``angle`` and ``kind`` are all
    plans' keypoints, those of a plan from ``firsts (N + 1,)`` on. Lengths and angles are integers
    in units of :data:`~fpnet.library.voting.LENGTH_UNIT_M` and ``TURN_UNIT``. ``walls (B,)`` are
    all plans' packed coarse rasters, those of a plan from ``firsts_of_walls (N + 1,)`` on; each
    has ``shape (N, 2)`` and ``frame (N, 4)``: cell and corner x, y [m], and yaw [rad]. The
    dominant wall direction is ``direction (N,)`` [rad], the covered area ``area (N,)`` [m^2].
    """

    starts: NDArray[np.int64]
    plan: NDArray[np.uint32]
    middle: NDArray[np.int16]
    bearing: NDArray[np.uint16]
    firsts: NDArray[np.int64]
    xy: NDArray[np.int16]
    angle: NDArray[np.uint16]
    kind: NDArray[np.uint8]
    firsts_of_walls: NDArray[np.int64]
    walls: NDArray[np.uint8]
    shape: NDArray[np.uint16]
    frame: NDArray[np.float32]
    direction: NDArray[np.float32]
    area: NDArray[np.float32]

    @classmethod
    def of(cls, plans: Sequence[Keypoints], walls: Sequence[GridMap]) -> Shard:
        """Return a shard with the words of plans and their coarse rasters."""
        pairs = [pairs_of_plan(keypoints) for keypoints in plans]
        word = np.concatenate([np.zeros(0, np.int64), *(each.word for each in pairs)])
        order = np.argsort(word, kind='stable')
        number = np.repeat(np.arange(len(plans)), [len(each) for each in pairs])
        middle = np.concatenate([np.zeros((0, 2)), *(each.middle for each in pairs)])
        bearing = np.concatenate([np.zeros(0), *(each.bearing for each in pairs)])
        rasters = [packed(each) for each in walls]
        return cls(
            np.searchsorted(word[order], np.arange(WORDS + 1)).astype(np.int64),
            number[order].astype(np.uint32),
            _lengths(middle[order]),
            _turns(bearing[order]),
            _firsts(plans),
            _lengths(np.concatenate([np.zeros((0, 2)), *(each.xy for each in plans)])),
            _turns(np.concatenate([np.zeros(0), *(each.angle for each in plans)])),
            np.concatenate([np.zeros(0, np.uint8), *(each.kind for each in plans)]),
            _firsts(rasters),
            np.frombuffer(b''.join(rasters), np.uint8),
            np.array([each.shape for each in walls], np.uint16),
            np.array([_frame(each) for each in walls], np.float32),
            np.array([direction_of(each) for each in walls], np.float32),
            np.array([area_of(each) for each in walls], np.float32),
        )

    def __len__(self) -> int:
        """Return the number of plans."""
        return len(self.firsts) - 1

    def walls_of(self, number: int) -> GridMap:
        """
        Return the coarse raster of a plan.

        Raises
        ------
        LibraryError
            If the raster is damaged.
        """
        own = slice(int(self.firsts_of_walls[number]), int(self.firsts_of_walls[number + 1]))
        rows, cols = self.shape[number].tolist()
        cells = unpacked(self.walls[own].tobytes(), (rows, cols))
        cell, x, y, yaw = self.frame[number].tolist()
        return GridMap(cells, cell, SE2.from_xy_yaw(x, y, yaw))

    def voted(self, seen: Keypoints) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """
        Return each plan's most votes for one placement ``(N,)``, and that one ``(N, 3)``.

        Placements are yaw, x and y of the robot map in the plan's metres.
        """
        asked = pairs_of_query(seen)
        frequency = self.starts[asked.word + 1] - self.starts[asked.word]
        rarest = np.argsort(frequency, kind='stable')
        followed = np.cumsum(frequency[rarest]) <= _VOTES_A_PLAN * len(self)
        chosen = rarest[followed & (frequency[rarest] > 0)]
        weight = np.log(1.0 + len(self.plan) / (1.0 + frequency[chosen]))
        return count_votes(
            self.starts, self.plan, self.middle, self.bearing,
            asked.word[chosen], weight.astype(np.float32),
            asked.middle[chosen], asked.bearing[chosen], len(self),
        )  # fmt: skip

    def partners(self, seen: Keypoints, number: int, pose: NDArray[np.float32]) -> float:
        """Return the weighted number of partners in a plan; ``pose (3,)`` is aligned in place."""
        own = slice(int(self.firsts[number]), int(self.firsts[number + 1]))
        # Numba takes longer to identify the type of a memmap than to process plain arrays.
        xy, angle, kind = np.asarray(self.xy), np.asarray(self.angle), np.asarray(self.kind)
        found: float = count_partners(
            seen.xy, seen.angle, seen.kind, xy[own], angle[own], kind[own], pose, PERIOD
        )
        return found

    @property
    def size_bytes(self) -> int:
        """Size on disk, and in memory once all of it was read."""
        return sum(int(getattr(self, name).nbytes) for name in _ARRAYS)

    def save(self, folder: Path, texts: Mapping[str, str]) -> None:
        """Write the arrays and ``texts`` into a folder, completely or not at all."""
        beside = folder.with_name(f'{folder.name}.part')
        shutil.rmtree(beside, ignore_errors=True)
        beside.mkdir(parents=True)
        for name in _ARRAYS:
            np.save(beside / f'{name}.npy', getattr(self, name))
        for name, text in texts.items():
            (beside / name).write_text(text, encoding='utf-8')
        shutil.rmtree(folder, ignore_errors=True)
        os.replace(beside, folder)

    @classmethod
    def open(cls, folder: Path) -> Shard:
        """
        Return a saved shard; its arrays stay on disk until they are read.

        Raises
        ------
        LibraryError
            If a file is missing, damaged or of another kind.
        """
        try:
            arrays = {
                name: np.load(folder / f'{name}.npy', mmap_mode='r', allow_pickle=False)
                for name in _ARRAYS
            }
        except (OSError, ValueError, EOFError) as error:
            raise LibraryError(f'{folder}: {error}; build the library again') from error
        shard = cls(**arrays)
        shard._check(folder)
        return shard

    def _check(self, folder: Path) -> None:
        """Raise LibraryError if the arrays are inconsistent: kernels do not check bounds."""
        pairs, points = len(self.plan), len(self.kind)
        is_sound = (
            all(getattr(self, name).dtype == dtype for name, dtype in _ARRAYS.items())
            and self.starts.shape == (WORDS + 1,)
            and self.middle.shape == (pairs, 2)
            and self.bearing.shape == (pairs,)
            and self.xy.shape == (points, 2)
            and self.angle.shape == (points,)
            and _partitions(self.starts, pairs)
            and len(self) > 0
            and _partitions(self.firsts, points)
            and self.shape.shape == (len(self), 2)
            and self.frame.shape == (len(self), 4)
            and bool(np.isfinite(self.frame).all())
            and bool((self.frame[:, 0] > 0.0).all())
            and self.direction.shape == self.area.shape == (len(self),)
            and bool(np.isfinite(self.direction).all())
            and self.firsts_of_walls.shape == self.firsts.shape
            and _partitions(self.firsts_of_walls, len(self.walls))
            and int(self.plan.max(initial=0)) < len(self)
            and int(self.kind.max(initial=0)) < len(PERIOD)
        )
        if not is_sound:
            raise LibraryError(f'{folder} is not a valid shard; build the library again')


def _partitions(bounds: NDArray[np.int64], count: int) -> bool:
    """Return whether ``bounds`` split ``count`` items into consecutive groups."""
    return bounds[0] == 0 and bounds[-1] == count and bool((np.diff(bounds) >= 0).all())


def _firsts(pieces: Sequence[Sized]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum([len(each) for each in pieces])]).astype(np.int64)


def _frame(walls: GridMap) -> tuple[float, ...]:
    pose = walls.T_frame_grid
    return walls.resolution, *pose.translation.tolist(), pose.yaw


def _lengths(metres: NDArray[Any]) -> NDArray[np.int16]:
    limits = np.iinfo(np.int16)
    return np.clip(np.rint(metres / LENGTH_UNIT_M), limits.min, limits.max).astype(np.int16)


def _turns(radians: NDArray[Any]) -> NDArray[np.uint16]:
    steps = np.rint(np.asarray(radians, dtype=np.float64) / TURN_UNIT).astype(np.int64)
    return (steps % (np.iinfo(np.uint16).max + 1)).astype(np.uint16)
