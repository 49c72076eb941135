# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How far the localizer's probabilities may be believed, and the constants that make them so.

Each trial compares a robot map with a plan: a generated one with its own and with another
building's, as a tick does, or a real one with its floorplan, as ``fpnet match`` does. What came
out and where the truth lies in it is all that :func:`fpnet_core.localizer.belief.posterior` is
fitted to, by maximum likelihood.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from fpnet_core.config import FpnetConfig, LocalizerConfig
from fpnet_core.evaluation.robot_pairs import BANDS, RobotPair, varied
from fpnet_core.geometry import Affine2D
from fpnet_core.localizer.belief import posterior
from fpnet_core.localizer.maps import MapMatch, match_maps
from fpnet_core.localizer.scale import tolerant_search
from fpnet_core.localizer.sides import MapSide, StageTimer, compare, plan_side
from fpnet_core.matching import RegionMatcher
from fpnet_core.metrics import expected_calibration_error, reliability_bins
from fpnet_core.pose import map_evidence
from fpnet_core.sim.config import SimConfig
from fpnet_core.sim.pairs import PairScene, generate_scene
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import PoseEstimate

RIGHT_M = 1.0
"""A placement is right when it moves the median free point by less than this from the truth."""

REAL_RIGHT_M = 2.0
"""The same for real pairs, whose truth is a fit and whose drawings are distorted."""

FOREIGN_PLANS = 2
"""Each generated map is also compared with so many other buildings' plans."""

_LEAST_PROBABILITY = 1e-6  # of the truth; one hopeless trial must not decide the fit
_FITTED = (
    'evidence_per_m',
    'null_score',
    'null_rise',
    'rival_weight',
    'null_per_log_place',
)
_BOUNDS = ((0.01, 10.0), (0.02, 0.98), (0.0, 20.0), (0.0, 1.0), (0.0, 20.0))


@dataclass(frozen=True, eq=False)
class Trial:
    """
    One comparison: placements' ``scores (K,)``, best first, and what weighs them.

    ``truth`` is the index of the right placement, None where none of them is right;
    ``is_foreign`` marks a plan of another building.
    """

    scores: NDArray[np.float64]
    wall_length_m: float
    places: float
    truth: int | None
    is_foreign: bool

    def probabilities(self, config: LocalizerConfig) -> NDArray[np.float64]:
        """Return the probability of each placement, and last that of none, ``(K + 1,)``."""
        each = posterior(self.scores, self.wall_length_m, self.places, config)
        return np.append(each, 1.0 - each.sum())


@dataclass(frozen=True, eq=False)
class Reliability:
    """
    Claimed against true, in bins of the best placement's probability.

    ``claimed``, ``true`` and ``count`` are ``(10,)``, NaN where a bin is empty. ``ece`` is
    the expected calibration error. Claims are trials at or above the claim probability.
    """

    claimed: NDArray[np.float64]
    true: NDArray[np.float64]
    count: NDArray[np.int64]
    ece: float
    claims: int
    wrong_claims: int
    foreign_trials: int
    foreign_claims: int
    right_best: float


def generated_trials(
    seed: int,
    count: int,
    config: FpnetConfig,
    matcher: RegionMatcher,
    on_pair: Callable[[int], None] = lambda count: None,
) -> list[Trial]:
    """Return the trials of generated pairs: with their own plans, and with those before them."""
    sim = SimConfig()
    trials: list[Trial] = []
    others: deque[MapSide] = deque(maxlen=FOREIGN_PLANS)
    for index in range(count):
        scene = generate_scene(seed, index * sim.pairs_per_plan, sim)
        plan = plan_side(scene.plan_segmentation)
        truth = scene.pair.A_plan_submap
        trials.append(_trial(plan, scene, truth, config, matcher))
        trials += [_trial(other, scene, None, config, matcher) for other in others]
        others.append(plan)
        on_pair(1)
    return trials


def _trial(
    plan: MapSide,
    scene: PairScene,
    truth: Affine2D | None,
    config: FpnetConfig,
    matcher: RegionMatcher,
) -> Trial:
    sub = MapSide(scene.sub_segmentation, scene.pair.sub_graph, map_evidence(scene.submap.grid))
    search = tolerant_search(config.pose.scale_tolerance, config.pose)
    found = compare(
        plan, sub, matcher, scene.submap.free_area_m2, config.pose, StageTimer(), search
    )
    return Trial(
        scores=np.array([estimate.score for estimate in found.estimates]),
        wall_length_m=sub.evidence.wall_length_m,
        places=plan.evidence.free_area_m2 * len(search),
        truth=None
        if truth is None
        else right_placement(found.estimates, truth, sub.evidence.free, RIGHT_M),
        is_foreign=truth is None,
    )


