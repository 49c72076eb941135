# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reasons for a status: one plain sentence with the numbers that decided.

All reason sentences are defined here, including those that need no posterior. Directions are in
the plan's own axes; its +y is called north.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.scoring.competing import NOISE_M
from fpnet_core.scoring.scorer import Posterior

Array = NDArray[np.float64]

NO_PLAN = 'no floorplan yet'
NOT_LOOKED = 'waiting for the first update'
MIRRORED = 'the floorplan seems to be mirrored: only its mirror image fits the scans; flip it'
UPSIDE_DOWN = (
    'the scanner seems to be mounted upside down: the floor is above it, and only the mirror '
    'image fits the scans; correct its mounting in /tf_static'
)
CONTRADICTED = (
    'the newest scans contradict the pose: the robot was kidnapped, its odometry slipped, or the '
    'floorplan is wrong here'
)

AT_EDGE = 0.01
"""Numerical: a scale this near to a search limit, as a ratio, was stopped by the limit."""

FEW_WALLS_M = 25.0
"""Physical: wall length of one room."""

EXPLAINED_WELL = 0.8
"""Share of the walls that a correct placement usually explains. Chosen."""

AS_WELL = 0.04
"""Chosen: smaller differences between shares of explained walls are not significant."""

_DEFORMED = 0.1  # chosen: a deformation that explains this much more of the walls is reported
_MISSING = 0.2  # chosen: from this share on, missing plan walls are reported
_PLACE_SURE = 0.95  # chosen: probability of a place, summed over the storeys, to call it known
_FARTHEST = 5.0  # numerical: limit of the extrapolation, in multiples of the contested wall
_TURNED_RAD = math.radians(30.0)  # physical: smallest difference in heading worth reporting
_PAIR_M = 0.02  # numerical: tolerance when features of two placements are paired
_DIRECTIONS = (
    'east', 'north-east', 'north', 'north-west', 'west', 'south-west', 'south', 'south-east',
)  # fmt: skip
_TOO_LITTLE = {
    'foreign': 'not enough yet to rule out another building',
    'elsewhere': 'not enough yet to rule out another place on this plan',
}
_TIMES = {1: 'once', 2: 'twice'}


@dataclass(frozen=True, eq=False)
class Circumstances:
    """
    Inputs of a reason in addition to the posterior of one update.

    Parameters
    ----------
    walls_m : length of the observed walls [m]
    accept_probability : threshold of acceptance
    at : (P, 2) points of the submap at which placements are compared [m]; their mean is used
    scales : smallest and largest mean scale searched around the stated one; 0 and infinity if no
        scale was stated
    is_accepted, is_mirrored : the decision: accepted, or only the mirror image fits
    sure_looks : consecutive updates, this one included, in which the best placement was certain
    missing_looks : further ones required for acceptance
    needs_news : these must contain new observations
    storey : that of the best placement, on a site with several; else empty
    runner_up_storey : strongest other storey, the share of the walls that its best placement
        explains, and the probability of that placement
    unsearched : number of other storeys that have not been searched yet
    unseen_m : estimated length of the plan walls not yet observed [m]
    """

    walls_m: float
    accept_probability: float
    at: Array
    scales: tuple[float, float] = (0.0, math.inf)
    is_accepted: bool = False
    is_mirrored: bool = False
    sure_looks: int = 1
    missing_looks: int = 0
    needs_news: bool = False
    storey: str = ''
    runner_up_storey: tuple[str, float, float] | None = None
    unsearched: int = 0
    unseen_m: float = math.inf


def reason_of(posterior: Posterior, facts: Circumstances) -> str:
    """Return the deciding facts as one sentence, never empty."""
    if facts.is_mirrored:
        return MIRRORED
    if facts.is_accepted and len(posterior.placements):
        on = f'storey {facts.storey}: ' if facts.storey else ''
        return on + '; '.join(
            [
                _explained(posterior, facts),
                _runner_up(posterior, facts),
                *_other_storey(facts),
                *_scaled(posterior, facts),
            ]
        )
    if len(posterior.placements) and posterior.best >= facts.accept_probability:
        return _unconfirmed(facts)
    return _undecided(posterior, facts)


def waiting(seen_m2: float, needed_m2: float) -> str:
    """Return how much of the floor required for the first update has been observed."""
    return f'only {math.floor(seen_m2)} of {math.ceil(needed_m2)} m² of floor observed so far'


def anew(why: str) -> str:
    """Return the reason after the submap was discarded because of ``why``."""
    return f'new submap: {why}'


