# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawing parser: from any drawing to a map with its scale and warnings."""

from __future__ import annotations

from dataclasses import replace
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig, SegmentationConfig
from fpnet_core.drawings.formats.images import WORK_PIXELS
from fpnet_core.drawings.opening import RMF_SUFFIX, open_drawing
from fpnet_core.drawings.pictures.doubts import Doubts, doubts_of
from fpnet_core.drawings.pictures.hypothesis import PlanHypothesis, find_building, stride
from fpnet_core.drawings.pictures.plausible import findings
from fpnet_core.drawings.pictures.thin_lines import without_thin_lines
from fpnet_core.drawings.plan_files import MAP_FORMAT, PlanRecord, recorded
from fpnet_core.drawings.reduced import in_image_pixels, options_of_copy
from fpnet_core.drawings.scaling import resolve_scale
from fpnet_core.drawings.stated import exact
from fpnet_core.drawings.stated_model import model_reading, placed_model
from fpnet_core.drawings.types import (
    Drawing,
    Length,
    Reading,
    ReadOptions,
    ScaleSource,
)
from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import scale_of
from fpnet_core.io.images import check_crop
from fpnet_core.io.maps import YAML_SUFFIXES, MapPart, read_map_part
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

_LONG_M = (0.5, 20_000.0)  # physical: plausible length of a building's sheet
_DEFAULTS = ReadOptions()


def read_plan(
    path: Path | str, options: ReadOptions = _DEFAULTS, config: FpnetConfig | None = None
) -> Reading:
    """
    Parse a drawing of a building into a map.

    Parameters
    ----------
    path
        A map_server YAML, used with its own thresholds, or any format that
        :func:`fpnet_core.drawings.opening.open_drawing` opens.
    options
        User options.
    config
        How rooms are segmented; the defaults if None.

    Raises
    ------
    MapFormatError
        If the file cannot be read, an option does not fit it, or it shows no building.
    """
    path, config = Path(path), config or FpnetConfig()
    _check_values(options)
    is_building = path.name.lower().endswith(RMF_SUFFIX)
    if path.suffix.lower() in YAML_SUFFIXES and not is_building:
        return replace(_read_map(path, options), config=config.segmentation)
    return read_drawing(open_drawing(path, options), options, config.segmentation)


def _check_values(options: ReadOptions) -> None:
    """Reject options that are invalid for any drawing."""
    if options.resolution_m is not None:
        if options.length is not None:
            raise MapFormatError('resolution and length both state the scale; give one of them')
        if not 0.0 < options.resolution_m < np.inf:
            raise MapFormatError(
                f'resolution must be positive metres per pixel, got {options.resolution_m}'
            )
    for name, count in (('length', 5), ('crop', 4)):
        numbers = getattr(options, name)
        if numbers is not None and len(numbers) != count:
            raise MapFormatError(f'{name}: expected {count} numbers, got {numbers!r}')
    for name in ('storey', 'page'):
        number = getattr(options, name)
        if number is not None and number < 1:
            raise MapFormatError(f'{name}: expected a number of at least 1, got {number}')


def _read_map(path: Path, options: ReadOptions) -> Reading:
    """Return a map_server map, classified by the thresholds of its YAML."""
    _reject_options(path, options)
    part = read_map_part(path, options.resolution_m, options.crop)
    width, height = part.size
    known = _record_of_map(path, options, part.grid.resolution, (height, width))
    scale = known.scale
    if scale.resolution_m != part.grid.resolution:
        part = read_map_part(path, scale.resolution_m, options.crop)
    drawing = Drawing(_pixels_of(part), path.name, MAP_FORMAT, scale=scale, full_size=part.size)
    _check_size(drawing, scale.resolution_m)
    how = 'a map_server map, with the thresholds of its YAML'
    return Reading(
        part.grid, scale, part.A_frame_pixel, how, drawing, doubts=known.doubts,
        accepted=known.accepted, names=known.names,
    )  # fmt: skip


def _pixels_of(part: MapPart) -> NDArray[np.uint8]:
    """Return the image (H, W, 3) of a whole map, reduced if large."""
    width, height = part.size
    cells = np.full((height, width), UNKNOWN, dtype=np.int8)
    rows, cols = part.grid.shape
    cells[part.top : part.top + rows, part.left : part.left + cols] = part.grid.cells[::-1]
    step = math.ceil(math.sqrt(cells.size / WORK_PIXELS))
    cells = cells[::step, ::step]
    shades = np.select([cells == FREE, cells == OCCUPIED], [254, 0], 205).astype(np.uint8)
    return np.broadcast_to(shades[..., None], (*shades.shape, 3))


def _record_of_map(
    path: Path, options: ReadOptions, cell_m: float, shape: tuple[int, int]
) -> PlanRecord:
    """Return a map's scale, with the warnings of its record if it was parsed from a drawing."""
    if options.length is not None:
        stated_m = _metres_per_pixel(options.length, path.name, shape)
        why = f'from a length of {options.length[-1]:g} m'
        return PlanRecord(exact(stated_m, ScaleSource.LENGTH, why))
    found = recorded(path, cell_m) if options.resolution_m is None else None
    if found is not None:
        return found
    by = '--resolution' if options.resolution_m else path.name
    return PlanRecord(exact(cell_m, ScaleSource.STATED, f'stated by {by}'))


