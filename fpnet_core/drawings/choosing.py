# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The choice between readings: what today's rules read well, else the most plausible way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.building import cells_of, inside_of_lines
from fpnet_core.drawings.candidates import NOMINAL_M, Candidate, candidates
from fpnet_core.drawings.looking import Rival
from fpnet_core.drawings.plausible import features, probability
from fpnet_core.drawings.sheet import find_building
from fpnet_core.drawings.straighten import map_points
from fpnet_core.drawings.tones import Levels, is_dark_ground
from fpnet_core.drawings.types import Array, Drawing, Dropped, ReadOptions
from fpnet_core.drawings.view import View, shrinking, view_of
from fpnet_core.errors import MapFormatError
from fpnet_core.io import pixel_to_xy
from fpnet_core.io.images import interpret
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Segmentation

Box = tuple[int, int, int, int]

_FINAL_PX = 1600  # the longer side of a building in cells, where the drawing has that many
_SURE = 0.93  # a reading so plausible is taken without a look at others
_PLAIN_SURE = 0.7  # and so a plain one, which has nothing to drop
_PLAIN_ODDS = 10.0  # before its rooms are looked at: clean pictures mostly mean what they show
_MAX_PLAIN_PX = 6_000_000  # larger pictures are sheets
_COLOURED = 24  # levels between channels that a scanner's noise does not make
_COLOUR_SHARE = 2e-3  # of a picture has colour
_KEPT = 0.5  # of its plausibility must be left to a reading that is made finer
_JUDGED_PX = 1200  # the longer side of a picture in which a plain reading is judged
_ROUNDS = 2  # of scale and segmentation: enough to judge
_SAME_SCALE = 0.2  # in its logarithm, within which a picture means the same


@dataclass(frozen=True, eq=False)
class Found:
    """
    The reading that was chosen.

    ``cells (H, W)`` with row 0 at the top; ``H_cell_pixel (3, 3)`` maps the drawing's pixels to
    them; ``segmentation`` has cells of :data:`NOMINAL_M` and may be coarser. ``storeys`` and
    ``dropped`` are in the drawing's pixels; ``rivals`` are the other readings that were tried.
    """

    cells: NDArray[np.int8]
    H_cell_pixel: Array
    segmentation: Segmentation
    probability: float
    how: str
    storeys: tuple[Box, ...] = ()
    chosen: int = 0
    dropped: tuple[Dropped, ...] = ()
    is_straightened: bool = False
    rivals: tuple[Rival, ...] = ()

    @property
    def H_plan_pixel(self) -> Array:
        """Map (3, 3) from the drawing's pixels to nominal metres of the segmentation."""
        stride = _stride(self.cells)
        to_plan = pixel_to_xy(self.segmentation.grid).matrix
        return np.asarray(to_plan @ shrinking(1.0 / stride) @ self.H_cell_pixel)


def choose(drawing: Drawing, options: ReadOptions, config: SegmentationConfig) -> Found:
    """
    Return the reading of ``drawing`` that looks most like a building.

    Raises
    ------
    MapFormatError
        If no reading shows one.
    """
    pictures = _pictures(drawing.pixels)
    plain = None if options.storey else _best_plain(pictures, options, config)
    if plain is not None and plain.probability > _PLAIN_SURE:
        return plain
    tried: list[tuple[Candidate, float]] = []
    for picture in pictures:
        tried += _tried(picture, options, config)
        if any(chance > _PLAIN_SURE for _, chance in tried):
            break
    found = max(tried, key=lambda each: each[1], default=None)
    if plain is not None and (found is None or plain.probability >= found[1]):
        return replace(plain, rivals=_rivals(tried))
    if found is None:
        raise MapFormatError(
            f'{drawing.name} shows no building: no lines enclose rooms; expected a floorplan '
            'with walls that stand out from the paper'
        )
    others = _rivals([each for each in tried if each is not found])
    return replace(_finished(*found, config), rivals=others)


def all_readings(
    pixels: Levels, options: ReadOptions, config: SegmentationConfig
) -> Iterator[tuple[Segmentation, Array]]:
    """
    Read pixels (H, W, 3) in every way that :func:`choose` may choose from.

    Yields the rooms in nominal metres and the map (3, 3) from pixels to those.
    """
    for picture in _pictures(pixels):
        plain = _plain(picture, options, config)
        if plain is not None:
            yield plain.segmentation, plain.H_plan_pixel
        for candidate in candidates(view_of(picture, options.crop), options.storey, config):
            yield candidate.segmentation, candidate.H_plan_pixel


def _pictures(pixels: Levels) -> list[Levels]:
    """Return the pixels, of light lines on dark ground first with both exchanged."""
    return [255 - pixels, pixels] if is_dark_ground(pixels) else [pixels]


def _best_plain(
    pictures: list[Levels], options: ReadOptions, config: SegmentationConfig
) -> Found | None:
    found = (_plain(picture, options, config) for picture in pictures)
    known = [plain for plain in found if plain is not None]
    return max(known, key=lambda plain: plain.probability, default=None)


def _tried(
    pixels: Levels, options: ReadOptions, config: SegmentationConfig
) -> list[tuple[Candidate, float]]:
    """Return readings and how plausible they are, the last one surely if any is."""
    found = []
    for candidate in candidates(view_of(pixels, options.crop), options.storey, config):
        found.append((candidate, probability(candidate.features)))
        if found[-1][1] > _SURE:
            break
    return found


def _rivals(tried: list[tuple[Candidate, float]]) -> tuple[Rival, ...]:
    return tuple(
        Rival(candidate.segmentation, candidate.H_plan_pixel, chance)
        for candidate, chance in tried
    )


