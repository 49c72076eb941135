# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How large a floorplan is drawn: what is tried, what was found, and when that is settled.

A drawing is a building times a symmetric stretch ``P (2, 2)`` in the drawing's own axes, plan
metres per submap metre. It is a property of the drawing: once claimed placements agree on it over
enough of the building, it need not be asked again of every tick.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import PoseConfig, ScalePolicy
from fpnet_core.geometry import Affine2D, scale_of
from fpnet_core.pose import AlignmentPrior
from fpnet_core.scoring.reasons import AT_EDGE
from fpnet_core.segmentation import STATED_SCALE, ScaleEstimate
from fpnet_core.types import PlanScale

Array = NDArray[np.float64]

# Numerical: neighbouring scales differ by this share; refinement closes the rest.
_SCALE_STEP = 0.06
# Chosen, not measured:
_INTERVALS_TRIED = 1.25  # times the 90 % interval: one scale in ten lies outside of it
_MOST_TRIED = 2.2  # beyond this factor nothing is tried, however little is known
_STATED_SCATTER = 0.010
"""
Stated scales are mostly right and now and then far off: their errors, as logarithms, scatter like
a Cauchy distribution of this width. Fitted to the tune half's drawings (``benchmarks/
stated_scales.py``); of a Gaussian they would be a thousand times less probable.
"""
_MISSTATED = 0.27  # in its logarithm: one stated scale in forty is further off, and not found
_KNOWN_STRAIN = 0.01  # a drawing of known scale is still not drawn to the millimetre
_LOCK_TICKS = 5  # claimed ticks whose estimates are compared
_LOCK_SIGMA = 0.01  # relative standard deviation along the less certain axis
_DRAWING_SIGMA_M = 0.1  # by how much a wall of a good drawing may be off, however many agree


@dataclass(frozen=True, eq=False)
class ScaleSearch:
    """
    The stretches to try, and how far refinement may leave each.

    ``stretches (L, 2, 2)`` are symmetric, plan metres per submap metre; ``anisotropy_sigma`` is
    the standard deviation of what refinement adds. ``bounds`` are the smallest and largest mean
    scale that a placement may have. ``wide_scales`` is what is tried beyond them where nothing
    within them is accepted, at ``log_odds`` [nats] of a stated scale being so far off.
    """

    stretches: Array
    anisotropy_sigma: float
    bounds: tuple[float, float] = (0.0, np.inf)
    wide_scales: ScaleSearch | None = None
    log_odds: float = 0.0

    def __len__(self) -> int:
        """Count the stretches."""
        return len(self.stretches)

    @property
    def alignment_prior(self) -> AlignmentPrior:
        """How far refinement may leave what is tried."""
        known = self.stretches[0] if len(self) == 1 else None
        return AlignmentPrior(self.anisotropy_sigma, known, self.bounds)

    @property
    def factors(self) -> Array:
        """Return the mean scale of each stretch, ``(L,)``."""
        return scale_of(self.stretches)

    @property
    def log_range(self) -> float:
        """Logarithm of the largest over the smallest mean scale."""
        return float(np.log(self.factors.max() / self.factors.min()))

    @property
    def as_stated(self) -> ScaleSearch:
        """Return the search that does not doubt what was stated."""
        return replace(self, wide_scales=None)

    def is_within(self, scale: Array | float) -> NDArray[np.bool_]:
        """Tell whether mean scales ``(C,)``, or one, lie within the bounds, not held there."""
        low, high = self.bounds
        return np.asarray((scale > low * (1.0 + AT_EDGE)) & (scale < high / (1.0 + AT_EDGE)))

    @classmethod
    def of_factors(cls, factors: Array, anisotropy_sigma: float) -> ScaleSearch:
        """Return the search of isotropic scales ``factors (L,)``."""
        return cls(factors[:, None, None] * np.eye(2), anisotropy_sigma)


