# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader and writer for floorplans and occupancy maps: map_server YAML with image, or a bare image.

Images have row 0 at the top; a :class:`~fpnet_core.types.GridMap` has row 0 at the lowest y.
This module flips them; :func:`fpnet_core.raster.pixels.pixel_to_xy` maps between the two.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
import logging
from pathlib import Path
import re
import reprlib
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
import yaml

from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import SE2
from fpnet_core.io.clouds import CLOUD_SUFFIXES
from fpnet_core.io.images import (
    Box,
    check_crop,
    grey_levels,
    interpret,
    levels_of,
    load_pixels,
    opened_image,
)
from fpnet_core.plain_files import regular
from fpnet_core.plain_yaml import MAX_BYTES, read_yaml
from fpnet_core.raster.pixels import cut_from, pixel_to_xy
from fpnet_core.raster.windows import known_window
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

DEFAULT_RESOLUTION_M = 0.05
"""Nominal size of a pixel of a bare image without a given scale. Chosen."""

YAML_SUFFIXES = ('.yaml', '.yml')
"""Suffixes of map_server files, which state their scale."""

MAP_SUFFIXES = (
    *YAML_SUFFIXES, '.png', '.pgm', '.jpg', '.jpeg', '.webp', '.gif', '.bmp', '.tif', '.tiff',
)  # fmt: skip
"""Suffixes of the floorplans and robot maps that :func:`read_map` reads."""

# Given: by map_saver; a pixel of 205 stays unknown.
_OCCUPIED_THRESHOLD, _FREE_THRESHOLD = 0.65, 0.196
_SHADES = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}  # given
_STRIP_ROWS = 256  # numerical: rows that are converted to float at once
_MODES = ('trinary', 'scale', 'raw')
_MAP_KEY = re.compile(rb'^\{?["\']?(?:image|resolution|origin)["\']?\s*:', re.MULTILINE)  # given
_PICTURES = tuple(suffix for suffix in MAP_SUFFIXES if suffix not in YAML_SUFFIXES)

_log = logging.getLogger(__name__)


def states_scale(path: Path | str) -> bool:
    """Return whether a file states its scale: a map_server YAML or a point file."""
    return Path(path).suffix.lower() in (*YAML_SUFFIXES, *CLOUD_SUFFIXES)


def map_yamls(files: Iterable[Path]) -> list[Path]:
    """
    Return the map_server YAMLs among ``files``; log one warning that lists the others.

    A YAML counts as a map if it has a top-level key of map_server, or if there is an image of the
    same name, even if the YAML is damaged. Parameter files and bag metadata have neither.
    """
    yamls = [path for path in files if path.suffix.lower() in YAML_SUFFIXES and path.is_file()]
    meant = [path for path in yamls if _is_meant_as_map(path)]
    if others := [str(path) for path in yamls if path not in meant]:
        _log.warning('skipped, not map_server YAML: %s', ', '.join(others))
    return meant


def _is_meant_as_map(path: Path) -> bool:
    if any(path.with_suffix(suffix).is_file() for suffix in _PICTURES):
        return True
    try:
        with regular(path).open('rb') as file:
            return _MAP_KEY.search(file.read(MAX_BYTES)) is not None
    except OSError:
        return True  # reading it later raises an error with the reason


def image_of(path: Path) -> Path | None:
    """Return the path of a map_server YAML's image, or None if it has none."""
    try:
        image = _read_fields(path).get('image')
    except MapFormatError:
        return None
    return path.parent / image if isinstance(image, str) else None


