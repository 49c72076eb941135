# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reader for sites: a site YAML, a folder of floorplans, an Open-RMF building, or one plan."""

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
"""Given: names of the description in a site's folder."""

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
        one map_server YAML for each storey, or one floorplan, which makes a site of one storey.
    config
        Configuration to parse drawings; None uses the defaults.

    Raises
    ------
    SiteError
        If the description is malformed or inconsistent.
    MapFormatError
        If a storey's plan cannot be read; the message names the storey.
    """
    path, config = Path(path), config or FpnetConfig()
    if not path.exists():
        raise SiteError(f'{path} does not exist; pass a site.yaml, a folder, or a floorplan')
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
    """Return the description of a site in a folder, or the folder if there is none."""
    named = [folder / name for name in SITE_NAMES if (folder / name).is_file()]
    found = named or sorted(folder.glob(f'*{RMF_SUFFIX}'))
    if len(found) > 1:
        raise SiteError(f'{folder} has {len(found)} site descriptions; pass one of them')
    return found[0] if found else folder


def _of_maps(folder: Path, config: FpnetConfig) -> Site:
    """Return the site of the map_server maps in a folder, with levels from their names."""
    found = map_yamls(sorted(folder.iterdir()))
    if not found:
        raise SiteError(
            f'{folder} has no site.yaml, *{RMF_SUFFIX} or map_server YAML; write one, or run '
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
    """Return the site described by a site.yaml."""
    check_keys(values, _KEYS, str(path))
    listed = as_list(values.get('storeys'), f'{path}: storeys')
    spec = [_checked_entry(each, k, path) for k, each in enumerate(listed)]
    prefix = len({each.get('building') for each in spec}) > 1
    storeys = tuple(_storey(each, k, path, config, prefix) for k, each in enumerate(spec))
    links = as_list(values.get('links', []), f'{path}: links')
    name = as_text(values.get('site', path.parent.resolve().name), f'{path}: site', 'a name')
    return Site(name, storeys, tuple(_link(each, k, path) for k, each in enumerate(links)))


def _checked_entry(value: Any, number: int, path: Path) -> dict[str, Any]:
    where = f'{path}: storey {number + 1}'
    spec = as_mapping(value, where)
    check_keys(spec, _STOREY_KEYS, where)
    as_text(spec.get('name'), where, 'name: the name of the storey')
    as_text(spec.get('plan'), where, 'plan: its drawing or map_server YAML')
    return spec


def _storey(
    spec: dict[str, Any], number: int, path: Path, config: FpnetConfig, has_prefix: bool
) -> Storey:
    name, building = str(spec['name']), str(spec.get('building', ''))
    where = f'{path}: storey {name!r}'
    elevation = spec.get('elevation')
    return Storey(
        f'{building}/{name}' if has_prefix and building else name,
        _plan(path.parent / str(spec['plan']), _options(spec, where), config, name,
              is_mirrored=as_flag(spec.get('mirrored', False), f'{where}: mirrored')),
        building,
        as_whole(spec.get('level', number), f'{where}: level'),
        None if elevation is None else as_number(elevation, f'{where}: elevation', 'metres'),
        _pose(spec['pose'], where) if 'pose' in spec else None,
    )  # fmt: skip


def _options(spec: dict[str, Any], where: str) -> ReadOptions:
    """Return the options to read a storey's drawing."""
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
    read = {key: form(spec[key], f'{where}: {key}') for key, form in forms.items() if key in spec}
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
    """Read a storey's drawing; errors name the storey."""
    try:
        if not path.exists():
            raise MapFormatError(f'{path} does not exist')
        reading = read_plan(path, options, config)
    except FpnetError as error:
        raise MapFormatError(f'storey {name!r}: {error}') from None
    return reading.flipped() if is_mirrored else reading


def _link(value: Any, number: int, path: Path) -> Link:
    where = f'{path}: link {number + 1}'
    spec = as_mapping(value, where)
    check_keys(spec, _LINK_KEYS, where)
    name = as_text(spec.get('name', f'link {number + 1}'), where, 'name: the name of the link')
    kind = as_text(spec.get('kind', 'lift'), where, 'kind: lift or stairs')
    if kind not in _kinds():
        raise SiteError(f'{where}: kind: expected {" or ".join(_kinds())}, got {kind!r}')
    stops = as_mapping(spec.get('at'), f'{where}: at')
    at = {
        storey: np.array(as_numbers(xy, 2, f'{where}: at {storey!r}', '[x, y] in metres'))
        for storey, xy in stops.items()
    }
    return Link(name, LinkKind(kind), at)


def _kinds() -> Sequence[str]:
    return [kind.value for kind in LinkKind]
