# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Why an answer is what it is: one plain sentence, in words and figures.

Every sentence names what decides. All of them have their home here, those too that need no
verdict; the plan's axes are its own, and its +y is called north.
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
NOT_LOOKED = 'not looked at yet'
MIRRORED = 'the floorplan looks mirrored: what was seen fits its mirror image only; flip it'
UPSIDE_DOWN = (
    'the scanner looks upside down: the floor is above it, and what was seen fits the mirror '
    'image only; turn it in /tf_static'
)
CONTRADICTED = (
    'what is seen now does not fit where the robot was: it was carried off, its odometry has '
    'slipped, or the drawing is wrong here'
)

AT_EDGE = 0.01
"""Numerical: a scale as near to what was searched, as a share, has been held there."""

FEW_WALLS_M = 25.0
"""Physical: the walls of one room."""

EXPLAINED_WELL = 0.8
"""A right placement explains so much of the walls, as a rule. Chosen."""

AS_WELL = 0.04
"""Chosen: shares of walls that differ by less tell nothing apart."""

_BENT = 0.1  # chosen: a deformation that explains so much more of the walls is worth a word
_MISSING = 0.2  # chosen: so many drawn walls that are not there are worth a word
_PLACE_SURE = 0.95  # chosen: on one storey or another, the place is that
_FARTHEST = 5.0  # numerical: no estimate reaches beyond so many times of what was compared
_TURNED_RAD = math.radians(30.0)  # physical: a difference in heading that the eye sees
_PAIR_M = 0.02  # numerical: figures of one pair agree within this
_DIRECTIONS = (
    'east', 'north-east', 'north', 'north-west', 'west', 'south-west', 'south', 'south-east',
)  # fmt: skip
_TOO_LITTLE = {
    'foreign': 'too little yet to rule out another building',
    'elsewhere': 'too little yet to rule out another place on this plan',
}
_TIMES = {1: 'once', 2: 'twice'}