def _undecided(posterior: Posterior, facts: Circumstances) -> str:
    """Name the alternative that holds the probability missing from the best placement."""
    is_little = facts.walls_m < FEW_WALLS_M
    little = f'only {metres(facts.walls_m)} of wall observed so far'
    if not len(posterior.placements):
        return little if is_little else 'the observations fit nowhere on the floorplan'
    placed = float(posterior.placements.probability.sum())
    held = {
        'runner_up': placed - posterior.best if len(posterior.placements) > 1 else 0.0,
        'elsewhere': posterior.none - posterior.mirror,
        'mirror': posterior.mirror,
        'foreign': posterior.foreign,
        'storeys': posterior.elsewhere,
    }
    by = max(held, key=lambda name: held[name])
    if by == 'foreign' and placed >= posterior.foreign and _is_alike(posterior):
        by = 'runner_up'  # they share the probability that one place has against another building
    if by == 'storeys' and not is_little:
        return _between_storeys(posterior, facts)
    if by == 'runner_up':
        first = little if is_little else _explained(posterior, facts)
        parting = [] if is_little else _deciding_wall(posterior, facts)
        return '; '.join(
            [first, _runner_up(posterior, facts), *parting, *_scaled(posterior, facts)]
        )
    if is_little:
        return little
    if by in _TOO_LITTLE and _explains_well(posterior, facts):
        explained = f'{percent(_shares(posterior)[0])} of {metres(facts.walls_m)} of observed wall'
        return f'explains {explained}{_deformation(posterior)}: {_TOO_LITTLE[by]}'
    return f'{_explains(posterior, facts)}: {_alternative(by, posterior, facts)}'


def _is_alike(posterior: Posterior) -> bool:
    """Return whether the two most probable places explain the walls equally well."""
    if len(posterior.placements) < 2:
        return False
    best, other = _shares(posterior)[:2]
    return bool(other >= best - AS_WELL)


def _between_storeys(posterior: Posterior, facts: Circumstances) -> str:
    """State that other storeys fit as well, and whether the place on them is known."""
    is_place_sure = posterior.best + posterior.elsewhere >= _PLACE_SURE
    sure = 'place known, storey ambiguous: ' if is_place_sure else ''
    here = f'{_explained(posterior, facts)} on storey {facts.storey}'
    return '; '.join([f'{sure}{here}', *_other_storey(facts)])


def _other_storey(facts: Circumstances) -> list[str]:
    """Return how much the strongest other storey explains; empty without one."""
    if facts.runner_up_storey is None:
        return []
    name, share, probability = facts.runner_up_storey
    return [f'storey {name} explains {percent(share)} (p {probability:.2f})']


def _explains_well(posterior: Posterior, facts: Circumstances) -> bool:
    """Return whether the only weakness of the best placement is the short observed wall."""
    is_there = float(posterior.evidence.of('denied')[0]) < _MISSING
    return bool(
        _shares(posterior)[0] >= EXPLAINED_WELL and is_there and not _scale(posterior, facts)
    )


def _alternative(by: str, posterior: Posterior, facts: Circumstances) -> str:
    """Return the alternative explanation; ``by`` names the one with most probability."""
    is_at_edge = bool(_scale(posterior, facts))
    if by == 'mirror':
        how = 'better' if posterior.mirror > posterior.best else 'equally well'
        return f"the floorplan's mirror image fits {how}"
    if by == 'foreign':
        return (
            'possibly another scale or another building'
            if is_at_edge
            else 'possibly another building'
        )
    elsewhere = 'the robot may be elsewhere on this plan'
    return f'possibly another scale, or {elsewhere}' if is_at_edge else elsewhere


def _unconfirmed(facts: Circumstances) -> str:
    """Return the checks that a sufficiently probable placement still lacks."""
    if facts.unsearched and not facts.missing_looks:
        storeys = 'storey' if facts.unsearched == 1 else 'storeys'
        return f'probability sufficient; {facts.unsearched} other {storeys} still to be searched'
    if not facts.missing_looks:
        return "probability sufficient; the floorplan's mirror image still to be checked"
    times = _TIMES.get(facts.sure_looks, f'{facts.sure_looks} times')
    looks = 'update' if facts.missing_looks == 1 else 'updates'
    news = ' with new observations' if facts.needs_news else ''
    return f'confirmed {times}, needs {facts.missing_looks} more {looks}{news}'


def _explained(posterior: Posterior, facts: Circumstances) -> str:
    return (
        f'explains {percent(_shares(posterior)[0])} of {metres(facts.walls_m)} of observed wall'
        f'{_deformation(posterior)}'
    )


def _explains(posterior: Posterior, facts: Circumstances) -> str:
    scale = _scale(posterior, facts)
    missing = float(posterior.evidence.of('denied')[0])
    parts = [
        f'explains {percent(_shares(posterior)[0])} of the observed walls{_deformation(posterior)}'
    ]
    if scale:
        parts.append(f'at {scale}')
    if missing >= _MISSING:
        parts.append(f'but {percent(missing)} of the plan walls there are missing')
    return ', '.join(parts)


