# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What of a drawing is outside the building: the one answer for readers and for segmentation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fpnet_core.raster.windows import border_of
from fpnet_core.types import FREE, UNKNOWN

Mask = NDArray[np.bool_]

# Chosen, not measured:
_EXIT_WIDTH_M = 4.5  # gates, open ends of corridors and gaps up to this do not let the outside in
_PAPER_BORDER_SHARE = 0.5  # of the border is free where the picture shows the outside as white
_MIN_INSIDE_SHARE = 0.05  # of the free space; less left inside means the building is not closed


def is_on_paper(free: Mask) -> bool:
    """Tell whether the outside of a drawing is free, so that its border mostly is."""
    return bool(border_of(free).mean() > _PAPER_BORDER_SHARE)


def interior(free: Mask) -> Mask:
    """Return ``free (H, W)`` without the paper around a drawing, up to the first line."""
    if not is_on_paper(free):
        return free
    pieces, _ = ndimage.label(free)
    return np.asarray(free & ~np.isin(pieces, np.unique(border_of(pieces))))


def outside_as_unknown(cells: NDArray[np.int8], resolution_m: float) -> NDArray[np.int8]:
    """
    Return ``cells (H, W)`` with the free space around a building turned unknown.

    Drawings are often on white paper. What is reachable from the border through openings wider
    than ``_EXIT_WIDTH_M`` is outside. The cells come back unchanged if the border is not mostly
    free, or if the building is so open that nothing would be left.
    """
    free = cells == FREE
    if border_of(free).mean() < _PAPER_BORDER_SHARE:
        return cells
    inside = _inside_of(free, 0.5 * _EXIT_WIDTH_M / resolution_m)
    if inside is None or np.count_nonzero(inside) < _MIN_INSIDE_SHARE * np.count_nonzero(free):
        return cells
    result = cells.copy()
    result[free & ~inside] = UNKNOWN
    return result


def _inside_of(free: Mask, reach_px: float) -> Mask | None:
    """
    Return what of ``free (H, W)`` a disc of radius ``reach_px`` does not reach from outside.

    None where the disc does not fit beside the building. Niches of the outer wall are outside.
    """
    # One free pixel all around joins what the building's walls cut off at the image's edge.
    padded = np.pad(free, 1, constant_values=True)
    clearance = ndimage.distance_transform_edt(np.pad(padded, int(reach_px) + 1, mode='edge'))
    core, _ = ndimage.label(clearance > reach_px)
    if core[0, 0] == 0:
        return None
    core = core == core[0, 0]
    outside = ndimage.distance_transform_edt(~core) <= reach_px + 1.0
    margin = int(reach_px) + 2
    inside = free & ~outside[margin:-margin, margin:-margin]
    inside &= ~_crumbs(inside, free & ~inside, clearance[margin:-margin, margin:-margin], reach_px)
    return np.asarray(inside)


def _crumbs(
    inside: NDArray[np.bool_],
    outside: NDArray[np.bool_],
    clearance: NDArray[np.floating[Any]],
    reach_px: float,
) -> NDArray[np.bool_]:
    """Return the niches of the outer wall: parts open to the outside, too narrow for a room."""
    labels, count = ndimage.label(inside)
    touching = np.unique(labels[ndimage.binary_dilation(outside) & inside])
    widest = ndimage.maximum(clearance, labels, np.arange(count + 1))
    narrow = touching[np.asarray(widest)[touching] <= reach_px]
    niches: NDArray[np.bool_] = np.isin(labels, narrow[narrow > 0])
    return niches
