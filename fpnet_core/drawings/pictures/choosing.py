# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The choice between readings: what a histogram reads well, else what the network sees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.doubting import Doubts, doubts_of, is_believed
from fpnet_core.drawings.pictures.found import NOMINAL_M, Found, likelihood, rooms_of, stride
from fpnet_core.drawings.pictures.learned import SeenBuilding, see_building
from fpnet_core.drawings.pictures.looking import view_reading
from fpnet_core.drawings.pictures.plain import best_plain, is_lettered, plain_reading
from fpnet_core.drawings.pictures.sheet import FRAME, find_building
from fpnet_core.drawings.pictures.thin_lines import without_thin_lines
from fpnet_core.drawings.pictures.tones import Levels, ink_level, is_dark_ground
from fpnet_core.drawings.pictures.view import View, on_paper, view_of
from fpnet_core.drawings.stated import UNSAID, SaidScale
from fpnet_core.drawings.types import Array, Box, Drawing, Dropped, ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.raster.blocks import unblocked
from fpnet_core.raster.morphology import closed, grown
from fpnet_core.raster.pieces import filled, looked_up, pieces_of
from fpnet_core.raster.pixels import map_points
from fpnet_core.raster.windows import EVERY_SIDE, border_of
from fpnet_core.segmentation.doorsills import doorway_symbols
from fpnet_core.segmentation.scale import estimate_metres_per_unit
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, Segmentation

# Chosen, not measured:
_SURE = 0.7  # a reading so plausible is taken without a look at others
_SYMBOL_EDGE_PX = 2  # so far around a door's symbols the network takes them for walls
_SEEN_SHARE = 0.25  # of a space was seen as a room
# The ground before an entrance has no walls around so much of it, and is as small beside rooms, or
# it has none to speak of.
_BARE_SHARE, _COURT_SHARE, _OPEN_SHARE = 0.4, 0.6, 0.8
_GAP_DOORS = 2.0  # widths of doors are gaps in outer walls


def choose(drawing: Drawing, options: ReadOptions, config: SegmentationConfig) -> Found:
    """
    Return the reading of ``drawing`` that looks most like a building.

    Raises
    ------
    MapFormatError
        If no reading shows one.
    """
    return without_thin_lines(_with_all_lines(drawing, options, config), config)


def _with_all_lines(drawing: Drawing, options: ReadOptions, config: SegmentationConfig) -> Found:
    said, pictures = SaidScale.of(drawing, options), _pictures(drawing.pixels)
    plain = None if options.storey else best_plain(pictures, options, config, said)
    if plain is not None and _is_sure(plain) and not is_lettered(plain, pictures[0]):
        return plain
    known = [plain] if plain is not None else []
    for picture in pictures:
        seen = _seen(picture, options, config, said)
        known += [seen] if seen is not None else []
        if seen is not None and _is_sure(seen):
            break
    if not known:
        raise MapFormatError(
            f'{drawing.name} shows no building: no lines enclose rooms; expected a floorplan '
            f'with walls that stand out from the paper{"".join(f"; {n}" for n in drawing.notes)}'
        )
    return _likeliest(known, plain, drawing, config)


def _likeliest(
    known: list[Found], plain: Found | None, drawing: Drawing, config: SegmentationConfig
) -> Found:
    """Return the reading most like a building, a plain one by its rooms; absurd ones are last."""
    kept = [reading for reading in known if not reading.is_absurd] or known
    if len(kept) > 1 and plain is not None and plain in kept:
        first = _judged(plain, known, drawing, config)
        if _is_sure(plain) and first.thought and is_believed(first.thought):
            return first
        others = [reading for reading in kept if reading is not plain]
        judged = [first, *(_judged(reading, known, drawing, config) for reading in others)]
        return min(judged, key=lambda reading: reading.thought.wrong if reading.thought else 1.0)
    found = max(kept, key=lambda reading: reading.probability)
    return _with_rivals(found, known)


