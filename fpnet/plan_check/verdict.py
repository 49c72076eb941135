# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Verdict on a parsed drawing: whether it is usable as a floorplan, why not, where, what to do.

Every command and node that checks a plan calls :func:`verdict_of`. Parser warnings do not use the
scale. The checks here do: implausible room areas and door widths, a scale that contradicts rooms
and doors, and one that is too uncertain to be searched.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
import math
from typing import Any

import cv2
import numpy as np

from fpnet_core.drawings.plan_files import MAP_FORMAT
from fpnet_core.drawings.types import Box, DrawingScale, Reading
from fpnet_core.drawings.wording import said_of_scale
from fpnet_core.raster.pixels import map_points
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.segmentation import STATED_SCALE, ScaleEstimate
from fpnet_core.segmentation.ways_out import rooms_with_ways_out
from fpnet_core.types import UNKNOWN, Region, Segmentation

_ROOM_M2 = (4.0, 200.0)
"""Physical: the median room of real buildings has 10 to 60 m²."""
_DOOR_M = (0.5, 2.5)
"""Physical: the median door of real buildings, with openings, is 0.8 to 1.2 m wide."""
_GIANT_SHARE, _FEW_ROOMS = 0.9, 3  # chosen: floor share of one room, least number of rooms
_GIANT_M2 = 400.0  # physical: a hall; a larger room without a door is the paper
_UNKNOWN_SHARE = 0.5  # chosen: share of the cells within the building
_UNSURE = 2.25
"""Chosen: largest over smallest scale. `fpnet bench localization` tests this range as
`unknown_scale`, nominal metres off by a factor of 0.67 to 1.5, and localizes every robot.
Correctly parsed sheets have 1.5 to 2.2; a wider interval would fit any building."""


class Fitness(StrEnum):
    """Usability of a parsed drawing as a floorplan."""

    FIT = 'fit'
    DOUBTFUL = 'doubtful'
    NO_FLOORPLAN = 'not a floorplan'


@dataclass(frozen=True)
class Reason:
    """
    An objection to a plan.

    Parameters
    ----------
    what : description
    next : what to do about it
    places : boxes on the drawing in its pixels; empty if it concerns the whole drawing
    is_scale : it concerns the scale only
    """

    what: str
    next: str
    places: tuple[Box, ...] = ()
    is_scale: bool = False

    def as_json(self) -> dict[str, Any]:
        """Return a JSON-serializable mapping."""
        return {
            'what': self.what,
            'next': self.next,
            'boxes_px': [list(map(int, box)) for box in self.places],
            'scale': self.is_scale,
        }


@dataclass(frozen=True)
class PlanVerdict:
    """Usability of a plan; ``accepted`` is the user's reason to use it despite ``reasons``."""

    fitness: Fitness
    reasons: tuple[Reason, ...] = ()
    accepted: str = ''

    @property
    def is_usable(self) -> bool:
        """Whether there is no objection, or the user accepted the plan."""
        return self.fitness is Fitness.FIT or bool(self.accepted)

    @property
    def is_read(self) -> bool:
        """Whether all objections concern the scale, or the user accepted the plan."""
        return bool(self.accepted) or all(reason.is_scale for reason in self.reasons)

    def as_json(self) -> dict[str, Any]:
        """Return a JSON-serializable mapping."""
        return {
            'fitness': self.fitness.value,
            'usable': self.is_usable,
            'accepted': self.accepted or None,
            'reasons': [reason.as_json() for reason in self.reasons],
        }

    def headlines(self) -> list[str]:
        """Return the objections, one line each, or the reason of acceptance."""
        if self.accepted:
            return [f'accepted: {self.accepted}']
        return [f'{self.fitness.value}: {reason.what}' for reason in self.reasons]

    def said_of_file(self, name: str) -> str:
        """Return in one line why the file ``name`` is not usable."""
        why = '; '.join(reason.what for reason in self.reasons)
        return f'{name}: {self.fitness.value}: {why}; next: {self.reasons[0].next}'

    def lines(self) -> Iterator[str]:
        """Yield the lines to print; none for a plan that is fit."""
        if self.accepted:
            yield from self.headlines()
            return
        for number, reason in enumerate(self.reasons):
            yield f'{self.fitness.value}: {reason.what}'
            following = self.reasons[number + 1 : number + 2]
            if not following or following[0].next != reason.next:
                yield f'   next: {reason.next}'


