# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A library of floorplans, and which of them may be what a robot has seen.

Searching a plan takes a tenth of a second, so of thousands only those are searched that the
library proposes. It is built once, saved in shards that can be made apart from each other, and
read from disk as far as a question needs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import LibraryError
from fpnet_core.geometry import Placements
from fpnet_core.library.keypoints import Keypoints, keypoints_of
from fpnet_core.library.shard import Shard
from fpnet_core.library.walls import SeenWalls, plan_walls, seen_walls
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.types import GridMap, Segmentation

FORMAT = 2
"""Given: version of what is written, our own."""

_MANIFEST = 'plans.json'

# Chosen, not measured:
# Plans whose votes are looked at closely, in every shard and at every scale.
_LOOKED_AT = 100
# Placements whose walls are compared at least; the share of them, which is more where many scales
# are tried; and how many of one plan, at several scales.
_COMPARED, _COMPARED_SHARE, _OF_A_PLAN = 40, 0.15, 2
# Scales are tried this much apart; walls 9 m apart are then a step and a half off at most.
_SCALE_STEP = 1.06


@dataclass(frozen=True, eq=False)
class LibraryPlan:
    """
    A floorplan as the library knows it.

    ``path`` is the drawing's file; ``keypoints`` and ``walls``, a coarse raster, are in metres as
    stated or estimated around its middle, ``low`` and ``high`` how much smaller and larger it may
    be (1 and 1 where its scale was stated).
    """

    path: str
    keypoints: Keypoints
    walls: GridMap
    low: float = 1.0
    high: float = 1.0


@dataclass(frozen=True)
class Proposal:
    """A plan's file, how well it fits (only to be compared), and its rank from 1 on."""

    path: str
    fit: float
    rank: int


def plan_of(path: str, segmentation: Segmentation, scale: ScaleEstimate) -> LibraryPlan:
    """Return a floorplan that was cut into rooms as the library knows it."""
    factor = scale.factor
    keypoints, walls = keypoints_of(segmentation, factor), plan_walls(segmentation, factor)
    return LibraryPlan(path, keypoints, walls, scale.low / factor, scale.high / factor)


@dataclass(frozen=True)
class _Known:
    """What is written of a plan."""

    path: str
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class _Part:
    """A shard, and its plans in order."""

    shard: Shard
    plans: tuple[_Known, ...]


@dataclass(frozen=True, eq=False)
class _Candidate:
    """
    A placement on plan ``number`` of a part that keypoints speak for, and how much.

    ``pose (3,)`` is yaw, x and y of what was seen, ``factor`` times enlarged, in metres.
    """

    part: _Part
    number: int
    fit: float
    pose: NDArray[np.float32]
    factor: float

    @property
    def plan(self) -> tuple[int, int]:
        """Which plan it is on."""
        return id(self.part), self.number


@dataclass(frozen=True, eq=False)
class PlanLibrary:
    """Floorplans in shards; see :meth:`save` and :meth:`open`."""

    parts: tuple[_Part, ...]

    @classmethod
    def of(cls, plans: Sequence[LibraryPlan]) -> PlanLibrary:
        """
        Return a library of plans in memory; those that state their scale apart from the others.

        Raises
        ------
        LibraryError
            If there is no plan.
        """
        if not plans:
            raise LibraryError('there is no floorplan to make a library of; give at least one')
        stated = [plan for plan in plans if plan.low == plan.high]
        others = [plan for plan in plans if plan.low != plan.high]
        return cls(tuple(_part(group) for group in (stated, others) if group))

    def __len__(self) -> int:
        """Count the plans."""
        return sum(len(part.plans) for part in self.parts)

    @property
    def size_bytes(self) -> int:
        """What the index takes on disk."""
        return sum(part.shard.size_bytes for part in self.parts)

    def find(
        self, seen: Segmentation, scale: ScaleEstimate, count: int = 10
    ) -> tuple[Proposal, ...]:
        """
        Return the plans that are most worth searching for what a robot has seen, best first.

        Parameters
        ----------
        seen : rooms and doors of a submap or of a robot's map, in nominal metres
        scale : true metres per nominal metre, as stated or estimated
        count : how many plans at most
        """
        keypoints = keypoints_of(seen, scale.factor)
        low, high = scale.low / scale.factor, scale.high / scale.factor
        found = [each for part in self.parts for each in _candidates(part, keypoints, low, high)]
        if not found:
            return ()
        fits = _compared(_shortlist(found, count), SeenWalls.of(seen_walls(seen, scale.factor)))
        ranked = sorted(fits, key=lambda each: -each[0])[:count]
        return tuple(Proposal(path, fit, rank) for rank, (fit, path) in enumerate(ranked, 1))

    def save(self, folder: Path, first: int = 0) -> None:
        """
        Write the library into a folder, as shards from number ``first`` on.

        Machines that each build a share of the plans write into one folder from different
        numbers on; what they wrote together is one library.
        """
        folder.mkdir(parents=True, exist_ok=True)
        for number, part in enumerate(self.parts, first):
            path = folder / f'shard-{number:05d}'
            plans = [asdict(plan) for plan in part.plans]
            manifest = json.dumps({'format': FORMAT, 'plans': plans}, indent=0)
            part.shard.save(path, {_MANIFEST: manifest})

    @classmethod
    def open(cls, folder: Path) -> PlanLibrary:
        """
        Return a saved library.

        Raises
        ------
        LibraryError
            If the folder holds none, or a damaged one.
        """
        shards = sorted(folder.glob('shard-*/')) if folder.is_dir() else []
        if not shards:
            raise LibraryError(
                f'{folder} is no library of floorplans; make one by fpnet library build'
            )
        return cls(tuple(_opened(path) for path in shards))