@dataclass(frozen=True, eq=False)
class Circumstances:
    """
    What a reason needs beside the verdict of one look.

    Parameters
    ----------
    walls_m : length of the walls seen [m]
    accept_probability : what a claim takes
    at : (P, 2) points of the submap at which placements are compared [m], their mean in the middle
    scales : smallest and largest mean scale that a placement might have; 0 and infinity where
        nobody has stated one
    is_claimed, is_mirrored : what was decided: a claim, or that the mirror image fits only
    sure_looks : looks in a row, this one counted, that were sure of the best placement
    missing_looks : further ones that a claim takes
    needs_news : those must have seen something new
    storey : where the best placement is, of a site with several; else empty
    rival_storey : another storey, the share of the walls that its best placement explains, and the
        probability of that one
    unsearched : other storeys that are still to be searched
    unseen_m : estimate of the drawn walls that are still to be seen [m]
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
    rival_storey: tuple[str, float, float] | None = None
    unsearched: int = 0
    unseen_m: float = math.inf


def reason_of(posterior: Posterior, look: Circumstances) -> str:
    """Return what decides: one sentence, never empty."""
    if look.is_mirrored:
        return MIRRORED
    if look.is_accepted and len(posterior.placements):
        on = f'storey {look.storey}: ' if look.storey else ''
        return on + '; '.join(
            [
                _explained(posterior, look),
                _rival(posterior, look),
                *_other_storey(look),
                *_scaled(posterior, look),
            ]
        )
    if len(posterior.placements) and posterior.best >= look.accept_probability:
        return _unconfirmed(look)
    return _undecided(posterior, look)


def waiting(seen_m2: float, needed_m2: float) -> str:
    """Say how much of the floor that a look takes has been seen."""
    return f'only {math.floor(seen_m2)} of {math.ceil(needed_m2)} m² of floor seen so far'


def anew(why: str) -> str:
    """Say that, and why, everything seen was forgotten."""
    return f'starting anew: {why}'


def _undecided(posterior: Posterior, look: Circumstances) -> str:
    """Name what holds the probability that the best placement lacks."""
    is_little = look.walls_m < FEW_WALLS_M
    little = f'only {metres(look.walls_m)} of wall seen so far'
    if not len(posterior.placements):
        return little if is_little else 'nothing on the floorplan fits what was seen'
    placed = float(posterior.placements.probability.sum())
    held = {
        'rivals': placed - posterior.best if len(posterior.placements) > 1 else 0.0,
        'elsewhere': posterior.none - posterior.mirror,
        'mirror': posterior.mirror,
        'foreign': posterior.foreign,
        'storeys': posterior.elsewhere,
    }
    by = max(held, key=lambda name: held[name])
    if by == 'foreign' and placed >= posterior.foreign and _is_alike(posterior):
        by = 'rivals'  # they share what one place alone would hold against another building
    if by == 'storeys' and not is_little:
        return _between_storeys(posterior, look)
    if by == 'rivals':
        first = little if is_little else _explained(posterior, look)
        parting = [] if is_little else _parting(posterior, look)
        return '; '.join([first, _rival(posterior, look), *parting, *_scaled(posterior, look)])
    if is_little:
        return little
    if by in _TOO_LITTLE and _explains_well(posterior, look):
        explained = f'{percent(_shares(posterior)[0])} of {metres(look.walls_m)} of wall'
        return f'explains {explained}{_bent(posterior)}: {_TOO_LITTLE[by]}'
    return f'{_explains(posterior, look)}: {_doubt(by, posterior, look)}'


def _is_alike(posterior: Posterior) -> bool:
    """Tell whether the two most probable places explain the walls alike."""
    if len(posterior.placements) < 2:
        return False
    best, other = _shares(posterior)[:2]
    return bool(other >= best - AS_WELL)


def _between_storeys(posterior: Posterior, look: Circumstances) -> str:
    """Say that other storeys fit, too, and whether the place on them is sure."""
    is_place_sure = posterior.best + posterior.elsewhere >= _PLACE_SURE
    sure = 'sure of the place, not of the storey: ' if is_place_sure else ''
    here = f'{_explained(posterior, look)} on storey {look.storey}'
    return '; '.join([f'{sure}{here}', *_other_storey(look)])


def _other_storey(look: Circumstances) -> list[str]:
    """Return what the strongest other storey explains; nothing without one."""
    if look.rival_storey is None:
        return []
    name, share, probability = look.rival_storey
    return [f'storey {name} explains {percent(share)} (p {probability:.2f})']


def _explains_well(posterior: Posterior, look: Circumstances) -> bool:
    """Tell whether nothing speaks against the best placement but how little was seen."""
    is_there = float(posterior.evidence.of('denied')[0]) < _MISSING
    return bool(
        _shares(posterior)[0] >= EXPLAINED_WELL and is_there and not _scale(posterior, look)
    )


def _doubt(by: str, posterior: Posterior, look: Circumstances) -> str:
    """Return what else may be the case: ``by`` is what holds the most probability."""
    is_at_edge = bool(_scale(posterior, look))
    if by == 'mirror':
        how = 'better' if posterior.mirror > posterior.best else 'as well'
        return f"the floorplan's mirror image fits {how}"
    if by == 'foreign':
        return 'another scale, or another building?' if is_at_edge else 'another building?'
    elsewhere = 'what was seen may lie elsewhere on this plan'
    return f'another scale, or {elsewhere}' if is_at_edge else elsewhere


def _unconfirmed(look: Circumstances) -> str:
    """Say what a placement that is sure enough still lacks."""
    if look.unsearched and not look.missing_looks:
        storeys = 'storey' if look.unsearched == 1 else 'storeys'
        return f'sure, but not yet compared with {look.unsearched} other {storeys}'
    if not look.missing_looks:
        return "sure, but not yet compared with the floorplan's mirror image"
    times = _TIMES.get(look.sure_looks, f'{look.sure_looks} times')
    looks = 'look' if look.missing_looks == 1 else 'looks'
    news = ' with something new' if look.needs_news else ''
    return f'sure, but seen {times}: needs {look.missing_looks} more {looks}{news}'


def _explained(posterior: Posterior, look: Circumstances) -> str:
    return (
        f'{percent(_shares(posterior)[0])} of {metres(look.walls_m)} of wall '
        f'explained{_bent(posterior)}'
    )


def _explains(posterior: Posterior, look: Circumstances) -> str:
    scale = _scale(posterior, look)
    missing = float(posterior.evidence.of('denied')[0])
    parts = [f'explains {percent(_shares(posterior)[0])} of the walls{_bent(posterior)}']
    if scale:
        parts.append(f'at {scale}')
    if missing >= _MISSING:
        parts.append(f'but {percent(missing)} of those drawn there are missing')
    return ', '.join(parts)


def _rival(posterior: Posterior, look: Circumstances) -> str:
    """Return where the most probable rival is and how much it explains."""
    if len(posterior.placements) < 2:
        return 'no rival was found'
    best, other = _shares(posterior)[:2]
    said = f'the best rival, {_where(posterior, look)}, explains {percent(other)}'
    missing = posterior.evidence.of('denied')
    if round(100 * other) >= round(100 * best) and missing[1] - missing[0] >= _MISSING:
        said += f', but {percent(float(missing[1]))} of the walls drawn there are missing'
    return said


def _where(posterior: Posterior, look: Circumstances) -> str:
    """Return how the rival lies to the best placement, as seen from there."""
    placed = posterior.placements.take(slice(2))
    middle = placed.apply(look.at.mean(axis=0, keepdims=True))[:, 0]
    x, y = middle[1] - middle[0]
    heading = placed.heading
    turn = abs(math.remainder(heading[1] - heading[0], math.tau))
    parts = []
    if (apart_m := round(math.hypot(x, y))) >= 1:
        sector = round(math.atan2(y, x) / (math.tau / len(_DIRECTIONS))) % len(_DIRECTIONS)
        parts.append(f'{apart_m} m {_DIRECTIONS[sector]}')
    if turn >= _TURNED_RAD:
        parts.append(f'turned by {round(math.degrees(turn))} degrees')
    return ' and '.join(parts) or 'in nearly the same place'


def _parting(posterior: Posterior, look: Circumstances) -> list[str]:
    """
    Say how much more wall would part the best placement from its rival, if that can be told.

    Walls speak in proportion to their length: what the contested ones have gained in log odds is
    what as many more would gain. Nothing is said where the plan has fewer left.
    """
    contested_m = _contested_m(posterior, look.walls_m)
    best, other = posterior.placements.probability[:2]
    supports = posterior.evidence.of('support')
    if contested_m < NOISE_M or not best > other > 0.0 or supports[0] <= supports[1]:
        return []
    needed = math.log(look.accept_probability / (1.0 - look.accept_probability))
    more = needed / math.log(best / other) - 1.0
    if not 0.0 < more <= _FARTHEST:
        return []
    more_m = max(more * contested_m, 1.0)
    if more_m > look.unseen_m:
        return []
    return [f'{metres(more_m)} more of wall where they differ would part them']


def _contested_m(posterior: Posterior, walls_m: float) -> float:
    """Return the length of wall on which the two best differ [m]; 0 where it is not known."""
    figures, support = posterior.evidence, posterior.evidence.of('support').astype(np.float64)
    bent = figures.of('bent_support').astype(np.float64)
    for one, other in ((0, 1), (1, 0)):
        # Each placement's figures are against its strongest rival, whoever that is.
        told = [float(figures.of(name)[one]) for name in ('rival_net', 'rival_bent_net')]
        net = [(each[one] - each[other]) * walls_m for each in (support, bent)]
        if all(
            abs(math.copysign(math.expm1(abs(log)), log) - exact) <= _PAIR_M
            for log, exact in zip(told, net, strict=True)
        ):
            return math.expm1(float(figures.of('rival_contested')[one]))
    return 0.0


def _scaled(posterior: Posterior, look: Circumstances) -> list[str]:
    scale = _scale(posterior, look)
    return [f'the walls fit at {scale}'] if scale else []


def _scale(posterior: Posterior, look: Circumstances) -> str:
    """Return the best placement's scale where it is at the edge of what was searched."""
    (low, high), scale = look.scales, float(posterior.placements.scale[0])
    edge = 1.0 + AT_EDGE
    if not 0.0 < low * edge**2 < high < math.inf or low * edge < scale < high / edge:
        return ''
    said = f'{scale:.2f} times the stated scale'
    if not low / edge < scale < high * edge:
        return said  # what was stated was doubted
    limit = 'least' if scale <= low * edge else 'most'
    return f'{said}, the {limit} that was searched'


def _bent(posterior: Posterior) -> str:
    if not _is_bent(posterior):
        return ''
    return f' with the drawing bent by {float(posterior.evidence.of("bend_m")[0]):.1f} m'


def _is_bent(posterior: Posterior) -> bool:
    return float(posterior.evidence.of('bend_gain')[0]) >= _BENT


def _shares(posterior: Posterior) -> Array:
    """Return the share of the walls that each placement explains, ``(C,)``."""
    name = 'bent_support' if _is_bent(posterior) else 'support'
    return np.asarray(posterior.evidence.of(name), np.float64)


def percent(share: float) -> str:
    """Return a share as people read it."""
    return f'{round(100 * share)} %'


def metres(length_m: float) -> str:
    """Return a length as people read it."""
    return f'{round(length_m)} m'