FIT = PlanVerdict(Fitness.FIT)
"""Verdict without objections."""


def verdict_of(
    reading: Reading,
    segmentation: Segmentation,
    invocation: Invocation | None = None,
    told: ScaleEstimate = STATED_SCALE,
    picture: str = '',
) -> PlanVerdict:
    """
    Return the verdict on a plan.

    Parameters
    ----------
    reading : the parsed drawing
    segmentation : rooms and doors of its grid
    invocation : command line, for the next commands
    told : scale estimated from its rooms, doors and walls
    picture : path of the plot of the parse, if there is one
    """
    invocation = invocation or Invocation()
    is_other = _is_no_floorplan(reading, segmentation)
    look = f'look at {picture}' if picture else invocation.look_at_reading()
    remedy = _remedy(reading, invocation, '' if is_other else look)
    reasons = tuple(_reasons(reading, segmentation, invocation, told, remedy))
    fitness = Fitness.DOUBTFUL if reasons else Fitness.FIT
    return PlanVerdict(Fitness.NO_FLOORPLAN if is_other else fitness, reasons, reading.accepted)


def unreadable(error: Exception, invocation: Invocation) -> PlanVerdict:
    """Return the verdict on a file that could not be read."""
    crop = invocation.again('--crop', 'LEFT,TOP,RIGHT,BOTTOM')
    return PlanVerdict(Fitness.NO_FLOORPLAN, (Reason(str(error), crop),))


def _reasons(
    reading: Reading,
    segmentation: Segmentation,
    invocation: Invocation,
    told: ScaleEstimate,
    remedy: str,
) -> Iterator[Reason]:
    places = tuple(each.box for each in reading.doubtful)
    found = [(doubt.rstrip('.'), places) for doubt in reading.doubts] or [
        (what, tuple(_box(reading, room) for room in rooms))
        for what, rooms in _implausible(segmentation, reading.scale.is_known)
    ]
    for what, where in found:
        yield Reason(what, remedy, where)
    measure = invocation.again('--length', 'X1,Y1,X2,Y2=METRES', instead_of=('--resolution',))
    if not found:
        for what in scale_faults(reading.scale, segmentation, told):
            yield Reason(what, measure, is_scale=True)
    if is_unsure(reading.scale):
        what = f'its scale is uncertain: {said_of_scale(reading.scale)}'
        yield Reason(what, f'measure one length: {measure}', is_scale=True)


def _remedy(reading: Reading, invocation: Invocation, look: str) -> str:
    """Return what to do about rooms that may have been misread."""
    crop = invocation.again('--crop', 'LEFT,TOP,RIGHT,BOTTOM')
    part = f'if the wrong part of the sheet was read: {crop}'
    if reading.drawing.format == MAP_FORMAT:
        part = 'a map_server map is used as it is: change its image, thresholds or resolution'
    accept = f'if it was read correctly: {invocation.again("--accept", "REASON")}'
    return '; '.join([*([look] if look else []), part, accept])


def _is_no_floorplan(reading: Reading, segmentation: Segmentation) -> bool:
    """Return whether a drawing shows no building, rather than a misread one."""
    if reading.drawing.format == MAP_FORMAT:
        return False
    if not segmentation.rooms:
        return not reading.scale.is_known  # at a wrong scale every room is too small
    return reading.is_other


def is_unsure(scale: DrawingScale) -> bool:
    """Return whether no scale is stated and its interval is too wide to be searched."""
    return not scale.is_known and scale.high_m > _UNSURE * scale.low_m