def _part(plans: Iterable[LibraryPlan]) -> _Part:
    group = list(plans)
    known = tuple(_Known(plan.path, plan.low, plan.high) for plan in group)
    shard = Shard.of([plan.keypoints for plan in group], [plan.walls for plan in group])
    return _Part(shard, known)


def _opened(path: Path) -> _Part:
    manifest = path / _MANIFEST
    try:
        read = json.loads(manifest.read_text(encoding='utf-8'))
        if read['format'] != FORMAT:
            raise LibraryError(f'{path} has format {read["format"]}; build the library again')
        plans = tuple(_known(each) for each in read['plans'])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise LibraryError(f'{manifest}: {error!r}; build the library again') from error
    shard = Shard.open(path)
    if len(shard) != len(plans):
        raise LibraryError(
            f'{path} names {len(plans)} plans and holds {len(shard)}; build it again'
        )
    return _Part(shard, plans)


def _known(read: Any) -> _Known:
    known = _Known(str(read['path']), float(read['low']), float(read['high']))
    if not 0.0 < known.low <= known.high < math.inf:
        raise ValueError(f'{known.path}: no interval of scales')
    return known


def _candidates(part: _Part, seen: Keypoints, low: float, high: float) -> Iterator[_Candidate]:
    """Yield where keypoints lie on those of a part's plans, at every scale that is possible."""
    lows = np.array([plan.low for plan in part.plans])
    highs = np.array([plan.high for plan in part.plans])
    # What was seen is enlarged by a factor: the plan may be too large, or itself too small.
    smallest, largest = low / highs, high / lows
    for factor in _factors(float(smallest.min()), float(largest.max())):
        fits, poses = part.shard.ranked(seen.scaled(factor), _LOOKED_AT)
        slack = math.sqrt(_SCALE_STEP)
        is_possible = (smallest / slack <= factor) & (factor <= largest * slack)
        for number in np.flatnonzero(is_possible & (fits > 0.0)).tolist():
            yield _Candidate(part, number, float(fits[number]), poses[number], factor)


def _shortlist(found: Sequence[_Candidate], count: int) -> list[list[_Candidate]]:
    """Return the candidates that fit best, by plan; of at least ``count`` plans if there are."""
    chosen: dict[tuple[int, int], list[_Candidate]] = {}
    left = max(_COMPARED, round(_COMPARED_SHARE * len(found)), count * _OF_A_PLAN)
    for each in sorted(found, key=lambda each: -each.fit):
        own = chosen.setdefault(each.plan, [])
        if len(own) < _OF_A_PLAN:
            own.append(each)
            left -= 1
        if left == 0:
            break
    return list(chosen.values())


def _compared(plans: Sequence[list[_Candidate]], seen: SeenWalls) -> list[tuple[float, str]]:
    """Return how well each plan fits by keypoints and by walls at its best, and its path."""
    found = []
    for own in plans:
        part, number = own[0].part, own[0].number
        walls = seen.fits(part.shard.walls_of(number), _placements(own))
        fit = float(np.max(walls * [each.fit for each in own]))
        found.append((fit, part.plans[number].path))
    return found


def _placements(candidates: Sequence[_Candidate]) -> Placements:
    poses = np.array([each.pose for each in candidates], np.float64)
    factors = np.array([each.factor for each in candidates])
    cos, sin = factors * np.cos(poses[:, 0]), factors * np.sin(poses[:, 0])
    return Placements(np.array([[cos, -sin], [sin, cos]]).transpose(2, 0, 1), poses[:, 1:])


def _factors(smallest: float, largest: float) -> list[float]:
    steps = math.ceil(math.log(largest / smallest) / math.log(_SCALE_STEP) - 1e-9)
    return np.geomspace(smallest, largest, steps + 1).tolist() if steps else [smallest]
