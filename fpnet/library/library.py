# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A library of floorplans, which proposes those that may contain a robot map.

Matching on one plan takes 0.1 s, so out of thousands only the proposed ones are searched. The
library is built once, saved in shards that can be built independently, and read from disk on
demand.
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
"""Given: version of our file format."""

_MANIFEST = 'plans.json'


@dataclass(frozen=True, eq=False)
class LibraryPlan:
    """
    A floorplan as an entry of the library.

    ``path`` is the drawing's file; ``keypoints`` and ``walls``, a coarse raster, are in metres as
    stated or estimated, relative to its middle; ``low`` and ``high`` bound the factor to its true
    size (1 and 1 if its scale was stated).
    """

    path: str
    keypoints: Keypoints
    walls: GridMap
    low: float = 1.0
    high: float = 1.0


@dataclass(frozen=True)
class Proposal:
    """A plan's file, its fit (only comparable within one query), and its rank from 1 on."""

    path: str
    fit: float
    rank: int


def plan_of(path: str, segmentation: Segmentation, scale: ScaleEstimate) -> LibraryPlan:
    """Return the library entry of a segmented floorplan."""
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
        Return a library of plans in memory; plans with a stated scale get their own shard.

        Raises
        ------
        LibraryError
            If there is no plan.
        """
        if not plans:
            raise LibraryError('no floorplan for the library; give at least one')
        stated = [plan for plan in plans if plan.low == plan.high]
        others = [plan for plan in plans if plan.low != plan.high]
        return cls(tuple(_part(group) for group in (stated, others) if group))

    def __len__(self) -> int:
        """Return the number of plans."""
        return sum(len(part.plans) for part in self.parts)

    @property
    def size_bytes(self) -> int:
        """Size of the index on disk."""
        return sum(part.shard.size_bytes for part in self.parts)

    def find(
        self, seen: Segmentation, scale: ScaleEstimate, count: int = 10
    ) -> tuple[Proposal, ...]:
        """
        Return the plans that most likely contain a robot map, best first.

        Parameters
        ----------
        seen : rooms and doors of a submap or robot map, in nominal metres
        scale : true metres per nominal metre, as stated or estimated
        count : largest number of plans
        """
        ranked = proposed(self.parts, seen, scale)[:count]
        return tuple(Proposal(path, fit, rank) for rank, (fit, path) in enumerate(ranked, 1))

    def save(self, folder: Path, first: int = 0) -> None:
        """
        Write the library into a folder, as shards from number ``first`` on.

        Machines that each build a share of the plans write into one folder with different
        numbers; together, their shards are one library.
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
            If the folder holds no library, or a damaged one.
        """
        shards = sorted(folder.glob('shard-*/')) if folder.is_dir() else []
        if not shards:
            raise LibraryError(
                f'{folder} is not a library of floorplans; build one with fpnet library build'
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
            f'{path} lists {len(plans)} plans but holds {len(shard)}; build it again'
        )
    return ShardPlans(shard, plans)


def _known(read: Any) -> Known:
    known = Known(str(read['path']), float(read['low']), float(read['high']))
    if not 0.0 < known.low <= known.high < math.inf:
        raise ValueError(f'{known.path}: invalid interval of scales')
    return known