def allowed_scales(scale_tolerance: float) -> Array:
    """Scales to try, geometric steps around 1 that cover the tolerance; always holds 1."""
    steps = int(np.ceil(np.log1p(scale_tolerance) / _SCALE_STEP - 0.5))
    return np.asarray(np.exp(_SCALE_STEP * np.arange(-steps, steps + 1)), dtype=np.float64)


def tolerant_search(scale_tolerance: float, config: PoseConfig) -> ScaleSearch:
    """Return the search of all scales within a tolerance around 1, and of none beyond."""
    factors = allowed_scales(scale_tolerance)
    search = ScaleSearch.of_factors(factors, config.anisotropy_sigma)
    return replace(search, bounds=(float(factors[0]), float(factors[-1])))


def doubting(search: ScaleSearch, config: PoseConfig) -> ScaleSearch:
    """Return a search within a tolerance that also knows what to try if the scale is misstated."""
    farthest = tolerant_search(float(np.expm1(_MISSTATED)), config)
    tolerated, reach = (np.log(each.bounds[1]) for each in (search, farthest))
    if reach <= tolerated:
        return search
    within, in_reach = (np.arctan(each / _STATED_SCATTER) for each in (tolerated, reach))
    return replace(search, wide_scales=farthest, log_odds=float(np.log(in_reach / within - 1.0)))


def estimated_search(plan: ScaleEstimate, sub: ScaleEstimate, config: PoseConfig) -> ScaleSearch:
    """
    Return the search between two maps that were brought to metres by their scales' medians.

    Both intervals are combined as independent ones are. Nobody has stated these scales, and
    placements that fit beyond what is tried are good ones.
    """
    smaller = np.hypot(np.log(plan.high / plan.factor), np.log(sub.factor / sub.low))
    larger = np.hypot(np.log(plan.factor / plan.low), np.log(sub.high / sub.factor))
    down, up = (
        int(np.ceil(min(_INTERVALS_TRIED * reach, np.log(_MOST_TRIED)) / _SCALE_STEP - 0.5))
        for reach in (smaller, larger)
    )
    factors = np.exp(_SCALE_STEP * np.arange(-down, up + 1))
    return ScaleSearch.of_factors(factors, config.anisotropy_sigma)


