# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Findings about a run without a pose, from which its causes are derived."""

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
"""Chosen: probabilities of a placement found by a further test, at which its cause counts as
proved, likely, or possible."""

FEWEST_HZ = 4.0
"""Scans per second that scan matching needs: a robot turns by 15 degrees in between. Chosen."""

_MUCH_SHARE = 0.25  # chosen: share of the plan's floor that is enough to be localized
_EARLY_MARGIN = 0.05  # chosen: a short piece of wall is less reliable
_MUCH_M2 = 60.0  # physical: three rooms, enough to be localized


@dataclass(frozen=True)
class Fit:
    """Best placement of a search: its probability, share of walls explained, and mean scale."""

    probability: float
    explained: float
    scale: float

    @classmethod
    def of(cls, posterior: Posterior) -> Fit | None:
        """Return the best placement of a posterior; None if there is none."""
        if not len(posterior.placements):
            return None
        explained = float(_explained(posterior)[0])
        return cls(posterior.best, explained, float(posterior.placements.scale[0]))


@dataclass(frozen=True)
class DoubleWalls:
    """
    Displacement between two observations of the same walls.

    They differ by ``shift_m`` and ``turn_deg`` after ``path_m`` of driving; ``before`` and
    ``after`` are the shares of them on the first observation before and after correction.
    """

    shift_m: float
    turn_deg: float
    path_m: float
    before: float
    after: float


@dataclass(frozen=True)
class TurningWalls:
    """Walls whose direction turns steadily, by ``turn_deg`` in total over ``path_m``."""

    turn_deg: float
    path_m: float


@dataclass(frozen=True)
class Sensed:
    """
    Findings from the scans alone.

    ``is_upside_down``: the apparent ceiling is the floor. ``matched_hz`` is the rate of scans if
    scan matching is the only odometry; infinite otherwise.
    """

    is_upside_down: bool = False
    matched_hz: float = math.inf

    @property
    def are_rare(self) -> bool:
        """Whether scans are too infrequent for scan matching."""
        return self.matched_hz < FEWEST_HZ


@dataclass(frozen=True)
class Findings:
    """
    Everything known about a run without a pose.

    Parameters
    ----------
    walls_m, seen_m2 : observed walls and floor
    plan_m2 : floor of the plan; 0 without a plan
    needed_m2 : floor that the first update needs
    best : of the search as configured
    alike : shares of the walls that the best placement and all similar ones explain, best first
    alike_probability : sum over these placements
    storeys_alike : probabilities of storeys that cannot be told apart, by name
    scales : smallest and largest that was searched, in ``best``'s unit
    resolution_m : of the drawing's pixels, in the metres that ``scales`` refer to
    is_mirrored : only the mirror image fits, decided over several updates
    rescaled : best over a much wider range of scales; None if not tested
    mirror : best on the plan's mirror image; None if not tested
    doubts : parser warnings about the drawing
    storeys, storey : number on the sheet, and the selected one
    drift : None if the walls agree with each other where they were observed twice
    early : best of the first metres, on which odometry hardly drifts; None if not tested
    contradictions : updates in which the newest walls contradicted the pose
    restarts : number of restarts of the submap, including those by contradictions
    is_blind : scans were received, but none of them contained a wall
    scale_conflict : scale by the plan's rooms, doors and walls if it contradicts the stated one
    says_scale : the drawing's resolution can be derived from the fit, since the robot's map is
        in metres
    driven_m : by odometry, while the submap grew; infinite if unknown
    sensed : findings from the scans alone
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
        """Whether the observations would suffice to recognise a correct plan."""
        share = self.seen_m2 / self.plan_m2 if self.plan_m2 else 0.0
        return self.walls_m >= FEW_WALLS_M and (share >= _MUCH_SHARE or self.seen_m2 >= _MUCH_M2)

    @property
    def has_drifted_later(self) -> bool:
        """Whether drift explains nothing, because the part before it fits nowhere either."""
        return self.early is not None and self.early.explained < EXPLAINED_WELL - _EARLY_MARGIN

    @property
    def is_ambiguous(self) -> bool:
        """Whether the robot is in one of several places that look alike."""
        fits = bool(self.alike) and self.alike[0] >= EXPLAINED_WELL
        return len(self.alike) > 1 and (fits or self.alike_probability >= LIKELY)


def alike(posterior: Posterior) -> tuple[tuple[float, ...], float]:
    """Return the shares of walls explained by the best and similar placements, and their sum p."""
    if not len(posterior.placements):
        return (), 0.0
    shares, p = _explained(posterior), posterior.placements.probability
    near = (shares >= shares[0] - AS_WELL) & (p >= POSSIBLE * p[0])
    return tuple(sorted((float(share) for share in shares[near]), reverse=True)), p[near].sum()


def storeys_alike(probable: Mapping[str, float]) -> dict[str, float]:
    """Return the probabilities of storeys that cannot be told apart; empty if one stands out."""
    best = max(probable.values(), default=0.0)
    near = {name: p for name, p in probable.items() if p >= POSSIBLE * best}
    return near if len(near) > 1 and sum(near.values()) >= LIKELY else {}


def _explained(posterior: Posterior) -> NDArray[np.float64]:
    """Return the share of the walls that each placement explains, deformed or not, ``(C,)``."""
    figures = posterior.evidence
    return np.maximum(figures.of('support'), figures.of('bent_support')).astype(np.float64)
