# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sources of storeys for matching pairs: the generator, or drawings of real buildings."""

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
"""Minimum number of rooms: a single room cannot be confused with another. Chosen."""

_DIGEST_CHARACTERS = 16  # given


@dataclass(frozen=True, eq=False)
class NamedPlan:
    """
    A storey with the name of its pairs.

    ``raster`` is the drawing it was traced from, frame ``building``; None if generated.
    """

    plan: BuildingPlan
    name: str
    raster: GridMap | None = None


class PlanSource(Protocol):
    """A source of storeys, identical in every process; hashable for use as a cache key."""

    def __hash__(self) -> int:
        """Return the source's hash; equal sources share cached results."""
        ...

    def plan_id(self, number: int) -> int:
        """Return the id of the ``number``-th storey; equal ids mean the same building."""
        ...

    def storey(self, seed: int, plan_id: int, version: int) -> NamedPlan:
        """Return a storey; generated sources return a different storey for each ``version``."""
        ...

    def describe(self) -> dict[str, Any]:
        """Return the source's entry in the manifest; equal entries give equal pairs."""
        ...


@dataclass(frozen=True)
class GeneratedPlans:
    """Generated storeys, each used once; empty ``families`` uses the generator's default."""

    min_rooms: int
    max_rooms: int
    families: tuple[str, ...] = ()

    def plan_id(self, number: int) -> int:
        """Return ``number``: every storey is used once."""
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
    """Return a source of generated storeys as configured by ``config``."""
    return GeneratedPlans(config.min_rooms, config.max_rooms, config.families)


class GivenPlans:
    """
    A source that cycles through the buildings of given floorplans.

    Parameters
    ----------
    plans : name and drawing of each building
    config : segmentation of the drawings into rooms

    Raises
    ------
    MapFormatError
        If there is no plan, or if a plan has fewer than two rooms.
    """

    def __init__(
        self, plans: Sequence[tuple[str, GridMap]], config: SegmentationConfig | None = None
    ) -> None:
        if not plans:
            raise MapFormatError('no floorplan was given; pass images, YAML files or a folder')
        self._storeys = [_trace(name, grid, config) for name, grid in plans]

    def __len__(self) -> int:
        """Return the number of buildings."""
        return len(self._storeys)

    def plan_id(self, number: int) -> int:
        """Return the building's index; buildings are used in turn."""
        return number % len(self._storeys)

    def storey(self, seed: int, plan_id: int, version: int) -> NamedPlan:
        """Return building ``plan_id``; seed and version have no effect."""
        del seed, version
        return self._storeys[plan_id]

    def describe(self) -> dict[str, Any]:
        """Return the plans' names and the digests of their drawings."""
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
    Read the drawings in files and folders with the reader that all commands use.

    Parameters
    ----------
    paths : files and folders, see :func:`find_plans`
    resolution_m : edge of a pixel; None uses each drawing's own scale, or its rooms and doors

    Returns
    -------
    Names (file names without suffix) and drawings, sorted within folders.

    Raises
    ------
    MapFormatError
        If a file is missing or not a drawing, or if a folder contains none.
    """
    options = ReadOptions(resolution_m=resolution_m)
    return [(path.stem, read_plan(path, options).grid) for path in find_plans(paths)]


def find_plans(paths: Sequence[Path]) -> list[Path]:
    """
    Return the paths of the drawings among files and folders.

    An image described by a YAML of the same name is listed once, as the YAML.

    Raises
    ------
    MapFormatError
        If a folder contains no drawing.
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
