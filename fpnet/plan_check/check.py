# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floorplan check: scale, rooms that look alike, simulated drives, and advice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from fpnet.accuracy import WRONG_POSITION_M
from fpnet.plan_check.self_similarity import SelfSimilarity, self_similarity
from fpnet.plan_check.verdict import FIT, PlanVerdict, verdict_of
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.types import DrawingScale, Reading, ScaleSource
from fpnet_core.drawings.wording import said_of_scale
from fpnet_core.errors import ConfigError
from fpnet_core.localizer import create_global_localizer
from fpnet_core.localizer.prepared_maps import prepared_plan
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.segmentation import ScaleEstimate, told_scale
from fpnet_core.segmentation.scale import SURE_FACTOR
from fpnet_core.segmentation.ways_out import rooms_with_ways_out
from fpnet_core.types import Segmentation

# Chosen, not measured:
_SCALE_OFF = 1.15  # larger estimated factors are reported
_MANY = 0.5  # share of the rooms that is reported


@dataclass(frozen=True)
class TourResult:
    """
    One simulated drive, which ends with the first accepted pose.

    ``found_after_m`` is the path length to that pose, None if there was none in ``path_m``;
    ``error_m`` is its error in true metres.
    """

    seed: int
    path_m: float
    found_after_m: float | None
    error_m: float | None

    @property
    def is_wrong(self) -> bool:
        """Whether the accepted pose was wrong."""
        return self.error_m is not None and self.error_m > WRONG_POSITION_M


DriveTour = Callable[[Reading, FpnetConfig, int], TourResult]
"""
Function that drives a simulated robot, with a seed, through the building of a floorplan until it
is localized. It raises ConfigError if no drive is possible. The lab package provides it; this
package does not depend on the lab.
"""


@dataclass(frozen=True, eq=False)
class PlanCheck:
    """
    All findings on a floorplan; ``advice`` states in sentences what to do.

    ``scale`` is estimated from rooms and doors, in true metres per metre of the segmentation's
    grid; ``drawn`` is the scale of the drawing. If the ``verdict`` is that the drawing was
    misread, nothing else was checked.
    """

    segmentation: Segmentation
    scale: ScaleEstimate
    drawn: DrawingScale
    similarity: SelfSimilarity
    tours: tuple[TourResult, ...]
    tour_problem: str = ''
    advice: tuple[str, ...] = ()
    verdict: PlanVerdict = FIT

    @property
    def is_readable(self) -> bool:
        """Whether there is no objection to the floorplan, or the user accepted it."""
        return self.verdict.is_usable

    def as_json(self) -> dict[str, Any]:
        """Return a JSON-serializable mapping."""
        rooms = self.segmentation.rooms
        return {
            'verdict': self.verdict.as_json(),
            'rooms': len(rooms),
            'doors': len(self.segmentation.doors),
            'area_m2': round(sum(room.area_m2 for room in rooms), 1),
            'scale': {
                'factor': round(self.scale.factor, 3),
                'low': round(self.scale.low, 3),
                'high': round(self.scale.high, 3),
                'given': self.drawn.is_known,
                'metres_per_pixel': self.drawn.resolution_m,
                'source': self.drawn.source.value,
                'sure': _is_sure(self.drawn),
            },
            'scale_interval': [self.drawn.low_m, self.drawn.high_m],
            'similar_alone': _plain(self.similarity.alone),
            'similar_with_neighbours': _plain(self.similarity.with_neighbours),
            'symmetries': [asdict(twin) for twin in self.similarity.whole],
            'tours': [asdict(tour) for tour in self.tours],
            'expected_path_m': expected_path_m(self.tours),
            'tour_problem': self.tour_problem,
            'advice': list(self.advice),
        }


def _plain(twins: dict[int, Any]) -> dict[str, list[dict[str, Any]]]:
    return {str(room): [asdict(twin) for twin in found] for room, found in twins.items()}


def check_plan(
    reading: Reading,
    config: FpnetConfig,
    seeds: range,
    drive: DriveTour,
    invocation: Invocation | None = None,
    on_step: Callable[[float], None] = lambda _: None,
) -> PlanCheck:
    """
    Check a floorplan before a robot drives.

    A misread drawing is not checked further: the findings would be about a title block.

    Parameters
    ----------
    reading : the parsed drawing
    config : configuration of the localizer that will use it
    seeds : seeds of the simulated drives
    drive : function that simulates one drive
    invocation : command line, for the next commands
    on_step : called with 1 after each step; there is one step more than drives

    """
    segmentation = reading.segmented(config.segmentation)
    told = told_scale(reading.grid, segmentation, config.segmentation)
    verdict = verdict_of(reading, segmentation, invocation, told)
    check = PlanCheck(
        segmentation,
        told,
        reading.scale,
        SelfSimilarity({}, {}, ()),
        (),
        verdict=verdict,
    )
    if verdict.is_read and segmentation.rooms:
        similarity = self_similarity(prepared_plan(segmentation), create_global_localizer(config))
        check = replace(check, similarity=similarity)
        on_step(1.0)
        check = _driven(check, lambda seed: drive(reading, config, seed), seeds, on_step)
    return replace(check, advice=tuple(_advice(check)))


def _driven(
    check: PlanCheck,
    drive: Callable[[int], TourResult],
    seeds: range,
    on_step: Callable[[float], None],
) -> PlanCheck:
    results: list[TourResult] = []
    problem = ''
    for seed in seeds:
        try:
            results.append(drive(seed))
        except ConfigError as error:
            problem = str(error)
        on_step(1.0)
    return replace(check, tours=tuple(results), tour_problem=problem)


