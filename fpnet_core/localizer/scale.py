# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scale of a floorplan: which scales are searched, the estimate, and when it is locked.

A drawing is a building times a symmetric stretch ``P (2, 2)`` in the drawing's own axes, plan
metres per submap metre. The stretch is constant: once accepted placements agree on it over
enough of the building, it is not searched again.
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

# Numerical: ratio between neighbouring scales; refinement covers the rest.
_SCALE_STEP = 0.06
# Chosen, not measured:
_INTERVALS_TRIED = 1.25  # times the 90 % interval, which misses one scale in ten
_MOST_TRIED = 2.2  # largest factor that is searched, however uncertain the scale
_STATED_SCATTER = 0.010
"""
Stated scales are usually right and sometimes far off: their log errors follow
a Cauchy distribution of this width. Fitted to the drawings of the development split
(``benchmarks/stated_scales.py``); under a Gaussian they would be a thousand times less probable.
"""
_WIDE_LOG_ERROR = 0.27  # largest log error searched; one stated scale in forty is further off
_KNOWN_STRAIN = 0.01  # drawing accuracy if the scale is known
_LOCK_UPDATES = 5  # accepted updates whose estimates are compared
_LOCK_SIGMA = 0.01  # relative standard deviation required along the less certain axis
_DRAWING_SIGMA_M = 0.1  # error of walls in a good drawing; more walls do not reduce it