def _reject_options(path: Path, options: ReadOptions) -> None:
    """Reject options that would change a map_server map."""
    for name in ('storey', 'page', 'layers'):
        if getattr(options, name):
            raise MapFormatError(
                f'{path} is a map_server map, which is used as it is: {name} does not apply; '
                'give the drawing that it was made from'
            )


def read_drawing(drawing: Drawing, options: ReadOptions, config: SegmentationConfig) -> Reading:
    """
    Parse an opened drawing; see :func:`read_plan`.

    Raises
    ------
    MapFormatError
        If an option does not fit the drawing, or it shows no building.
    """
    _check_options(drawing, options)
    stated = model_reading(drawing, options)
    if stated is not None:
        return replace(stated, config=config)
    options = options_of_copy(options, drawing)
    found = without_thin_lines(find_building(drawing, options, config), config)
    scale, cell_m = resolve_scale(found, config)
    grid = GridMap(found.cells[::-1], cell_m)
    metres = cell_m * stride(found.cells) / found.segmentation.grid.resolution
    doubts = _doubts(found, config, metres if scale.is_known else None)
    H_plan_image = pixel_to_xy(grid).matrix @ found.H_cell_pixel
    reading = Reading(
        grid=grid,
        scale=scale,
        H_plan_image=H_plan_image,
        how=found.how,
        drawing=drawing,
        storeys=found.storeys,
        notes=(*drawing.notes, *_notes(found, options), *_pixel_notes(drawing, options)),
        doubts=(*drawing.doubts, *doubts.reasons),
        doubtful=doubts.places,
        model=placed_model(drawing, grid, H_plan_image),
        is_other=doubts.is_other,
        config=config,
        cut=found.cut_at(grid),
    )
    return in_image_pixels(reading)


def _doubts(
    found: PlanHypothesis, config: SegmentationConfig, metres_per_unit: float | None
) -> Doubts:
    """Return the parser warnings, without findings that a stated scale refutes."""
    thought = doubts_of(found, config)
    if not found.segmentation.rooms:
        return thought
    without_scale = findings(found.segmentation)
    absurd = findings(found.segmentation, metres_per_unit)
    reasons = [each for each in thought.reasons if each not in without_scale or each in absurd]
    return replace(thought, reasons=tuple(reasons))


def _notes(found: PlanHypothesis, options: ReadOptions) -> list[str]:
    notes = []
    if found.is_straightened:
        notes.append('Rotation or perspective of the sheet was corrected.')
    if found.seen is not None and len(found.storeys) > 1 and options.storey is None:
        notes.append(
            f'The sheet shows {len(found.storeys)} buildings or storeys; number '
            f'{found.seen.chosen + 1}, the largest, was used. Choose another one with --storey.'
        )
    return notes


def _pixel_notes(drawing: Drawing, options: ReadOptions) -> list[str]:
    """Return a note on the pixels of a vector drawing if the user's options count pixels."""
    if drawing.strokes is None or not (options.resolution_m or options.length or options.crop):
        return []
    height, width = drawing.pixels.shape[:2]
    per_unit = float(scale_of(drawing.A_pixel_image[:, :2]))
    return [
        f'Pixels are those of the {width} x {height} image rendered from the '
        f'{drawing.format.upper()}, {per_unit:.4g} per unit of the file: give --resolution, '
        '--length and --crop in these pixels.'
    ]


def _check_options(drawing: Drawing, options: ReadOptions) -> None:
    if options.crop is not None:
        check_crop(options.crop, drawing.size, drawing.name)
    stated_m = options.resolution_m
    if options.length is not None:
        stated_m = _metres_per_pixel(options.length, drawing.name, drawing.size[::-1])
    if stated_m is not None:
        _check_size(drawing, stated_m)


def _check_size(drawing: Drawing, resolution_m: float) -> None:
    """Reject a scale at which the drawing has an implausible size, e.g. one in millimetres."""
    long_m = max(drawing.size) * resolution_m
    if not _LONG_M[0] <= long_m <= _LONG_M[1]:
        raise MapFormatError(
            f'{drawing.name}: at {resolution_m:.3g} m per pixel the drawing is {long_m:.3g} m '
            'long, implausible for a building; give the metres of one pixel or of a length'
        )


def _metres_per_pixel(length: Length, name: str, shape: tuple[int, ...]) -> float:
    """Return metres per pixel from a length between two points."""
    x1, y1, x2, y2, metres = length
    height, width = shape
    # The far edges are valid: users may count from 1, or to the outer edge of a pixel.
    if not (
        0.0 <= min(x1, x2) <= max(x1, x2) <= width and 0.0 <= min(y1, y2) <= max(y1, y2) <= height
    ):
        raise MapFormatError(
            f'{name}: length {length} lies outside the drawing; expected both points within 0, 0, '
            f'{width}, {height} pixels'
        )
    if not (0.0 < metres < np.inf and np.hypot(x2 - x1, y2 - y1) >= 1.0):
        raise MapFormatError(
            f'length {length}: expected two points in pixels and a positive distance in metres '
            'between them'
        )
    return metres / float(np.hypot(x2 - x1, y2 - y1))