def _finished(candidate: Candidate, chance: float, config: SegmentationConfig) -> Found:
    """
    Return a candidate of this ``chance`` as finely as it is drawn, where that is as plausible.

    Raises
    ------
    MapFormatError
        If nothing is closed at either size.
    """
    found = _at(candidate, *candidate.view.finer(_FINAL_PX), config)
    if found is None or found.probability < _KEPT * chance:
        found = _at(candidate, candidate.view, 1.0, config) or found
    if found is None:
        raise MapFormatError('the drawing shows no building that is closed')
    return found


def _at(
    candidate: Candidate, view: View, factor: float, config: SegmentationConfig
) -> Found | None:
    """Return a candidate read in a ``view`` that is larger by ``factor``; None if it is open."""
    recipe = candidate.recipe.scaled(factor)
    size = (view.levels.shape[1], view.levels.shape[0])
    near = candidate.belongs.astype(np.uint8)
    belongs = cv2.resize(near, size, interpolation=cv2.INTER_NEAREST) > 0
    levels = np.where(belongs, view.levels, 0).astype(np.uint8)
    cells = cells_of(recipe.walls(levels), inside_of_lines(levels > recipe.level))
    if cells is None:
        return None
    segmentation, _ = _rooms_of(cells, NOMINAL_M, config)
    sheet = candidate.sheet
    to_pixel = np.asarray(np.linalg.inv(candidate.sheet_view.H_view_pixel), np.float64)
    return Found(
        cells=cells,
        H_cell_pixel=view.H_view_pixel,
        segmentation=segmentation,
        probability=probability(features(segmentation)),
        how=recipe.how,
        storeys=tuple(_boxed(to_pixel, box) for box in sheet.boxes),
        chosen=sheet.chosen,
        dropped=tuple(Dropped(d.what, _boxed(to_pixel, d.box)) for d in sheet.dropped),
        is_straightened=view.is_straightened,
    )


def _boxed(H: Array, box: Box) -> Box:
    """Return the box around ``box`` mapped by ``H``."""
    left, top, right, bottom = box
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], float)
    mapped = map_points(H, corners)
    first, last = np.rint(mapped.min(axis=0)).astype(int), np.rint(mapped.max(axis=0)).astype(int)
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])


def _plain(pixels: Levels, options: ReadOptions, config: SegmentationConfig) -> Found | None:
    """Return what :func:`fpnet_core.io.images.interpret` reads, of a picture without a sheet."""
    left, top, right, bottom = options.crop or (0, 0, *pixels.shape[1::-1])
    grey = _grey(pixels[top:bottom, left:right])
    if grey is None:
        return None
    try:
        cells = interpret(grey, options.resolution_m or NOMINAL_M)
        sheet = find_building(cells == OCCUPIED)
    except MapFormatError:
        return None
    box = sheet.boxes[sheet.chosen]
    if len(sheet.boxes) > 1 or any(not _is_within(d.box, box) for d in sheet.dropped):
        return None
    segmentation, factor = _rooms_of(cells, options.resolution_m or NOMINAL_M, config)
    if options.resolution_m is None and abs(np.log(factor)) > _SAME_SCALE:
        cells = interpret(grey, NOMINAL_M * factor)
        segmentation, _ = _rooms_of(cells, NOMINAL_M * factor, config)
    H = np.array([[1.0, 0.0, -left], [0.0, 1.0, -top], [0.0, 0.0, 1.0]])
    chance = _PLAIN_ODDS * probability(features(segmentation))
    chance /= chance + 1.0 - chance / _PLAIN_ODDS
    return Found(cells, H, segmentation, chance, 'a clean drawing or robot map')


def _rooms_of(
    cells: NDArray[np.int8], cell_m: float, config: SegmentationConfig
) -> tuple[Segmentation, float]:
    """Return the rooms of cells, seen as coarsely as does, and true metres per nominal one."""
    stride = _stride(cells)
    rows, cols = (-(-side // stride) for side in cells.shape)
    padded = np.full((rows * stride, cols * stride), UNKNOWN, dtype=np.int8)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    blocks = padded.reshape(rows, stride, cols, stride)
    wall, free = (blocks == OCCUPIED).any(axis=(1, 3)), (blocks == FREE).all(axis=(1, 3))
    coarse = np.select([wall, free], [OCCUPIED, FREE], UNKNOWN).astype(np.int8)
    grid = GridMap(coarse[::-1], cell_m * stride)
    segmentation, scale = segment_unknown_scale(grid, config, _ROUNDS)
    return segmentation, scale.factor


def _stride(cells: NDArray[np.int8]) -> int:
    """Return how many cells (H, W) of a reading are one of those that it is judged by."""
    rows, cols = cells.shape
    return int(-(-max(rows, cols) // _JUDGED_PX))


def _grey(pixels: Levels) -> Levels | None:
    """Return the grey levels (H, W) of a picture of modest size; None if it has colours."""
    if pixels.shape[0] * pixels.shape[1] > _MAX_PLAIN_PX:
        return None
    if (np.ptp(pixels, axis=2) > _COLOURED).mean() > _COLOUR_SHARE:
        return None
    weights = np.array([0.299, 0.587, 0.114], dtype=np.float32)
    return np.asarray(np.rint(pixels.astype(np.float32) @ weights), dtype=np.uint8)


def _is_within(inner: Box, outer: Box) -> bool:
    return (
        inner[0] >= outer[0]
        and inner[1] >= outer[1]
        and inner[2] <= outer[2]
        and inner[3] <= outer[3]
    )