@dataclass(frozen=True, eq=False)
class ScaleSearch:
    """
    Stretches to try, and the prior for leaving them in refinement.

    ``stretches (L, 2, 2)`` are symmetric, plan metres per submap metre; ``anisotropy_sigma`` is
    the standard deviation of the strain added by refinement. ``bounds`` are the smallest and
    largest mean scale of a placement. ``wide_scales`` is searched beyond them as
    well, with ``log_odds`` [nats] of a stated scale being so far off; ``as_stated`` is without.
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
        """Prior for refinement around the stretches."""
        known = self.stretches[0] if len(self) == 1 else None
        return AlignmentPrior(self.anisotropy_sigma, known, self.bounds)

    @property
    def factors(self) -> Array:
        """Mean scale of each stretch, ``(L,)``."""
        return scale_of(self.stretches)

    @property
    def log_range(self) -> float:
        """Logarithm of the largest over the smallest mean scale."""
        return float(np.log(self.factors.max() / self.factors.min()))

    @property
    def as_stated(self) -> ScaleSearch:
        """The search without the wide scale prior."""
        return replace(self, wide_scales=None)

    def is_within(self, scale: Array | float) -> NDArray[np.bool_]:
        """Return whether mean scales ``(C,)``, or one, lie strictly within the bounds."""
        low, high = self.bounds
        return np.asarray((scale > low * (1.0 + AT_EDGE)) & (scale < high / (1.0 + AT_EDGE)))

    @classmethod
    def of_factors(cls, factors: Array, anisotropy_sigma: float) -> ScaleSearch:
        """Return the search of isotropic scales ``factors (L,)``."""
        return cls(factors[:, None, None] * np.eye(2), anisotropy_sigma)


def allowed_scales(scale_tolerance: float) -> Array:
    """Return scales in geometric steps around 1 that cover the tolerance, 1 included."""
    steps = int(np.ceil(np.log1p(scale_tolerance) / _SCALE_STEP - 0.5))
    return np.asarray(np.exp(_SCALE_STEP * np.arange(-steps, steps + 1)), dtype=np.float64)


def tolerant_search(scale_tolerance: float, config: PoseConfig) -> ScaleSearch:
    """Return the search over all scales within a tolerance around 1."""
    factors = allowed_scales(scale_tolerance)
    search = ScaleSearch.of_factors(factors, config.anisotropy_sigma)
    return replace(search, bounds=(float(factors[0]), float(factors[-1])))


def doubting(search: ScaleSearch, config: PoseConfig) -> ScaleSearch:
    """Return a search within a tolerance, extended by a wide scale prior."""
    farthest = tolerant_search(float(np.expm1(_WIDE_LOG_ERROR)), config)
    tolerated, reach = (np.log(each.bounds[1]) for each in (search, farthest))
    if reach <= tolerated:
        return search
    within, in_reach = (np.arctan(each / _STATED_SCATTER) for each in (tolerated, reach))
    return replace(search, wide_scales=farthest, log_odds=float(np.log(in_reach / within - 1.0)))


def estimated_search(plan: ScaleEstimate, sub: ScaleEstimate, config: PoseConfig) -> ScaleSearch:
    """
    Return the search between two maps converted to metres by the medians of their scales.

    The two intervals are combined as independent. These scales are not stated, so
    placements that fit beyond the searched range are accepted as well.
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
    Scale of one floorplan over time, from the first search to the lock.

    Parameters
    ----------
    first
        Search of the first update.
    is_fixed
        The scale is trusted and never updated.
    seen
        Stretches ``(2, 2)`` of the last accepted updates.
    estimate
        Estimate from them; None before the first.
    is_beyond_stated
        A placement beyond the stated range was accepted.
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
        Return the initial history of a floorplan.

        ``trusted`` tries the stated scale only; ``approximate`` all within ``scale_tolerance``;
        ``unknown`` the interval of the drawing's ``estimate`` by its rooms and doors.
        """
        return cls(first_search(policy, config, estimate), policy == 'trusted')

    @property
    def search(self) -> ScaleSearch:
        """Search for the next update."""
        if self.estimate is not None and self.estimate.is_locked:
            return ScaleSearch(self.estimate.stretch[None], _KNOWN_STRAIN)
        if self.is_beyond_stated and self.first.wide_scales is not None:
            return self.first.wide_scales
        return self.first

    @property
    def tolerated(self) -> tuple[float, float]:
        """Smallest and largest mean scale that agree with the stated one."""
        return self.first.bounds

    def forgotten(self) -> ScaleHistory:
        """Return the initial history: the pose was lost, perhaps because of a wrong scale."""
        return ScaleHistory(self.first, self.is_fixed)

    def arrays(self, factor: float) -> dict[str, Array]:
        """
        Return the estimates from accepted placements, for a file.

        ``factor`` is working metres per nominal metre; the result is in nominal metres.
        """
        seen = np.array(self.seen).reshape(-1, 2, 2) / factor
        sigma, is_locked = (0.0, False) if self.estimate is None else (
            self.estimate.sigma, self.estimate.is_locked
        )  # fmt: skip
        return {'seen': seen, 'known': np.array([sigma, is_locked, self.is_beyond_stated], float)}

    @staticmethod
    def check(arrays: dict[str, Array]) -> None:
        """Raise ValueError or KeyError unless arrays are empty or those of a history."""
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
        """Return the history restored from :meth:`arrays` of the same floorplan."""
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
        Return the history extended by the accepted placement of an update.

        ``walls (P, 2)`` are the submap's [m]: the larger their extent, the better the estimate.
        ``deformation_m`` is the deformation of the drawing under the placement: local errors
        of that size limit the accuracy of the overall scale.
        """
        if self.is_fixed or (self.estimate is not None and self.estimate.is_locked):
            return self
        seen = (*self.seen, A_plan_submap.stretch)[-_LOCK_UPDATES:]
        mean = np.mean(seen, axis=0)
        off_m = max(_DRAWING_SIGMA_M, deformation_m)
        sigma = max(_scatter(seen, mean), off_m / _extent_m(A_plan_submap, walls))
        return replace(
            self,
            seen=seen,
            estimate=PlanScale(mean, sigma, len(seen) == _LOCK_UPDATES and sigma <= _LOCK_SIGMA),
            is_beyond_stated=self.is_beyond_stated
            or not self.first.is_within(A_plan_submap.scale),
        )


def _scatter(seen: tuple[Array, ...], mean: Array) -> float:
    """Return the relative standard deviation of stretches along the less certain axis."""
    return float(np.std([np.diag(s) for s in seen], axis=0).max() / mean.max())


def first_search(
    policy: ScalePolicy, config: PoseConfig, estimate: ScaleEstimate = STATED_SCALE
) -> ScaleSearch:
    """Return the first search of a policy; ``unknown`` uses the plan's ``estimate``."""
    if policy == 'trusted':
        return ScaleSearch.of_factors(np.ones(1), min(_KNOWN_STRAIN, config.anisotropy_sigma))
    if policy == 'approximate':
        return doubting(tolerant_search(config.scale_tolerance, config), config)
    return estimated_search(estimate, STATED_SCALE, config)


def _extent_m(A_plan_submap: Affine2D, walls: Array) -> float:
    """Return the extent of the walls along the plan's shorter axis, which limits accuracy [m]."""
    placed = A_plan_submap.apply(walls)
    return max(float(np.ptp(placed, axis=0).min()), _DRAWING_SIGMA_M)
