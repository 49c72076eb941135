# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a run without an answer, from which its causes are told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.scoring.reasons import AS_WELL, EXPLAINED_WELL, FEW_WALLS_M
from fpnet_core.scoring.scorer import Posterior
from fpnet_core.segmentation import ScaleEstimate

PROVED, LIKELY, POSSIBLE = 0.9, 0.5, 0.1
"""Chosen: how probable a placement of another look is for its cause to be proved, likely, or
worth a word."""

FEWEST_HZ = 4.0
"""Scans a second that can be matched: a robot turns by 15 degrees in between. Chosen."""

_MUCH_SHARE = 0.25  # chosen: of the plan's floor; who has seen as much has seen enough
_EARLY_MARGIN = 0.05  # chosen: little wall tells less
_MUCH_M2 = 60.0  # physical: three rooms; who has seen as much has seen enough


@dataclass(frozen=True)
class Fit:
    """The best placement of a look: its probability, share of the walls explained, mean scale."""

    probability: float
    explained: float
    scale: float

    @classmethod
    def of(cls, posterior: Posterior) -> Fit | None:
        """Return that of a verdict, None where there is no placement."""
        if not len(posterior.placements):
            return None
        explained = float(_explained(posterior)[0])
        return cls(posterior.best, explained, float(posterior.placements.scale[0]))


@dataclass(frozen=True)
class DoubleWalls:
    """
    How walls that were seen again lie beside where they were first seen.

    They are ``shift_m`` and ``turn_deg`` off after ``path_m`` of driving; ``before`` and ``after``
    are the shares of them on first walls before and after that is undone.
    """

    shift_m: float
    turn_deg: float
    path_m: float
    before: float
    after: float


@dataclass(frozen=True)
class TurningWalls:
    """Walls whose direction turns steadily, by ``turn_deg`` in all over ``path_m``."""

    turn_deg: float
    path_m: float


@dataclass(frozen=True)
class Sensed:
    """
    What the scans themselves tell.

    ``is_upside_down``: what looks like the ceiling is the floor. ``matched_hz`` is how often scans
    come that alone tell the robot's motion; infinite where there is other odometry.
    """

    is_upside_down: bool = False
    matched_hz: float = math.inf

    @property
    def are_rare(self) -> bool:
        """Tell whether scans come too rarely to be matched with each other."""
        return self.matched_hz < FEWEST_HZ


@dataclass(frozen=True)
class Findings:
    """
    What is known of a run without an answer.

    Parameters
    ----------
    walls_m, seen_m2 : walls and floor seen
    plan_m2 : floor of the plan; 0 where there is none yet
    needed_m2 : floor that a first look takes
    best : of the search as it was configured
    alike : shares of the walls that the best and all places like it explain, best first
    alike_probability : of all these places together
    storeys_alike : probabilities of storeys that nothing tells apart, by name
    scales : smallest and largest that was searched, in ``best``'s unit
    resolution_m : of the drawing's pixels, in the metres that ``scales`` refer to
    is_mirrored : the mirror image alone fits, as was decided over time
    rescaled : best over a much wider range of scales; None where nobody has looked
    mirror : best on the plan's mirror image; None where nobody has looked
    doubts : what speaks against the reading of the drawing
    storeys, storey : on the sheet, and which of them it was
    drift : None where the walls agree with each other, as far as they were seen twice
    early : best of the first metres, on which odometry hardly drifts; None where nobody has looked
    contradictions : looks at which the newest walls did not fit a claim
    restarts : times that the submap began anew, those of contradictions among them
    is_blind : scans have come, and none of them has shown a wall
    denial : what the drawing's rooms, doors and walls say where they deny the scale stated
    says_scale : the drawing's resolution can be told from what was found: the robot's map is
        in metres
    driven_m : by odometry, while the submap grew; infinite where nobody knows
    sensed : what the scans themselves tell
    """

    walls_m: float
    seen_m2: float
    plan_m2: float = 0.0
    needed_m2: float = 0.0
    best: Fit | None = None
    alike: tuple[float, ...] = ()
    scales: tuple[float, float] = (0.0, math.inf)
    resolution_m: float = 0.0
    is_mirrored: bool = False
    rescaled: Fit | None = None
    mirror: Fit | None = None
    doubts: tuple[str, ...] = ()
    storeys: int = 1
    storey: int | None = None
    drift: DoubleWalls | TurningWalls | None = None
    early: Fit | None = None
    contradictions: int = 0
    restarts: int = 0
    is_blind: bool = False
    scale_conflict: ScaleEstimate | None = None
    says_scale: bool = True
    driven_m: float = math.inf
    alike_probability: float = 0.0
    storeys_alike: Mapping[str, float] = field(default_factory=dict)
    sensed: Sensed = Sensed()

    @property
    def has_seen_much(self) -> bool:
        """Tell whether a right plan would have been recognised by now."""
        share = self.seen_m2 / self.plan_m2 if self.plan_m2 else 0.0
        return self.walls_m >= FEW_WALLS_M and (share >= _MUCH_SHARE or self.seen_m2 >= _MUCH_M2)

    @property
    def has_drifted_later(self) -> bool:
        """Tell whether drift explains nothing: what was seen before it fits nowhere, either."""
        return self.early is not None and self.early.explained < EXPLAINED_WELL - _EARLY_MARGIN

    @property
    def is_ambiguous(self) -> bool:
        """Tell whether the robot is in one of several places that are alike."""
        fits = bool(self.alike) and self.alike[0] >= EXPLAINED_WELL
        return len(self.alike) > 1 and (fits or self.alike_probability >= LIKELY)


def alike(posterior: Posterior) -> tuple[tuple[float, ...], float]:
    """Return what the best placement and all like it explain of the walls, and are probable by."""
    if not len(posterior.placements):
        return (), 0.0
    shares, p = _explained(posterior), posterior.placements.probability
    near = (shares >= shares[0] - AS_WELL) & (p >= POSSIBLE * p[0])
    return tuple(sorted((float(share) for share in shares[near]), reverse=True)), p[near].sum()


def storeys_alike(probable: Mapping[str, float]) -> dict[str, float]:
    """Return the probabilities of storeys that nothing tells apart; none of storeys unlike."""
    best = max(probable.values(), default=0.0)
    near = {name: p for name, p in probable.items() if p >= POSSIBLE * best}
    return near if len(near) > 1 and sum(near.values()) >= LIKELY else {}


def _explained(posterior: Posterior) -> NDArray[np.float64]:
    """Return the share of the walls that each placement explains, bent or not, ``(C,)``."""
    figures = posterior.evidence
    return np.maximum(figures.of('support'), figures.of('bent_support')).astype(np.float64)
