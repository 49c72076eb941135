# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""All ways to read a drawing that are worth a try, each cut into rooms and judged by them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.building import cells_of, inside_of_lines, reduced
from fpnet_core.drawings.plausible import features
from fpnet_core.drawings.sheet import NoBuildingError, Sheet, find_building, margin_around
from fpnet_core.drawings.strokes import Mask, Recipe, recipes
from fpnet_core.drawings.tones import inks
from fpnet_core.drawings.types import Array
from fpnet_core.drawings.view import View, shrinking
from fpnet_core.errors import MapFormatError
from fpnet_core.io import pixel_to_xy
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import FREE, GridMap, Segmentation

NOMINAL_M = 0.05
"""Edge of a cell where nothing is known of the scale; every figure is a ratio then."""

_ROUNDS = 2  # of scale and segmentation: enough to compare readings
_SHEET_TONES = 2  # are looked at: the darkest and the faintest
_MOST = 0.8  # of the largest building that any tone shows is the building
_LEAST_SHARE = 0.3  # of what all lines enclose is rooms
_SAME = 0.06  # of the walls differ between readings that are one
_LOOK_PX = 600  # the longer side of a building that is read to be judged


@dataclass(frozen=True, eq=False)
class Candidate:
    """
    One reading: its recipe, where the building is, and the rooms that come out.

    ``view`` and ``belongs (H, W)`` are of the building, ``sheet_view`` and ``sheet`` of all.
    """

    recipe: Recipe
    view: View
    sheet_view: View
    belongs: Mask
    sheet: Sheet
    segmentation: Segmentation
    features: Array

    @property
    def H_plan_pixel(self) -> Array:
        """Map (3, 3) from the drawing's pixels to nominal metres of the segmentation."""
        grid = self.segmentation.grid
        rows, cols = grid.shape
        height, width = self.view.levels.shape
        H_look_view = shrinking((cols / width, rows / height))
        return np.asarray(pixel_to_xy(grid).matrix @ H_look_view @ self.view.H_view_pixel)


def candidates(view: View, storey: int | None, config: SegmentationConfig) -> Iterator[Candidate]:
    """Read a view in all ways; ways in which nothing is enclosed are left out."""
    sheet = _sheet(view, storey)
    if sheet is None:
        return
    box = margin_around(sheet.boxes[sheet.chosen], view.levels.shape)
    left, top, right, bottom = box
    part = view.cropped(box)
    belongs = sheet.belongs[top:bottom, left:right]
    factor = max(part.levels.shape) / _LOOK_PX
    levels = np.where(belongs, part.levels, 0).astype(np.uint8)
    seen: list[Mask] = []
    grounds: dict[float, Mask | None] = {}
    for recipe in recipes(levels):
        walls = reduced(recipe.walls(levels), factor)
        if not _is_new(walls, seen):
            continue
        seen.append(walls)
        if recipe.level not in grounds:
            grounds[recipe.level] = inside_of_lines(reduced(levels > recipe.level, factor))
        ground = grounds[recipe.level]
        cells = cells_of(walls, ground)
        if cells is None or not _is_filled(cells, ground):
            continue
        grid = GridMap(cells[::-1], NOMINAL_M)
        segmentation, _ = segment_unknown_scale(grid, config, _ROUNDS)
        figures = features(segmentation)
        yield Candidate(recipe, part, view, belongs, sheet, segmentation, figures)


def _is_filled(cells: NDArray[np.int8], ground: Mask | None) -> bool:
    """Tell whether what walls enclose is not far less than what all lines do."""
    free = np.count_nonzero(cells == FREE)
    return ground is None or bool(free > _LEAST_SHARE * np.count_nonzero(ground))


def _is_new(walls: Mask, seen: list[Mask]) -> bool:
    """Tell whether no earlier reading has nearly the same walls."""
    ink = np.count_nonzero(walls)
    return bool(ink) and all(np.count_nonzero(walls ^ other) > _SAME * ink for other in seen)


def _sheet(view: View, storey: int | None) -> Sheet | None:
    """
    Return the sheet as seen by its darkest tone that shows the building; None where none does.

    Contours of the ground, trees and furniture are drawn lighter than walls, if at all.
    """
    found: list[Sheet] = []
    no_storey: MapFormatError | None = None
    tones = sorted(inks(view.levels), key=lambda tone: -tone.level)
    for tone in tones[:1] + tones[1:][-1:] if len(tones) > _SHEET_TONES else tones:
        try:
            found.append(find_building(view.levels > tone.level, storey))
        except NoBuildingError:
            continue
        except MapFormatError as error:
            no_storey = error
    if not found and no_storey is not None:
        raise no_storey
    most = max((sheet.worth for sheet in found), default=0.0)
    return next((sheet for sheet in found if sheet.worth >= _MOST * most), None)
