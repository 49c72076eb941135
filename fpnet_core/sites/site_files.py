# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sites from files: a YAML of storeys, a folder of floorplans, an Open-RMF building, one plan."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import math
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.opening import RMF_SUFFIX
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.errors import FpnetError, MapFormatError, SiteError
from fpnet_core.geometry import SE2
from fpnet_core.io.maps import YAML_SUFFIXES, map_yamls
from fpnet_core.sites.fields import (
    as_flag,
    as_list,
    as_mapping,
    as_number,
    as_numbers,
    as_text,
    as_whole,
    check_keys,
    read_mapping,
)
from fpnet_core.sites.levels import levels_of
from fpnet_core.sites.open_rmf import read_open_rmf
from fpnet_core.sites.site import Link, LinkKind, Site, Storey

SITE_NAMES = ('site.yaml', 'site.yml')
"""Given: of the description in a site's folder."""

_KEYS = ('site', 'storeys', 'links')
_STOREY_KEYS = (
    'name', 'plan', 'building', 'level', 'elevation', 'pose', 'resolution', 'length', 'crop',
    'page', 'part', 'layers', 'mirrored',
)  # fmt: skip
_LINK_KEYS = ('name', 'kind', 'at')


def read_site(path: Path | str, config: FpnetConfig | None = None) -> Site:
    """
    Read a site.

    Parameters
    ----------
    path
        A YAML that lists storeys, an Open-RMF ``*.building.yaml``, a folder with either or with
        one map_server YAML for each storey, or one floorplan, which is a site of one.
    config
        How drawings are read; the defaults if None.

    Raises
    ------
    SiteError
        If the description is malformed or contradicts itself.
    MapFormatError
        If a storey's plan cannot be read; the message names the storey.
    """
    path, config = Path(path), config or FpnetConfig()
    if not path.exists():
        raise SiteError(f'{path} does not exist; give a site.yaml, a folder, or a floorplan')
    if path.is_dir():
        path = _description_in(path)
    if path.is_dir():
        return _of_maps(path, config)
    if path.name.endswith(RMF_SUFFIX):
        return read_open_rmf(path, config)
    if path.suffix.lower() not in YAML_SUFFIXES:
        return _of_one(path, config)
    values = read_mapping(path)
    return _of_one(path, config) if 'image' in values else _described(values, path, config)


def _description_in(folder: Path) -> Path:
    """Return what describes the site in a folder; the folder itself where nothing does."""
    named = [folder / name for name in SITE_NAMES if (folder / name).is_file()]
    found = named or sorted(folder.glob(f'*{RMF_SUFFIX}'))
    if len(found) > 1:
        raise SiteError(f'{folder} holds {len(found)} descriptions of sites; name one of them')
    return found[0] if found else folder


def _of_maps(folder: Path, config: FpnetConfig) -> Site:
    """Return the site of the map_server maps in a folder; their names say the levels."""
    found = map_yamls(sorted(folder.iterdir()))
    if not found:
        raise SiteError(
            f'{folder} holds no site.yaml, *{RMF_SUFFIX} or map_server YAML; write one, or run '
            'fpnet plan on the storeys'
        )
    storeys = [
        Storey(path.stem, _plan(path, ReadOptions(), config, path.stem), level=level)
        for level, path in sorted(
            zip(levels_of([path.stem for path in found]), found, strict=True)
        )
    ]
    return Site(folder.name, tuple(storeys))


def _of_one(path: Path, config: FpnetConfig) -> Site:
    reading = read_plan(path, ReadOptions(), config)
    return Site(path.stem, (Storey(path.stem, reading),))


def _described(values: dict[str, Any], path: Path, config: FpnetConfig) -> Site:
    """Return the site that our own YAML describes."""
    check_keys(values, _KEYS, str(path))
    listed = as_list(values.get('storeys'), f'{path}: storeys')
    told = [_told(each, k, path) for k, each in enumerate(listed)]
    prefix = len({each.get('building') for each in told}) > 1
    storeys = tuple(_storey(each, k, path, config, prefix) for k, each in enumerate(told))
    links = as_list(values.get('links', []), f'{path}: links')
    name = as_text(values.get('site', path.parent.resolve().name), f'{path}: site', 'a name')
    return Site(name, storeys, tuple(_link(each, k, path) for k, each in enumerate(links)))


