# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""All ways to read a drawing that are worth a try, each cut into rooms and judged by them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.building import cells_of, reduced
from fpnet_core.drawings.plausible import features
from fpnet_core.drawings.sheet import Sheet, find_building, margin_around
from fpnet_core.drawings.strokes import Mask, Recipe, recipes
from fpnet_core.drawings.tones import inks
from fpnet_core.drawings.types import Array
from fpnet_core.drawings.view import View
from fpnet_core.errors import MapFormatError
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import GridMap, Segmentation

NOMINAL_M = 0.05
"""Edge of a cell where nothing is known of the scale; every figure is a ratio then."""

_ROUNDS = 2  # of scale and segmentation: enough to compare readings
_LOOK_PX = 640  # the longer side of a building that is read to be judged


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


def candidates(view: View, storey: int | None, config: SegmentationConfig) -> Iterator[Candidate]:
    """Read a view in all ways; ways in which nothing is enclosed are left out."""
    sheet = _sheet(view, storey)
    if sheet is None:
        return
    box = margin_around(sheet.boxes[sheet.chosen], view.levels.shape)
    left, top, right, bottom = box
    part = view.cropped(box)
    belongs = sheet.belongs[top:bottom, left:right]
    for recipe in recipes(np.where(belongs, part.levels, 0).astype(np.uint8)):
        walls = recipe.walls(part.levels) & belongs
        factor = max(walls.shape) / _LOOK_PX
        ink = (part.levels > recipe.level) & belongs
        cells = cells_of(reduced(walls, factor), reduced(ink, factor))
        if cells is None:
            continue
        segmentation, _ = segment_unknown_scale(GridMap(cells[::-1], NOMINAL_M), config, _ROUNDS)
        yield Candidate(recipe, part, view, belongs, sheet, segmentation, features(segmentation))


def _sheet(view: View, storey: int | None) -> Sheet | None:
    """Return the sheet as seen by the first tone that shows a building; None where none does."""
    for tone in inks(view.levels):
        try:
            return find_building(view.levels > tone.level, storey)
        except MapFormatError:
            continue
    return None