def read_map(path: Path | str, resolution_m: float | None = None) -> GridMap:
    """
    Read a floorplan or robot map, frame ``plan``.

    Parameters
    ----------
    path
        A map_server YAML, read by nav2 map_server's rules, or an image (PNG, PGM, JPEG and
        others), which is binarized by its grey levels (see :mod:`fpnet_core.io.images`).
    resolution_m
        Size of a pixel of a bare image, default 0.05; overrides the resolution of a YAML.

    Returns
    -------
    GridMap
        In-between values of the YAML modes ``scale`` and ``raw`` become unknown. For a bare
        image the frame's origin is the lower left corner. A large map_server map is cropped to
        its known cells with a margin.

    Raises
    ------
    MapFormatError
        If a file is missing, damaged or too large, a key is missing or out of range, or the map
        has no free space or only free space.
    """
    path = Path(path)
    _check_resolution(resolution_m)
    if path.suffix.lower() in YAML_SUFFIXES:
        return read_map_part(path, resolution_m).grid
    resolution_m = resolution_m or DEFAULT_RESOLUTION_M
    cells = interpret(grey_levels(load_pixels(path)), resolution_m)
    grid = GridMap(cells[::-1], resolution_m)
    _check_content(grid, path)
    return grid


@dataclass(frozen=True, eq=False)
class MapPart:
    """
    Part of a map_server map that was read.

    Parameters
    ----------
    grid : the part, in the frame of the whole map
    left, top : position of the part's corner in the image [pixels]
    size : (width, height) of the image
    """

    grid: GridMap
    left: int
    top: int
    size: tuple[int, int]

    @property
    def A_frame_pixel(self) -> NDArray[np.float64]:
        """Affine map (3, 3) from pixels of the image to metres in the map's frame."""
        A_frame_part = pixel_to_xy(self.grid).matrix
        return np.asarray(A_frame_part @ cut_from(self.left, self.top))


def read_map_part(
    path: Path, resolution_m: float | None = None, crop: Box | None = None
) -> MapPart:
    """
    Read a map_server YAML or a crop of it; large maps are cropped to their known cells.

    Raises
    ------
    MapFormatError
        As :func:`read_map`; if the crop does not fit.
    """
    _check_resolution(resolution_m)
    fields = _read_fields(path)
    resolution_m = resolution_m or _number(fields, 'resolution', path)
    if resolution_m <= 0.0:
        raise MapFormatError(f'{path}: resolution must be positive, got {resolution_m}')
    T_frame_map = _origin(fields, path)
    image_path = path.parent / _image(fields, path)
    with opened_image(image_path) as image:
        size = image.size
        if crop is not None:
            check_crop(crop, size, path.name)
        cells = _cells(image, crop or (0, 0, *size), fields, path)
    rows, cols = known_window(cells != UNKNOWN)
    left, top = (crop or (0, 0))[:2]
    left, top = left + cols.start, top + rows.start
    below = size[1] - top - (rows.stop - rows.start)
    T_map_part = SE2.from_xy_yaw(left * resolution_m, below * resolution_m, 0.0)
    grid = GridMap(cells[rows, cols][::-1], resolution_m, T_frame_map @ T_map_part)
    _check_content(grid, path)
    return MapPart(grid, left, top, size)


def _check_resolution(resolution_m: float | None) -> None:
    if resolution_m is not None and not (np.isfinite(resolution_m) and resolution_m > 0.0):
        raise MapFormatError(f'resolution must be positive metres per pixel, got {resolution_m}')


def write_map(grid: GridMap, yaml_path: Path | str) -> None:
    """Write ``grid`` as a map_server YAML and a PNG with the same name."""
    yaml_path = Path(yaml_path)
    image_path = yaml_path.with_suffix('.png')
    yaml_path.parent.mkdir(parents=True, exist_ok=True)
    shades = np.full(grid.shape, _SHADES[UNKNOWN], dtype=np.uint8)
    shades[grid.cells == FREE] = _SHADES[FREE]
    shades[grid.cells == OCCUPIED] = _SHADES[OCCUPIED]
    Image.fromarray(shades[::-1]).save(image_path)
    pose = grid.T_frame_grid
    fields = {
        'image': image_path.name,
        'mode': 'trinary',
        'resolution': float(grid.resolution),
        'origin': [pose.x, pose.y, pose.yaw],
        'negate': 0,
        'occupied_thresh': _OCCUPIED_THRESHOLD,
        'free_thresh': _FREE_THRESHOLD,
    }
    yaml_path.write_text(yaml.safe_dump(fields, sort_keys=False), encoding='utf-8')


