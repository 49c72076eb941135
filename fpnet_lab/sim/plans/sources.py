# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the storeys of matching pairs come from: the generator, or drawings of real buildings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import hashlib
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.io.maps import MAP_SUFFIXES, YAML_SUFFIXES
from fpnet_core.types import GridMap
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.traced import plan_from_grid
from fpnet_lab.sim.types import BuildingPlan

MIN_ROOMS = 2
"""A building of fewer rooms has nothing to tell apart. Chosen."""

_DIGEST_CHARACTERS = 16  # given


@dataclass(frozen=True, eq=False)
class NamedPlan:
    """
    One storey and what its pairs are called after.

    ``raster`` is the drawing it was traced from, frame ``building``; None for a generated one.
    """

    plan: BuildingPlan
    name: str
    raster: GridMap | None = None


class PlanSource(Protocol):
    """A supply of storeys, the same in every process; hashable, so that they can be kept."""

    def __hash__(self) -> int:
        """Return the source's hash; equal sources may share what was made from them."""
        ...

    def plan_id(self, number: int) -> int:
        """Return the id of the ``number``-th storey asked for; equal ids are one building."""
        ...

    def storey(self, seed: int, plan_id: int, version: int) -> NamedPlan:
        """Return a storey; another ``version`` where there is one that may suit better."""
        ...

    def describe(self) -> dict[str, Any]:
        """Return what a manifest says about the source; equal sources give equal pairs."""
        ...


@dataclass(frozen=True)
class GeneratedPlans:
    """Storeys of the generator, each another one; no ``families`` are all but homes."""

    min_rooms: int
    max_rooms: int
    families: tuple[str, ...] = ()

    def plan_id(self, number: int) -> int:
        """Return ``number``: no storey comes twice."""
        return number

    def storey(self, seed: int, plan_id: int, version: int) -> NamedPlan:
        """Return a generated storey."""
        rng = np.random.default_rng([seed, plan_id, 0, version])
        plan = generate_plan(
            rng, min_rooms=self.min_rooms, max_rooms=self.max_rooms, families=self.families
        )
        return NamedPlan(plan, plan.family)

    def describe(self) -> dict[str, Any]:
        """Return the kind of source."""
        return {'kind': 'generated'}


def generated_plans(config: SimConfig) -> GeneratedPlans:
    """Return the generator's storeys as ``config`` wants them."""
    return GeneratedPlans(config.min_rooms, config.max_rooms, config.families)


class GivenPlans:
    """
    The buildings that some floorplans show, over and over.

    Parameters
    ----------
    plans : name and drawing of each building
    config : how drawings are cut into rooms

    Raises
    ------
    MapFormatError
        If there is no plan, or a plan has fewer than two rooms.
    """

    def __init__(
        self, plans: Sequence[tuple[str, GridMap]], config: SegmentationConfig | None = None
    ) -> None:
        if not plans:
            raise MapFormatError('no floorplan was given; name images, YAML files or a folder')
        self._storeys = [_trace(name, grid, config) for name, grid in plans]

    def __len__(self) -> int:
        """Count the buildings."""
        return len(self._storeys)

    def plan_id(self, number: int) -> int:
        """Return the building's number; they take turns."""
        return number % len(self._storeys)

    def storey(self, seed: int, plan_id: int, version: int) -> NamedPlan:
        """Return building ``plan_id``; neither seed nor version change it."""
        del seed, version
        return self._storeys[plan_id]

    def describe(self) -> dict[str, Any]:
        """Return the plans' names with digests of their drawings."""
        return {'kind': 'given', 'plans': {s.name: _digest(s) for s in self._storeys}}


def _trace(name: str, grid: GridMap, config: SegmentationConfig | None) -> NamedPlan:
    try:
        plan = plan_from_grid(grid, config)
    except MapFormatError as error:
        raise MapFormatError(f'{name}: {error}') from None
    if len(plan.rooms) < MIN_ROOMS:
        raise MapFormatError(
            f'{name}: the floorplan has {len(plan.rooms)} room, expected {MIN_ROOMS} or more; '
            'check its metres per pixel'
        )
    return NamedPlan(replace(plan, family=name), name, grid)


def _digest(storey: NamedPlan) -> str:
    assert storey.raster is not None
    content = storey.raster.cells.tobytes() + np.float64(storey.raster.resolution).tobytes()
    return hashlib.sha256(content).hexdigest()[:_DIGEST_CHARACTERS]


def read_plans(
    paths: Sequence[Path], resolution_m: float | None = None
) -> list[tuple[str, GridMap]]:
    """
    Read the drawings in some files and folders, through the reader that all commands share.

    Parameters
    ----------
    paths : files and folders, see :func:`find_plans`
    resolution_m : edge of a pixel; None takes what each drawing says, or its rooms and doors

    Returns
    -------
    Names (file names without suffix) and drawings, sorted within folders.

    Raises
    ------
    MapFormatError
        If a file is missing or no drawing, or a folder holds none.
    """
    said = ReadOptions(resolution_m=resolution_m)
    return [(path.stem, read_plan(path, said).grid) for path in find_plans(paths)]


def find_plans(paths: Sequence[Path]) -> list[Path]:
    """
    Return the drawings among some files and folders.

    An image that a YAML of the same name describes is named once, as the YAML.

    Raises
    ------
    MapFormatError
        If a folder holds none.
    """
    found: list[Path] = []
    for path in paths:
        found += _maps_in(path) if path.is_dir() else [path]
    described = {path.with_suffix('') for path in found if path.suffix.lower() in YAML_SUFFIXES}
    return [
        path
        for path in found
        if path.suffix.lower() in YAML_SUFFIXES or path.with_suffix('') not in described
    ]


def _maps_in(folder: Path) -> list[Path]:
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in MAP_SUFFIXES)
    if not files:
        raise MapFormatError(f'{folder} holds no floorplan; expected images or YAML files')
    return files