def _runner_up(posterior: Posterior, facts: Circumstances) -> str:
    """Return where the runner-up is and how much it explains."""
    if len(posterior.placements) < 2:
        return 'no runner-up'
    best, other = _shares(posterior)[:2]
    said = f'runner-up {_where(posterior, facts)}: {percent(other)}'
    missing = posterior.evidence.of('denied')
    if round(100 * other) >= round(100 * best) and missing[1] - missing[0] >= _MISSING:
        said += f', but {percent(float(missing[1]))} of the plan walls there are missing'
    return said


def _where(posterior: Posterior, facts: Circumstances) -> str:
    """Return where the runner-up lies relative to the best placement."""
    placed = posterior.placements.take(slice(2))
    middle = placed.apply(facts.at.mean(axis=0, keepdims=True))[:, 0]
    x, y = middle[1] - middle[0]
    heading = placed.heading
    turn = abs(math.remainder(heading[1] - heading[0], math.tau))
    parts = []
    if (apart_m := round(math.hypot(x, y))) >= 1:
        sector = round(math.atan2(y, x) / (math.tau / len(_DIRECTIONS))) % len(_DIRECTIONS)
        parts.append(f'{apart_m} m {_DIRECTIONS[sector]}')
    if turn >= _TURNED_RAD:
        parts.append(f'rotated by {round(math.degrees(turn))} degrees')
    return ', '.join(parts) or 'at nearly the same place'


def _deciding_wall(posterior: Posterior, facts: Circumstances) -> list[str]:
    """
    Return how much more wall would separate the best placement from the runner-up, if known.

    Log odds grow in proportion to the contested wall length, so the gain so far is extrapolated.
    The result is empty if the plan has less unobserved wall than that.
    """
    contested_m = _contested_m(posterior, facts.walls_m)
    best, other = posterior.placements.probability[:2]
    supports = posterior.evidence.of('support')
    if contested_m < NOISE_M or not best > other > 0.0 or supports[0] <= supports[1]:
        return []
    needed = math.log(facts.accept_probability / (1.0 - facts.accept_probability))
    more = needed / math.log(best / other) - 1.0
    if not 0.0 < more <= _FARTHEST:
        return []
    more_m = max(more * contested_m, 1.0)
    if more_m > facts.unseen_m:
        return []
    return [f'{metres(more_m)} more wall where they differ would decide']


def _contested_m(posterior: Posterior, walls_m: float) -> float:
    """Return the length of wall on which the two best differ [m]; 0 if it is unknown."""
    figures, support = posterior.evidence, posterior.evidence.of('support').astype(np.float64)
    bent = figures.of('bent_support').astype(np.float64)
    for one, other in ((0, 1), (1, 0)):
        # Each placement's features are relative to its own strongest competitor.
        told = [float(figures.of(name)[one]) for name in ('rival_net', 'rival_bent_net')]
        net = [(each[one] - each[other]) * walls_m for each in (support, bent)]
        if all(
            abs(math.copysign(math.expm1(abs(log)), log) - exact) <= _PAIR_M
            for log, exact in zip(told, net, strict=True)
        ):
            return math.expm1(float(figures.of('rival_contested')[one]))
    return 0.0


def _scaled(posterior: Posterior, facts: Circumstances) -> list[str]:
    scale = _scale(posterior, facts)
    return [f'best fit at {scale}'] if scale else []


def _scale(posterior: Posterior, facts: Circumstances) -> str:
    """Return the best placement's scale if it is at a limit of the search, else empty."""
    (low, high), scale = facts.scales, float(posterior.placements.scale[0])
    edge = 1.0 + AT_EDGE
    if not 0.0 < low * edge**2 < high < math.inf or low * edge < scale < high / edge:
        return ''
    said = f'{scale:.2f} times the stated scale'
    if not low / edge < scale < high * edge:
        return said  # found with the wide scale prior
    limit = 'lowest' if scale <= low * edge else 'highest'
    return f'{said}, the {limit} searched'


def _deformation(posterior: Posterior) -> str:
    if not _is_deformed(posterior):
        return ''
    return f' (plan locally deformed by {float(posterior.evidence.of("bend_m")[0]):.1f} m RMS)'


def _is_deformed(posterior: Posterior) -> bool:
    return float(posterior.evidence.of('bend_gain')[0]) >= _DEFORMED


def _shares(posterior: Posterior) -> Array:
    """Return the share of the walls that each placement explains, ``(C,)``."""
    name = 'bent_support' if _is_deformed(posterior) else 'support'
    return np.asarray(posterior.evidence.of(name), np.float64)


def percent(share: float) -> str:
    """Return a share in percent, as text."""
    return f'{round(100 * share)} %'


def metres(length_m: float) -> str:
    """Return a length in whole metres, as text."""
    return f'{round(length_m)} m'