@dataclass(frozen=True, eq=False)
class ScaleHistory:
    """
    What is known of the scale of one floorplan, from the first search to the lock.

    Parameters
    ----------
    first
        What the first tick tries.
    is_fixed
        Nothing that is found changes it.
    seen
        Stretches ``(2, 2)`` of the last claimed ticks.
    estimate
        What they say; None before the first.
    is_misstated
        A claim stands beyond what was stated.
    """

    first: ScaleSearch
    is_fixed: bool = False
    seen: tuple[Array, ...] = ()
    estimate: PlanScale | None = None
    is_beyond_stated: bool = False

    @classmethod
    def begun(
        cls, policy: ScalePolicy, config: PoseConfig, estimate: ScaleEstimate = STATED_SCALE
    ) -> ScaleHistory:
        """
        Return the history of a floorplan that nobody has claimed anything on.

        ``trusted`` tries the stated scale only; ``approximate`` all within ``scale_tolerance``;
        ``unknown`` what the drawing's ``estimate``, by its rooms and doors, holds possible.
        """
        return cls(first_search(policy, config, estimate), policy == 'trusted')

    @property
    def search(self) -> ScaleSearch:
        """What the next tick should try."""
        if self.estimate is not None and self.estimate.is_locked:
            return ScaleSearch(self.estimate.stretch[None], _KNOWN_STRAIN)
        if self.is_beyond_stated and self.first.wide_scales is not None:
            return self.first.wide_scales
        return self.first

    @property
    def tolerated(self) -> tuple[float, float]:
        """Smallest and largest mean scale that agree with what was stated."""
        return self.first.bounds

    def forgotten(self) -> ScaleHistory:
        """Return the beginning: a claim was lost, and it may be the scale that was wrong."""
        return ScaleHistory(self.first, self.is_fixed)

    def arrays(self, factor: float) -> dict[str, Array]:
        """
        Return what claims have said, for a file.

        ``factor`` is working metres per nominal one: what is stored is in nominal metres.
        """
        seen = np.array(self.seen).reshape(-1, 2, 2) / factor
        sigma, is_locked = (0.0, False) if self.estimate is None else (
            self.estimate.sigma, self.estimate.is_locked
        )  # fmt: skip
        return {'seen': seen, 'known': np.array([sigma, is_locked, self.is_beyond_stated], float)}

    @staticmethod
    def check(arrays: dict[str, Array]) -> None:
        """Raise ValueError or KeyError where arrays are neither none nor those of a history."""
        if not arrays:
            return
        seen, known = arrays['seen'], arrays['known']
        if seen.shape[1:] != (2, 2) or known.shape != (3,):
            raise ValueError(f'scale: got {seen.shape} and {known.shape}')
        if not (np.isfinite(seen).all() and np.isfinite(known).all()):
            raise ValueError('scale: not finite')
        if (np.linalg.det(seen) <= 0.0).any():
            raise ValueError('scale: not a stretch')

    def remembered(self, arrays: dict[str, Array], factor: float) -> ScaleHistory:
        """Return the history that goes on from :meth:`arrays` of the same floorplan."""
        seen = tuple(arrays['seen'] * factor) if arrays else ()
        if self.is_fixed or not seen:
            return self
        sigma, is_locked, is_beyond_stated = arrays['known']
        estimate = PlanScale(np.mean(seen, axis=0), float(sigma), bool(is_locked))
        return replace(self, seen=seen, estimate=estimate, is_beyond_stated=bool(is_beyond_stated))

    def followed(
        self, A_plan_submap: Affine2D, walls: Array, deformation_m: float = 0.0
    ) -> ScaleHistory:
        """
        Return the history with a tick's claimed placement.

        ``walls (P, 2)`` are the submap's [m]: the wider they lie, the better they measure.
        ``deformation_m`` is how far the drawing is deformed under the placement: local errors
        of that size limit how well the scale of the whole can be known.
        """
        if self.is_fixed or (self.estimate is not None and self.estimate.is_locked):
            return self
        seen = (*self.seen, A_plan_submap.stretch)[-_LOCK_TICKS:]
        mean = np.mean(seen, axis=0)
        off_m = max(_DRAWING_SIGMA_M, deformation_m)
        sigma = max(_scatter(seen, mean), off_m / _extent_m(A_plan_submap, walls))
        return replace(
            self,
            seen=seen,
            estimate=PlanScale(mean, sigma, len(seen) == _LOCK_TICKS and sigma <= _LOCK_SIGMA),
            is_beyond_stated=self.is_beyond_stated
            or not self.first.is_within(A_plan_submap.scale),
        )


def _scatter(seen: tuple[Array, ...], mean: Array) -> float:
    """Return the relative standard deviation of stretches along the worse axis."""
    return float(np.std([np.diag(s) for s in seen], axis=0).max() / mean.max())


def first_search(
    policy: ScalePolicy, config: PoseConfig, estimate: ScaleEstimate = STATED_SCALE
) -> ScaleSearch:
    """Return the search that a policy begins with; ``unknown`` asks the plan's ``estimate``."""
    if policy == 'trusted':
        return ScaleSearch.of_factors(np.ones(1), min(_KNOWN_STRAIN, config.anisotropy_sigma))
    if policy == 'approximate':
        return doubting(tolerant_search(config.scale_tolerance, config), config)
    return estimated_search(estimate, STATED_SCALE, config)


def _extent_m(A_plan_submap: Affine2D, walls: Array) -> float:
    """Extent of the walls along the shorter axis of the plan: where they measure it worse [m]."""
    placed = A_plan_submap.apply(walls)
    return max(float(np.ptp(placed, axis=0).min()), _DRAWING_SIGMA_M)