def _with_rivals(found: Found, known: list[Found]) -> Found:
    others = tuple(reading.as_rival for reading in known if reading is not found)
    return replace(found, rivals=(*found.rivals, *others))


def _judged(
    found: Found, known: list[Found], drawing: Drawing, config: SegmentationConfig
) -> Found:
    """Return a reading with its rivals and with what is thought of it."""
    found = _with_rivals(found, known)
    return replace(found, thought=thought_of(found, drawing, config))


def thought_of(found: Found, drawing: Drawing, config: SegmentationConfig) -> Doubts:
    """Return whether to believe a reading."""
    if found.thought is not None:
        return found.thought
    look = view_reading(
        drawing.pixels,
        found.segmentation,
        found.H_plan_pixel,
        found.probability,
        found.rivals,
        config,
        found.trust,
        found.known_factor,
    )
    return doubts_of(look)


def _is_sure(reading: Found) -> bool:
    return reading.probability > _SURE and not reading.is_absurd


def all_readings(
    pixels: Levels, options: ReadOptions, config: SegmentationConfig
) -> Iterator[tuple[Segmentation, Array]]:
    """
    Read pixels (H, W, 3) in every way that :func:`choose` may choose from.

    Yields the rooms in nominal metres and the map (3, 3) from pixels to those.
    """
    for picture in _pictures(pixels):
        plain = plain_reading(picture, options, config, UNSAID)
        if plain is not None:
            yield plain.segmentation, plain.H_plan_pixel
        seen = _seen(picture, options, config, UNSAID)
        if seen is not None:
            yield seen.segmentation, seen.H_plan_pixel


def _pictures(pixels: Levels) -> list[Levels]:
    """Return the pixels, of light lines on dark ground first with both exchanged."""
    return [255 - pixels, pixels] if is_dark_ground(pixels) else [pixels]


def _seen(
    pixels: Levels, options: ReadOptions, config: SegmentationConfig, said: SaidScale
) -> Found | None:
    """Return the reading by the network; None where it sees no building."""
    part, H_part_pixel = on_paper(pixels, options.crop)
    view = view_of(part)
    seen = see_building(view, options.storey)
    if seen is None:
        return None
    seen = replace(seen, H_cell_pixel=seen.H_cell_pixel @ H_part_pixel)
    found = _with_doorways(_of_cells(seen.cells, seen, config, said), seen, config)
    found = _without_forecourts(found, config)
    rough = _of_cells(seen.rough_cells, seen, config, said)
    to_pixel = np.asarray(np.linalg.inv(view.H_view_pixel @ H_part_pixel), np.float64)
    return replace(
        found,
        storeys=tuple(_boxed(to_pixel, box) for box in seen.boxes),
        chosen=seen.chosen,
        dropped=tuple(Dropped(d.what, _boxed(to_pixel, d.box)) for d in _beside(view, seen)),
        is_straightened=view.is_straightened,
        trust=seen.trust,
        rivals=(rough.as_rival,),
    )


def _of_cells(
    cells: NDArray[np.int8], seen: SeenBuilding, config: SegmentationConfig, said: SaidScale
) -> Found:
    cell_m = said.cell_m(seen.H_cell_pixel, cells.shape)
    segmentation, _ = rooms_of(cells, NOMINAL_M, config, cell_m and cell_m / NOMINAL_M)
    how = 'walls as learned from drawings'
    return Found(cells, seen.H_cell_pixel, segmentation, likelihood(segmentation), how, said)