def _told(value: Any, number: int, path: Path) -> dict[str, Any]:
    where = f'{path}: storey {number + 1}'
    told = as_mapping(value, where)
    check_keys(told, _STOREY_KEYS, where)
    as_text(told.get('name'), where, 'name: what the storey is called')
    as_text(told.get('plan'), where, 'plan: its drawing or map_server YAML')
    return told


def _storey(
    told: dict[str, Any], number: int, path: Path, config: FpnetConfig, has_prefix: bool
) -> Storey:
    name, building = str(told['name']), str(told.get('building', ''))
    where = f'{path}: storey {name!r}'
    elevation = told.get('elevation')
    return Storey(
        f'{building}/{name}' if has_prefix and building else name,
        _plan(path.parent / str(told['plan']), _options(told, where), config, name,
              is_mirrored=as_flag(told.get('mirrored', False), f'{where}: mirrored')),
        building,
        as_whole(told.get('level', number), f'{where}: level'),
        None if elevation is None else as_number(elevation, f'{where}: elevation', 'metres'),
        _pose(told['pose'], where) if 'pose' in told else None,
    )  # fmt: skip


def _options(told: dict[str, Any], where: str) -> ReadOptions:
    """Return what is said of a storey's drawing."""
    forms: dict[str, Callable[[Any, str], Any]] = {
        'resolution': lambda value, at: as_number(value, at, 'metres per pixel'),
        'length': lambda value, at: as_numbers(value, 5, at, '[x1, y1, x2, y2, metres]'),
        'crop': lambda value, at: [
            as_whole(each, at) for each in as_numbers(value, 4, at, '[left, top, right, bottom]')
        ],
        'part': as_whole,
        'page': as_whole,
        'layers': lambda value, at: [as_text(each, at, 'names') for each in as_list(value, at)],
    }
    read = {key: form(told[key], f'{where}: {key}') for key, form in forms.items() if key in told}
    length, crop = (tuple(read[key]) if key in read else None for key in ('length', 'crop'))
    return ReadOptions(
        read.get('resolution'), length, crop, read.get('part'), read.get('page'),
        tuple(read.get('layers', ())),
    )  # fmt: skip


def _pose(value: Any, where: str) -> SE2:
    x, y, yaw = as_numbers(value, 3, f'{where}: pose', '[x m, y m, yaw degrees]')
    return SE2.from_xy_yaw(x, y, math.radians(yaw))


def _plan(
    path: Path, options: ReadOptions, config: FpnetConfig, name: str, is_mirrored: bool = False
) -> Reading:
    """Return a storey's drawing as it is read; errors name the storey."""
    try:
        if not path.exists():
            raise MapFormatError(f'{path} does not exist')
        reading = read_plan(path, options, config)
    except FpnetError as error:
        raise MapFormatError(f'storey {name!r}: {error}') from None
    return reading.flipped() if is_mirrored else reading


def _link(value: Any, number: int, path: Path) -> Link:
    where = f'{path}: link {number + 1}'
    told = as_mapping(value, where)
    check_keys(told, _LINK_KEYS, where)
    name = as_text(told.get('name', f'link {number + 1}'), where, 'name: what it is called')
    kind = as_text(told.get('kind', 'lift'), where, 'kind: lift or stairs')
    if kind not in _kinds():
        raise SiteError(f'{where}: kind: expected {" or ".join(_kinds())}, got {kind!r}')
    stops = as_mapping(told.get('at'), f'{where}: at')
    at = {
        storey: np.array(as_numbers(xy, 2, f'{where}: at {storey!r}', '[x, y] in metres'))
        for storey, xy in stops.items()
    }
    return Link(name, LinkKind(kind), at)


def _kinds() -> Sequence[str]:
    return [kind.value for kind in LinkKind]
