# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader for Open-RMF buildings: ``*.building.yaml`` as written by its traffic editor.

A level has a drawing and measurements: pairs of vertices with their distance in metres. Vertices,
fiducials and lifts are in pixels of the drawing, x right and y down; those of a lift refer to its
reference floor. Fiducials with the same name are the same place on every level.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.formats.rmf import ends_of, metres_per_pixel, told_of, vertices_of
from fpnet_core.drawings.opening import RMF_SUFFIX
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.errors import FpnetError, MapFormatError, SiteError
from fpnet_core.geometry import SE2
from fpnet_core.raster.pixels import map_points
from fpnet_core.sites.fields import (
    as_list,
    as_mapping,
    as_number,
    as_numbers,
    as_text,
    read_mapping,
)
from fpnet_core.sites.site import Link, LinkKind, NamedDoor, Site, Storey

_IN_PIXELS = ('', 'reference_image')  # given: coordinate systems whose units are pixels
_FEWEST = 2  # physical: points that determine a planar pose

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Level:
    """A storey with its fiducials in its plan [m]; ``to_plan`` maps pixels (..., 2) to it."""

    storey: Storey
    fiducials: dict[str, Array]
    to_plan: Callable[[Array], Array]


def read_open_rmf(path: Path, config: FpnetConfig) -> Site:
    """
    Read an Open-RMF building: drawings, scales, levels, lifts and doors.

    Raises
    ------
    SiteError
        If the file is malformed, its units are not pixels, or a level has no measurement.
    MapFormatError
        If a drawing cannot be read; the message names the level.
    """
    values = read_mapping(path)
    system = str(values.get('coordinate_system', ''))
    if system not in _IN_PIXELS:
        raise SiteError(
            f'{path}: coordinate_system {system!r} is not in pixels of the drawings; write a '
            'site.yaml with the plan of each storey'
        )
    spec = as_mapping(values.get('levels'), f'{path}: levels')
    levels = {
        name: _level(name, as_mapping(each, f'{path}: level {name!r}'), path, config)
        for name, each in spec.items()
    }
    if not levels:
        raise SiteError(f'{path}: there are no levels; draw at least one')
    reference = levels[_reference(values, levels, path)]
    lifts = as_mapping(values.get('lifts') or {}, f'{path}: lifts')
    name = as_text(values.get('name', path.name.removesuffix(RMF_SUFFIX)), f'{path}: name', 'it')
    storeys = _levelled([_placed(level, reference) for level in levels.values()])
    poses = {storey.name: storey.T_site_plan for storey in storeys}
    links = [
        _lift(lift, as_mapping(each, f'{path}: lift {lift!r}'), levels, poses, path)
        for lift, each in lifts.items()
    ]
    return Site(name, storeys, tuple(link for link in links if len(link.at) > 1))


def _reference(values: dict[str, Any], levels: dict[str, _Level], path: Path) -> str:
    name = str(values.get('reference_level_name') or next(iter(levels)))
    if name not in levels:
        raise SiteError(
            f'{path}: reference_level_name is {name!r}, which is not a level; expected one of '
            f'{", ".join(levels)}'
        )
    return name


def _level(name: str, spec: dict[str, Any], path: Path, config: FpnetConfig) -> _Level:
    where = f'{path}: level {name!r}'
    drawing = as_mapping(spec.get('drawing'), f'{where}: drawing')
    file = as_text(drawing.get('filename'), f'{where}: drawing', 'filename: its image')
    try:
        points = vertices_of(spec)
        lines = [(ends_of(door, points), told_of(door)) for door in spec.get('doors') or []]
        options = ReadOptions(metres_per_pixel(spec, points))
        reading = read_plan(path.parent / file, options, config)
    except FpnetError as error:
        raise MapFormatError(f'level {name!r}: {error}') from None
    to_plan = _to_plan(reading)
    fiducials = as_list(spec.get('fiducials', []), f'{where}: fiducials')
    placed = {
        str(each[2]): to_plan(np.array(as_numbers(each, 2, f'{where}: fiducial', '[x, y, name]')))
        for each in fiducials
        if isinstance(each, list) and len(each) > 2
    }
    elevation = as_number(spec.get('elevation', 0.0), f'{where}: elevation', 'metres')
    doors = tuple(NamedDoor(str(each.get('name') or ''), to_plan(ends)) for ends, each in lines)
    storey = Storey(name, reading, elevation_m=elevation, doors=doors)
    return _Level(storey, placed, to_plan)


def _to_plan(reading: Reading) -> Callable[[Array], Array]:
    return lambda pixels: np.asarray(map_points(reading.H_plan_image, pixels), dtype=np.float64)


def _placed(level: _Level, reference: _Level) -> Storey:
    """Return the storey with its pose in the reference level's plan, from common fiducials."""
    common = sorted(level.fiducials.keys() & reference.fiducials.keys())
    T = None
    if level is reference:
        T = SE2.identity()
    elif len(common) >= _FEWEST:
        here, there = (
            np.array([each.fiducials[name] for name in common]) for each in (level, reference)
        )
        T = rigid_fit(here, there)
    return replace(level.storey, T_site_plan=T)


def rigid_fit(here: Array, there: Array) -> SE2:
    """Return the least-squares rigid transform from points ``here (N, 2)`` to ``there``."""
    middle, target = here.mean(axis=0), there.mean(axis=0)
    a, b = here - middle, there - target
    yaw = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = SE2.from_xy_yaw(0.0, 0.0, float(yaw))
    x, y = target - turn.apply(middle)
    return SE2.from_xy_yaw(float(x), float(y), float(yaw))


def _levelled(storeys: list[Storey]) -> tuple[Storey, ...]:
    """Return the storeys sorted by elevation, with their levels."""
    ordered = sorted(storeys, key=lambda storey: storey.elevation_m or 0.0)
    return tuple(replace(storey, level=level) for level, storey in enumerate(ordered))


def _lift(
    name: str,
    spec: dict[str, Any],
    levels: dict[str, _Level],
    poses: dict[str, SE2 | None],
    path: Path,
) -> Link:
    """Return a lift with its position on each level with a lift door and a known pose."""
    where = f'{path}: lift {name!r}'
    floor = as_text(spec.get('reference_floor_name'), where, 'reference_floor_name: a level')
    for stop in (floor, *(spec.get('level_doors') or {})):
        if stop not in levels:
            raise SiteError(
                f'{where} stops at {stop!r}, which is not a level; expected one of '
                f'{", ".join(levels)}'
            )
    pixels = as_numbers([spec.get('x'), spec.get('y')], 2, where, 'x and y in pixels')
    there = levels[floor].to_plan(np.array(pixels))
    T_site_floor = poses[floor]
    at = {}
    for stop in spec.get('level_doors') or {}:
        T_site_stop = poses[stop]
        if stop == floor:
            at[stop] = there
        elif T_site_floor is not None and T_site_stop is not None:
            at[stop] = (T_site_stop.inv() @ T_site_floor).apply(there)
    return Link(name, LinkKind.LIFT, at)
