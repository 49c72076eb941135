# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The scale of a drawing of which nobody has said it: what its doors, rooms and walls suggest."""

from __future__ import annotations

from fpnet_core.drawings.types import DrawingScale, ScaleSource
from fpnet_core.segmentation import ScaleEstimate, estimate_metres_per_unit
from fpnet_core.types import Segmentation


def estimate_scale(segmentation: Segmentation, metres_per_unit: float = 1.0) -> DrawingScale:
    """
    Return what a segmented drawing says of its scale.

    Parameters
    ----------
    segmentation : rooms and doors in nominal metres of its grid's ``resolution``
    metres_per_unit : the factor from nominal to true metres that it was made with; the nearer to
        the truth the better, see :func:`fpnet_core.segmentation.segment_unknown_scale`
    """
    estimate = estimate_metres_per_unit(segmentation, metres_per_unit)
    return drawing_scale(estimate, segmentation)


def drawing_scale(estimate: ScaleEstimate, segmentation: Segmentation) -> DrawingScale:
    """Return an estimate as metres per pixel of the drawing that was segmented."""
    nominal_m = segmentation.grid.resolution
    doors, rooms = len(segmentation.portals), len(segmentation.rooms)
    return DrawingScale(
        estimate.factor * nominal_m,
        estimate.low * nominal_m,
        estimate.high * nominal_m,
        ScaleSource.ESTIMATED,
        f'{_count(doors, "door")}, {_count(rooms, "room")} and walls',
    )


def _count(number: int, word: str) -> str:
    return f'{number} {word}' if number == 1 else f'{number} {word}s'
