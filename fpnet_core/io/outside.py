# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detection of the space outside the building, for map readers and for segmentation."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_any, unblocked
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import cross, grown_by, spread
from fpnet_core.raster.pieces import looked_up, pieces_of
from fpnet_core.raster.windows import border_of
from fpnet_core.types import FREE, UNKNOWN

Mask = NDArray[np.bool_]

_CORE = 2  # numerical: label of the pixels that the flood fill from the corner reaches
# Numerical: gates are metres wide, so finer images are downsampled to blocks of this size [m],
# but to no fewer blocks along a side: then the stated scale must be wrong.
_BLOCK_M, _LEAST_BLOCKS = 0.05, 200
# Chosen, not measured:
# Gates, open ends of corridors and gaps up to this width separate the inside from the outside. An
# open entrance or its porch is at most half as wide; a wider opening is a gate.
_EXIT_WIDTH_M = 4.5
_PAPER_BORDER_SHARE = 0.5  # least free share of the border if the outside is white
_NECK = 1.2  # a part this many times as wide as its entrance is a hall, not a niche
_MIN_INSIDE_SHARE = 0.05  # of the free space; with less inside, the building is not closed


def is_on_paper(free: Mask) -> bool:
    """Return whether the outside is drawn as free space: most of the border is free."""
    return bool(border_of(free).mean() > _PAPER_BORDER_SHARE)


def interior(free: Mask) -> Mask:
    """Return ``free (H, W)`` without the components that touch the border of a drawing."""
    if not is_on_paper(free):
        return free
    pieces, figures = pieces_of(free, connectivity=4)
    is_inside = np.ones(len(figures), dtype=np.bool_)
    is_inside[np.unique(border_of(pieces))] = False
    return np.asarray(free & is_inside[pieces])


def outside_as_unknown(cells: NDArray[np.int8], resolution_m: float) -> NDArray[np.int8]:
    """
    Return ``cells (H, W)`` with the free space around a building set to unknown.

    Drawings are often on white paper. Cells are outside if they are reachable from the border
    through openings wider than ``_EXIT_WIDTH_M``. Returns ``cells`` unchanged if the border is
    not mostly free, or if the building is so open that almost no inside would be left.
    """
    free = cells == FREE
    if border_of(free).mean() < _PAPER_BORDER_SHARE:
        return cells
    step = max(1, min(int(_BLOCK_M / resolution_m), min(free.shape) // _LEAST_BLOCKS))
    coarse = ~block_any(~free, step)
    # The disc is never larger than the image, even if the stated scale is wrong.
    reach_px = min(0.5 * _EXIT_WIDTH_M / (step * resolution_m), max(coarse.shape))
    inside = _inside_of(coarse, reach_px)
    if inside is None or np.count_nonzero(inside) < _MIN_INSIDE_SHARE * np.count_nonzero(coarse):
        return cells
    result = cells.copy()
    result[_outside_of(free, coarse, inside, step)] = UNKNOWN
    return result


def _outside_of(free: Mask, coarse: Mask, inside: Mask, step: int) -> Mask:
    """Return the outside of ``free (H, W)``, upsampled from its blocks ``(h, w)``."""
    if step == 1:
        return free & ~inside
    sides = 2 * coarse.view(np.uint8) - inside
    return np.asarray(spread(unblocked(sides, step, free.shape), free, cross(), step) == 2)


def _inside_of(free: Mask, reach_px: float) -> Mask | None:
    """
    Return the part of ``free (H, W)`` that a disc of ``reach_px`` cannot reach from outside.

    None if the disc does not fit beside the building. Niches of the outer wall are outside.
    """
    # One free pixel all around connects areas that walls at the image's edge separate.
    padded = np.pad(free, 1, constant_values=True)
    blocked = ~np.pad(padded, int(reach_px) + 1, mode='edge')
    clearance = cells_to_nearest(blocked, most=reach_px)
    core = (clearance > reach_px).astype(np.uint8)
    if core[0, 0] == 0:
        return None
    cv2.floodFill(core, None, (0, 0), _CORE)  # 4-connected
    margin = int(reach_px) + 2
    to_core = cells_to_nearest(core == _CORE, most=reach_px + 1.0)
    outside = to_core[margin:-margin, margin:-margin] <= reach_px + 1.0
    inside = free & ~outside
    return inside & ~_niches(
        inside, free & outside, clearance[margin:-margin, margin:-margin], reach_px
    )


def _niches(inside: Mask, outside: Mask, clearance: NDArray[np.float32], reach_px: float) -> Mask:
    """
    Return the niches of the outer wall: parts open to the outside, too narrow for a room.

    A part whose widest place lies behind a narrower neck is not a niche but a hall behind an open
    entrance, unless its gates together are wider than ``2 * reach_px``: then the building is open.
    """
    pieces, figures = pieces_of(inside, connectivity=4)
    mouths = grown_by(outside, cross()) & inside
    is_niche = np.zeros(len(figures), dtype=np.bool_)
    is_niche[pieces[mouths]] = True
    is_niche[pieces[(clearance > reach_px) & inside]] = False
    niches = looked_up(pieces, is_niche)
    widest = np.zeros(len(figures), dtype=np.float32)
    np.maximum.at(widest, pieces[niches], clearance[niches])
    wide = niches & (_NECK * clearance > looked_up(pieces, widest))
    places, found = pieces_of(wide, connectivity=4)
    is_behind = np.ones(len(found), dtype=np.bool_)
    is_behind[places[mouths]] = is_behind[0] = False
    is_hall = np.zeros(len(figures), dtype=np.bool_)
    is_hall[pieces[looked_up(places, is_behind)]] = True
    is_hall &= _gates_px(pieces, mouths, len(figures), reach_px) <= 2.0 * reach_px
    is_niche &= ~is_hall
    return looked_up(pieces, is_niche)


def _gates_px(
    pieces: NDArray[np.int32], mouths: Mask, count: int, least_px: float
) -> NDArray[np.float64]:
    """Return the total width of each component's gates ``(count,)``, without entrances."""
    openings, sizes = pieces_of(mouths)
    width = sizes[:, 2:4].max(axis=1)
    owner = np.zeros(len(sizes), dtype=np.int64)
    owner[openings[mouths]] = pieces[mouths]
    is_gate = (width > least_px) & (owner > 0)
    return np.asarray(np.bincount(owner[is_gate], width[is_gate], count), np.float64)