def _with_doorways(found: Found, seen: SeenBuilding, config: SegmentationConfig) -> Found:
    """
    Return a reading whose walls are open where the drawing shows but a door's symbols.

    A space that walls shut in, and that was seen as a room in part, is one if a door leads there.
    """
    factors = _likely_factors(found)
    walls = seen.cells == OCCUPIED
    spaces, count = pieces_of(~walls, connectivity=4)
    size = np.bincount(spaces.ravel(), minlength=len(count))
    free = np.bincount(spaces[seen.cells == FREE], minlength=len(count))
    is_room = free > _SEEN_SHARE * size
    is_room[np.unique(border_of(spaces))] = False
    room = (seen.cells == FREE) | looked_up(spaces, is_room)
    shown = [doorway_symbols(seen.ink, room, NOMINAL_M * factor) for factor in factors]
    symbols = grown(np.logical_or.reduce(shown), _SYMBOL_EDGE_PX)
    if not symbols.any():
        return found
    is_room &= np.bincount(spaces[symbols], minlength=len(count)) > 0
    is_free = looked_up(spaces, is_room) | (symbols & walls)
    return found.with_cells(np.where(is_free, FREE, seen.cells).astype(np.int8), config)


def _likely_factors(found: Found) -> tuple[float, ...]:
    """Return what true metres of a nominal one may be."""
    known = found.known_factor
    if known is not None:
        return (known,)
    scale = estimate_metres_per_unit(found.segmentation)
    # Where all doors are shut rooms alone tell the scale, and doorways may be half as wide.
    return (scale.factor,) if found.segmentation.portals else (scale.factor, scale.low)


def _without_forecourts(found: Found, config: SegmentationConfig) -> Found:
    """Return a reading without ground that walls do not shut in."""
    labels = found.segmentation.labels
    cells = found.segmentation.grid.cells
    size = np.bincount(labels.ravel())
    ends, bare = np.zeros(len(size)), np.zeros(len(size))
    for here, there in EVERY_SIDE:
        edge = (labels[here] > 0) & (labels[there] != labels[here])
        ends += np.bincount(labels[here][edge], minlength=len(size))
        edge &= cells[there] == UNKNOWN
        bare += np.bincount(labels[here][edge], minlength=len(size))
    within = np.bincount(labels[_within_walls(found.segmentation)], minlength=len(size))
    is_small = size < _COURT_SHARE * np.median(size[1:])
    goes_on = np.isin(np.arange(len(size)), border_of(labels))
    is_court = bare > np.where(is_small | goes_on, _BARE_SHARE, _OPEN_SHARE) * ends
    # A room that was seen in part has no walls all around either, but lies within the building's.
    is_court &= within < _BARE_SHARE * size
    is_court[0] = False
    if not is_court.any():
        return found
    gone = unblocked(is_court[labels[::-1]], stride(found.cells), found.cells.shape)
    return found.with_cells(np.where(gone, UNKNOWN, found.cells).astype(np.int8), config)


def _within_walls(segmentation: Segmentation) -> NDArray[np.bool_]:
    """Return what (H, W) the walls shut in once gaps of twice a door's width are closed."""
    walls = segmentation.grid.cells == OCCUPIED
    widths = [portal.width_m for portal in segmentation.portals]
    if not widths:
        return np.ones_like(walls)
    by = round(_GAP_DOORS * float(np.median(widths)) / segmentation.grid.resolution)
    return filled(closed(np.pad(walls, by), 2 * (by // 2) + 1))[by:-by, by:-by]


def _beside(view: View, seen: SeenBuilding) -> list[Dropped]:
    """Return what lines show beside the buildings, as far as its shape tells what it is."""
    level = ink_level(view.levels)
    try:
        found = () if level is None else find_building(view.levels > level).dropped
    except MapFormatError:
        return []
    return [d for d in found if d.what == FRAME or not any(_meets(d.box, b) for b in seen.boxes)]


def _meets(one: Box, other: Box) -> bool:
    """Tell whether the middle of a box lies in another one."""
    x, y = (one[0] + one[2]) / 2.0, (one[1] + one[3]) / 2.0
    return other[0] <= x <= other[2] and other[1] <= y <= other[3]


def _boxed(H: Array, box: Box) -> Box:
    """Return the box around ``box`` mapped by ``H``."""
    left, top, right, bottom = box
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], float)
    mapped = map_points(H, corners)
    first, last = np.rint(mapped.min(axis=0)).astype(int), np.rint(mapped.max(axis=0)).astype(int)
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])