def right_placement(
    estimates: Sequence[PoseEstimate],
    A_plan_submap: Affine2D,
    free: NDArray[np.float64],
    tolerance_m: float,
) -> int | None:
    """Return the index of the first estimate that moves ``free (F, 2)`` as the truth does."""
    placed = A_plan_submap.apply(free)
    for index, estimate in enumerate(estimates):
        moved = estimate.A_plan_submap.apply(free) - placed
        if np.median(np.linalg.norm(moved, axis=1)) < tolerance_m:
            return index
    return None


def split_buildings(
    pairs: Sequence[RobotPair],
) -> tuple[tuple[RobotPair, ...], tuple[RobotPair, ...]]:
    """Return the pairs to fit to, and every third building's, held back to measure on."""
    buildings = sorted({pair.building for pair in pairs})
    held_back = set(buildings[2::3])
    return (
        tuple(pair for pair in pairs if pair.building not in held_back),
        tuple(pair for pair in pairs if pair.building in held_back),
    )


def robot_trials(
    pairs: Sequence[RobotPair],
    cuts: int,
    config: FpnetConfig,
    matcher: RegionMatcher,
    on_trial: Callable[[int], None] = lambda count: None,
) -> list[Trial]:
    """Return ``cuts`` trials of each real pair in each band of kept free space."""
    trials: list[Trial] = []
    for index, pair in enumerate(pairs):
        for cut in range(cuts * len(BANDS)):
            rng = np.random.default_rng([index, cut])
            changed = varied(pair, rng, list(BANDS.values())[cut % len(BANDS)])
            found = match_maps(changed.plan, submap_from_grid(changed.robot), matcher, config)
            trials.append(
                Trial(
                    scores=np.array([e.score for e in found.comparison.estimates]),
                    wall_length_m=found.sub.evidence.wall_length_m,
                    places=found.places,
                    truth=_right_match(found, changed),
                    is_foreign=False,
                )
            )
            on_trial(1)
    return trials


def _right_match(found: MapMatch, pair: RobotPair) -> int | None:
    """Return the index of the first placement that is right, in the plan's true metres."""
    if found.A_best is None:
        return None
    # Both sides were rescaled to metres; the best placement knows how.
    first = found.comparison.estimates[0].A_plan_submap
    free = found.sub.evidence.free
    factor = found.plan.segmentation.grid.resolution / pair.plan.resolution
    A_robot_sub = found.A_best.inv() @ _scaled(1.0 / factor) @ first
    truth = _scaled(factor) @ pair.A_plan_robot @ A_robot_sub
    return right_placement(found.comparison.estimates, truth, free, REAL_RIGHT_M)


def _scaled(factor: float) -> Affine2D:
    return Affine2D(np.eye(2) * factor, np.zeros(2))


def fit_posterior(trials: Sequence[Trial], start: LocalizerConfig) -> dict[str, float]:
    """Return the constants of the posterior under which the truth is most likely."""

    def loss(values: NDArray[np.float64]) -> float:
        config = start.model_copy(update=dict(zip(_FITTED, map(float, values), strict=True)))
        return mean_surprise(trials, config)

    first = np.array([getattr(start, name) for name in _FITTED])
    found = minimize(loss, first, method='Nelder-Mead', bounds=_BOUNDS)
    return dict(zip(_FITTED, map(float, found.x), strict=True))


def mean_surprise(trials: Sequence[Trial], config: LocalizerConfig) -> float:
    """Return the mean negative log probability of the truth [nats]."""
    p = [trial.probabilities(config)[_truth_index(trial)] for trial in trials]
    return float(-np.log(np.maximum(p, _LEAST_PROBABILITY)).mean())


def _truth_index(trial: Trial) -> int:
    return -1 if trial.truth is None else trial.truth


def reliability(trials: Sequence[Trial], config: LocalizerConfig) -> Reliability:
    """Compare what the posterior claims of each trial's best placement with the truth."""
    tried = [trial for trial in trials if len(trial.scores)]
    p = np.array([trial.probabilities(config)[0] for trial in tried], dtype=np.float64)
    right = np.array([trial.truth == 0 for trial in tried], dtype=np.bool_)
    foreign = np.array([trial.is_foreign for trial in tried], dtype=np.bool_)
    is_claim = p >= config.claim_probability
    claimed, true, count = reliability_bins(p, right)
    return Reliability(
        claimed=claimed,
        true=true,
        count=count,
        ece=expected_calibration_error(p, right),
        claims=int(is_claim.sum()),
        wrong_claims=int((is_claim & ~right).sum()),
        foreign_trials=sum(trial.is_foreign for trial in trials),
        foreign_claims=int((is_claim & foreign).sum()),
        right_best=float(right[~foreign].mean()) if (~foreign).any() else 0.0,
    )