def _check_content(grid: GridMap, path: Path) -> None:
    free = np.count_nonzero(grid.cells == FREE)
    if free == 0:
        raise MapFormatError(
            f'map {path} has no free space; check its thresholds, negate flag and colours'
        )
    if free == grid.cells.size:
        raise MapFormatError(f'map {path} is empty: expected walls, got only free space')


def _origin(fields: dict[str, Any], path: Path) -> SE2:
    """Return the pose of the image's lower left corner."""
    origin = fields.get('origin')
    if not isinstance(origin, list) or len(origin) != 3:
        raise MapFormatError(
            f'{path}: origin must be [x, y, yaw] in m, m, rad, got {reprlib.repr(origin)}'
        )
    return SE2.from_xy_yaw(*(_as_number(value, 'origin', path) for value in origin))


def _image(fields: dict[str, Any], path: Path) -> str:
    image = fields.get('image')
    if not isinstance(image, str) or not image or not image.isprintable():
        raise MapFormatError(f'{path}: image must name the map image, got {reprlib.repr(image)}')
    return image


def _cells(image: Image.Image, box: Box, fields: dict[str, Any], path: Path) -> NDArray[np.int8]:
    """Return the cell values ``(H, W)`` of a part of an image, row 0 at the top."""
    left, top, right, bottom = box
    cells = np.empty((bottom - top, right - left), dtype=np.int8)
    for first in range(top, bottom, _STRIP_ROWS):
        last = min(first + _STRIP_ROWS, bottom)
        levels = levels_of(image.crop((left, first, right, last)))
        cells[first - top : last - top] = _threshold(levels, fields, path)
    return cells


def _read_fields(path: Path) -> dict[str, Any]:
    fields = read_yaml(path, MapFormatError, 'map')
    if not isinstance(fields, dict):
        raise MapFormatError(
            f'{path}: expected a map_server YAML with image, resolution and origin, '
            f'got {type(fields).__name__}'
        )
    return fields


def _number(fields: dict[str, Any], key: str, path: Path, default: float | None = None) -> float:
    if key not in fields and default is not None:
        return default
    if key not in fields:
        raise MapFormatError(f'{path}: {key} is missing; see the map_server format')
    return _as_number(fields[key], key, path)


def _as_number(value: Any, key: str, path: Path) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = float('nan')
    if not np.isfinite(number):
        raise MapFormatError(f'{path}: {key} must be a finite number, got {reprlib.repr(value)}')
    return number


def _threshold(
    pixels: NDArray[np.float32], fields: dict[str, Any], path: Path
) -> NDArray[np.int8]:
    """Return the cell values ``(H, W)`` by nav2 map_server's rules, row 0 at the top."""
    mode = str(fields.get('mode', 'trinary')).lower()
    if mode not in _MODES:
        raise MapFormatError(
            f'{path}: mode must be one of {", ".join(_MODES)}, got {reprlib.repr(mode)}'
        )
    free_below = _number(fields, 'free_thresh', path, _FREE_THRESHOLD)
    occupied_above = _number(fields, 'occupied_thresh', path, _OCCUPIED_THRESHOLD)
    if not 0.0 <= free_below <= occupied_above <= 1.0:
        raise MapFormatError(
            f'{path}: expected 0 <= free_thresh <= occupied_thresh <= 1, '
            f'got {free_below} and {occupied_above}'
        )
    has_alpha = pixels.shape[2] in (2, 4)
    shade = pixels[..., : 3 if pixels.shape[2] >= 3 else 1].mean(axis=2, dtype=np.float64)
    if has_alpha and mode == 'trinary':
        # As map_server does in this mode only: average alpha with the three colours.
        shade = (3.0 * shade + pixels[..., -1]) / 4.0
    if mode == 'raw':
        level = np.rint(shade * 255.0)
        occupancy = level / 100.0
        known = level <= 100
    else:
        occupancy = shade if _number(fields, 'negate', path, 0.0) else 1.0 - shade
        known = pixels[..., -1] == 1.0 if has_alpha and mode == 'scale' else np.True_
    cells = np.full(shade.shape, UNKNOWN, dtype=np.int8)
    cells[known & (occupancy > occupied_above)] = OCCUPIED
    cells[known & (occupancy < free_below)] = FREE
    return cells
