# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What speaks against using a floorplan as it was read: the cause, and what to do next.

The reader has doubts that need no scale. Here its scale counts as well: areas and door widths of
no building, and a scale that nobody can be sure of.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import math

import cv2
import numpy as np

from fpnet_core.drawings.types import DrawingScale, Reading
from fpnet_core.drawings.wording import said_of_scale
from fpnet_core.judging.causes import Asked
from fpnet_core.segmentation import STATED_SCALE, ScaleEstimate
from fpnet_core.types import UNKNOWN, Segmentation

_ROOM_M2 = (4.0, 200.0)
"""Physical: the middle room of real buildings has 10 to 60 m2."""
_DOOR_M = (0.5, 2.5)
"""Physical: the middle door of real buildings is 0.8 to 1.2 m wide, openings counted."""
_GIANT_SHARE, _FEW_ROOMS = 0.9, 3  # chosen: of the floor in one of at least so many rooms
_GIANT_M2 = 400.0  # physical: a hall; a single larger room is the paper
_UNKNOWN_SHARE = 0.5  # chosen: of what lies within the building
_UNSURE = 2.25
"""Chosen: largest over smallest scale. It is what `fpnet bench localization` tries as
`unknown_scale`, nominal metres off by a factor of 0.67 to 1.5, and where every robot is found.
Of sheets that were read rightly it is 1.5 to 2.2; what is less sure may be any building."""


@dataclass(frozen=True)
class Refusal:
    """Why a floorplan is refused, and what to type; ``is_scale`` where only its scale is."""

    why: str
    next: str
    is_scale: bool = False

    def as_json(self) -> dict[str, str]:
        """Return a mapping of plain values."""
        return {'reason': self.why, 'next': self.next}


def refusals_of(
    reading: Reading, segmentation: Segmentation, asked: Asked, told: ScaleEstimate = STATED_SCALE
) -> tuple[Refusal, ...]:
    """
    Return what speaks against a reading; nothing for one that may be used.

    Parameters
    ----------
    reading : the drawing as it was read
    segmentation : rooms and doors of its grid
    asked : what was typed, for the next commands
    told : what its rooms, doors and walls say of its scale
    """
    look = f'{asked.look("plan", "--out", "out/plan.yaml")} and look at out/plan_reading.png'
    crop = asked.again('--crop', 'LEFT,TOP,RIGHT,BOTTOM')
    part = f'{look}; if another part of the sheet was read: {crop}'
    if reading.drawing.format == 'map_server':
        meant = 'a map of map_server is taken as it is: change its image, thresholds or resolution'
        part = f'{look}; {meant}'
    doubts = [doubt.rstrip('.') for doubt in reading.doubts] or list(_implausible(segmentation))
    found = [Refusal(doubt, part) for doubt in doubts]
    scale = asked.again('--length', 'X1,Y1,X2,Y2=METRES', instead_of=('--resolution',))
    if not doubts:
        wrong = scale_faults(reading.scale, segmentation, told)
        found += [Refusal(why, scale, is_scale=True) for why in wrong]
    if is_unsure(reading.scale):
        measure = f'measure one length: {scale}'
        why = f'its scale is unsure: {said_of_scale(reading.scale)}'
        found.append(Refusal(why, measure, is_scale=True))
    return tuple(found)


def is_unsure(scale: DrawingScale) -> bool:
    """Tell whether nobody states a scale, and its interval is too wide to be searched."""
    return not scale.is_known and scale.high_m > _UNSURE * scale.low_m


def _implausible(segmentation: Segmentation) -> Iterator[str]:
    rooms = segmentation.rooms
    if not rooms:
        yield f'it holds no room ({segmentation.reason})'
        return
    areas = np.array([room.area_m2 for room in rooms])
    share = float(areas.max() / areas.sum())
    if len(rooms) >= _FEW_ROOMS and share > _GIANT_SHARE:
        yield f'one room holds {100.0 * share:.0f} % of the floor'
    if len(rooms) == 1 and areas[0] > _GIANT_M2:
        yield f'it is one room of {areas[0]:.0f} m2'
    if len(rooms) > 1 and not segmentation.portals:
        yield f'it has {len(rooms)} rooms and no door'
    unknown = _unknown_share(segmentation)
    if unknown > _UNKNOWN_SHARE:
        yield f'{100.0 * unknown:.0f} % of the building is neither wall nor floor'


def scale_faults(
    scale: DrawingScale, segmentation: Segmentation, told: ScaleEstimate
) -> tuple[str, ...]:
    """Return what speaks against a scale: sizes of no building, another scale that is told."""
    return (*_mismeasured(segmentation), *_misstated(scale, told))


def _mismeasured(segmentation: Segmentation) -> Iterator[str]:
    """Say which areas and widths are those of no building, at the scale that was taken."""
    area = float(np.median([room.area_m2 for room in segmentation.rooms]))
    if len(segmentation.rooms) >= _FEW_ROOMS and not _ROOM_M2[0] <= area <= _ROOM_M2[1]:
        yield f'its middle room has {area:.3g} m2: no building at this scale'
    widths = [portal.width_m for portal in segmentation.portals]
    width = float(np.median(widths)) if widths else math.nan
    if widths and not _DOOR_M[0] <= width <= _DOOR_M[1]:
        yield f'its middle door is {width:.2g} m wide: no building at this scale'


def _misstated(scale: DrawingScale, told: ScaleEstimate) -> Iterator[str]:
    """Say by how much a stated scale is off, where that is beyond doubt."""
    if scale.is_known and told.is_denial:
        yield f'{told.said_at(scale.resolution_m)}, and {said_of_scale(scale)}'


def _unknown_share(segmentation: Segmentation) -> float:
    """Return the share of unknown cells within the hull of all rooms."""
    inside = (segmentation.labels > 0).astype(np.uint8)
    hull = cv2.convexHull(cv2.findNonZero(inside))
    filled = cv2.fillConvexPoly(np.zeros_like(inside), hull, 1) > 0
    return float(np.mean(segmentation.grid.cells[filled] == UNKNOWN))
