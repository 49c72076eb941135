# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A library of floorplans, and which of them may be what a robot has seen.

Searching a plan takes a tenth of a second, so of thousands only those are searched that the
library proposes. It is built once, saved in shards that can be made apart from each other, and
read from disk as far as a question needs.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
import json
import math
from pathlib import Path
from typing import Any

from fpnet.library.keypoints import Keypoints, keypoints_of
from fpnet.library.search import Known, ShardPlans, proposed
from fpnet.library.shard import Shard
from fpnet.library.walls import plan_walls
from fpnet_core.errors import LibraryError
from fpnet_core.plain_files import regular
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.types import GridMap, Segmentation

FORMAT = 3
"""Given: version of what is written, our own."""

_MANIFEST = 'plans.json'


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


@dataclass(frozen=True, eq=False)
class PlanLibrary:
    """Floorplans in shards; see :meth:`save` and :meth:`open`."""

    parts: tuple[ShardPlans, ...]

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
        ranked = proposed(self.parts, seen, scale)[:count]
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


def _part(plans: Iterable[LibraryPlan]) -> ShardPlans:
    group = list(plans)
    known = tuple(Known(plan.path, plan.low, plan.high) for plan in group)
    shard = Shard.of([plan.keypoints for plan in group], [plan.walls for plan in group])
    return ShardPlans(shard, known)


def _opened(path: Path) -> ShardPlans:
    manifest = path / _MANIFEST
    try:
        read = json.loads(regular(manifest).read_text(encoding='utf-8'))
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
    return ShardPlans(shard, plans)


def _known(read: Any) -> Known:
    known = Known(str(read['path']), float(read['low']), float(read['high']))
    if not 0.0 < known.low <= known.high < math.inf:
        raise ValueError(f'{known.path}: no interval of scales')
    return known