def _implausible(
    segmentation: Segmentation, is_measured: bool
) -> Iterator[tuple[str, Sequence[Region]]]:
    """Yield implausible properties, each with the rooms concerned."""
    rooms = segmentation.rooms
    if not rooms:
        cell_m = segmentation.grid.resolution
        yield (
            f'no room was found at {cell_m:.3g} m per cell: check the scale and, for a '
            f'map_server map, negate, mode and thresholds ({segmentation.reason})',
            (),
        )
        return
    areas = np.array([room.area_m2 for room in rooms])
    share, largest = float(areas.max() / areas.sum()), rooms[int(areas.argmax())]
    # With a known scale, a large room with a door is a hall. Without one it may be the paper.
    ways = rooms_with_ways_out(segmentation) if is_measured else set()
    doored = ways | {room for portal in segmentation.portals for room in portal.rooms}
    is_hall = is_measured and largest.id in doored
    if len(rooms) >= _FEW_ROOMS and share > _GIANT_SHARE and not is_hall:
        yield f'room {largest.id} holds {100.0 * share:.0f} % of the floor', (largest,)
    if len(rooms) == 1 and areas[0] > _GIANT_M2 and not is_hall:
        yield f'it is one room of {areas[0]:.0f} m²', (largest,)
    if len(rooms) > 1 and not doored:
        yield f'it has {len(rooms)} rooms and no door', ()
    unknown = _unknown_share(segmentation)
    if unknown > _UNKNOWN_SHARE:
        yield f'{100.0 * unknown:.0f} % of the building is neither wall nor floor', ()


def scale_faults(
    scale: DrawingScale, segmentation: Segmentation, told: ScaleEstimate
) -> tuple[str, ...]:
    """Return contradictions to a scale: implausible sizes, or another estimated scale."""
    # For a single hall, a gate of plausible width outweighs the area.
    is_hall = len(segmentation.rooms) == 1 and bool(rooms_with_ways_out(segmentation))
    return (*_mismeasured(segmentation), *_scale_conflicts(scale, told, is_hall))


def _mismeasured(segmentation: Segmentation) -> Iterator[str]:
    """Yield median room areas and door widths that are implausible at this scale."""
    area = float(np.median([room.area_m2 for room in segmentation.rooms]))
    if len(segmentation.rooms) >= _FEW_ROOMS and not _ROOM_M2[0] <= area <= _ROOM_M2[1]:
        yield f'its median room has {area:.3g} m²: implausible at this scale'
    widths = [portal.width_m for portal in segmentation.portals]
    width = float(np.median(widths)) if widths else math.nan
    if widths and not _DOOR_M[0] <= width <= _DOOR_M[1]:
        yield f'its median door is {width:.2g} m wide: implausible at this scale'


def _scale_conflicts(
    scale: DrawingScale, told: ScaleEstimate, is_single_hall: bool
) -> Iterator[str]:
    """Yield the conflict of a stated scale with the estimated one, if it is certain."""
    if scale.is_known and told.is_scale_conflict and not is_single_hall:
        yield f'{told.said_at(scale.resolution_m)}, but {said_of_scale(scale)}'


def _unknown_share(segmentation: Segmentation) -> float:
    """Return the share of unknown cells within the hull of all rooms."""
    inside = (segmentation.labels > 0).astype(np.uint8)
    hull = cv2.convexHull(cv2.findNonZero(inside))
    filled = cv2.fillConvexPoly(np.zeros_like(inside), hull, 1) > 0
    return float(np.mean(segmentation.grid.cells[filled] == UNKNOWN))


def _box(reading: Reading, room: Region) -> Box:
    """Return the bounding box of a room in pixels of the drawing."""
    outline = map_points(np.linalg.inv(reading.H_plan_image), room.polygon)
    first, last = np.floor(outline.min(axis=0)), np.ceil(outline.max(axis=0))
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])