def expected_path_m(tours: tuple[TourResult, ...]) -> float | None:
    """Return the median path to a correct pose; None if half of the drives had none."""
    paths = [
        np.inf if tour.found_after_m is None or tour.is_wrong else tour.found_after_m
        for tour in tours
    ]
    median = float(np.median(paths)) if paths else np.inf
    return round(median, 2) if np.isfinite(median) else None


def _advice(check: PlanCheck) -> list[str]:
    if not check.verdict.is_read:
        return []
    said = [*_on_scale(check), *_on_doors(check), *_on_twins(check), *_on_tours(check)]
    if not said and not check.verdict.reasons:
        said = ['No problem found with this floorplan.']
    return said


def _on_scale(check: PlanCheck) -> list[str]:
    scale, drawn = check.scale, check.drawn
    if not drawn.is_known:
        return [
            f'The drawing states no scale: {said_of_scale(drawn)}. The localizer searches the '
            'whole interval; it localizes sooner if you measure one length: '
            '--length X1,Y1,X2,Y2=METRES.'
        ]
    is_off = max(scale.factor, 1.0 / scale.factor) > _SCALE_OFF
    if is_off and not scale.low <= 1.0 <= scale.high:
        size = 'small' if scale.factor > 1.0 else 'large'
        return [
            f'Doors, rooms and walls suggest that the plan is drawn too {size}: true lengths are '
            f'about {scale.factor:.2f} times those on the plan ({scale.low:.2f} to '
            f'{scale.high:.2f} with 90 %). Check its resolution.'
        ]
    return []


def _on_doors(check: PlanCheck) -> list[str]:
    segmentation = check.segmentation
    rooms = [room.id for room in segmentation.rooms]
    ways = rooms_with_ways_out(segmentation)
    doored = ways | {room for portal in segmentation.portals for room in portal.rooms}
    if not doored:
        return [
            'No door was found. If doors are drawn closed or as arcs, erase them: a robot sees '
            'an opening in the wall.'
        ]
    shut = [room for room in rooms if room not in doored]
    if shut and len(rooms) > 1:
        return [f'{_rooms(shut)}: no door was found. If a robot can get there, draw the opening.']
    return []


def _on_twins(check: PlanCheck) -> list[str]:
    total, similarity = len(check.segmentation.rooms), check.similarity
    said = []
    if similarity.whole:
        turns = ', '.join(f'{abs(twin.turn_deg):.0f}' for twin in similarity.whole)
        said.append(
            f'The whole plan looks the same when moved or rotated (by {turns} degrees): no drive '
            'resolves this. Draw the differences, or give an initial pose.'
        )
    if len(similarity.alone) > _MANY * total:
        said.append(
            f'{len(similarity.alone)} of {total} rooms look like another one from inside: expect '
            '"ambiguous" until the robot has left its first room.'
        )
    if similarity.with_neighbours:
        rooms = sorted(similarity.with_neighbours)
        said.append(
            f'{_rooms(rooms)}: like another place even with the adjacent rooms. Start elsewhere, '
            'or expect a longer drive.'
        )
    return said


def _on_tours(check: PlanCheck) -> list[str]:
    tours = check.tours
    said = []
    if check.tour_problem:
        said.append(f'A simulated robot could not drive everywhere: {check.tour_problem}.')
    wrong = sum(tour.is_wrong for tour in tours)
    if wrong:
        said.append(
            f'{wrong} of {len(tours)} simulated drives ended with a wrong pose: do not rely on '
            'this plan without an initial pose.'
        )
    found = sum(tour.found_after_m is not None for tour in tours) - wrong
    if tours and (path := expected_path_m(tours)) is not None:
        said.append(
            f'In {found} of {len(tours)} simulated drives the robot was localized, typically '
            f'after {path:.0f} m.'
        )
    elif tours and not wrong:
        longest = max(tour.path_m for tour in tours)
        said.append(
            f'In {found} of {len(tours)} simulated drives of up to {longest:.0f} m the robot was '
            'localized: expect long searches on this plan.'
        )
    return said


def _rooms(ids: list[int]) -> str:
    """Return ``Room 3`` or ``Rooms 3, 4``, at most twelve numbers."""
    named = ', '.join(map(str, ids[:12])) + (' and more' if len(ids) > 12 else '')
    return f'Rooms {named}' if len(ids) > 1 else f'Room {named}'


def room_note(check: PlanCheck, room: int) -> str:
    """Return a short note on the twins of a room, empty for a unique room."""
    twins = check.similarity.with_neighbours.get(room)
    words = 'even with its neighbours, looks like' if twins else 'from inside, looks like'
    twins = twins or check.similarity.alone.get(room)
    if not twins:
        return ''
    others = sorted({twin.other for twin in twins} - {room})
    parts = [f'room {other}' for other in others]
    if any(twin.other == room for twin in twins):
        parts.append('itself rotated')
    return f'{words} {", ".join(parts)}'


def _is_sure(scale: DrawingScale) -> bool:
    """Return whether a scale counts as sure: its interval ends within ten per cent."""
    return (
        scale.source is not ScaleSource.UNKNOWN
        and scale.high_m <= SURE_FACTOR * scale.resolution_m
        and scale.low_m >= scale.resolution_m / SURE_FACTOR
    )
