# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How far the localizer's probabilities may be believed, and the constants that make them so.

Each trial compares a robot map with a plan: a generated one with its own and with other
buildings', as a tick does, or a real one with its floorplan, as ``fpnet match`` does; ticks of
whole drives are in :mod:`fpnet_core.evaluation.drive_trials`. What came out and where the truth
lies in it is all that :func:`fpnet_core.localizer.belief.posterior` is fitted to, by maximum
likelihood.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from fpnet_core.config import FpnetConfig, LocalizerConfig
from fpnet_core.evaluation.robot_pairs import BANDS, RobotPair, varied
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.localizer.belief import posterior
from fpnet_core.localizer.maps import MapMatch, match_maps
from fpnet_core.localizer.scale import tolerant_search
from fpnet_core.localizer.sides import StageTimer, compare, plan_side
from fpnet_core.matching import RegionMatcher
from fpnet_core.metrics import expected_calibration_error, reliability_bins
from fpnet_core.pose import MapSide, map_evidence
from fpnet_core.sim.config import SimConfig
from fpnet_core.sim.pairs import PairScene, generate_scene
from fpnet_core.submaps import submap_from_grid

RIGHT_M = 1.0
"""A placement is right when it moves the median free point by less than this from the truth."""

REAL_RIGHT_M = 2.0
"""The same for real pairs, whose truth is a fit and whose drawings are distorted."""

_LEAST_PROBABILITY = 1e-6  # of the truth; one hopeless trial must not decide the fit
_FITTED = (
    'evidence_per_m',
    'null_score',
    'null_rise',
    'rival_weight',
)
_BOUNDS = ((0.01, 10.0), (0.02, 0.98), (0.0, 20.0), (0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Trial:
    """
    One comparison: placements' ``scores (K,)``, best first, and what weighs them.

    ``truth`` is the index of the right placement, None where none of them is right;
    ``is_foreign`` marks a plan of another building.
    """

    scores: NDArray[np.float64]
    wall_length_m: float
    truth: int | None
    is_foreign: bool

    def probabilities(self, config: LocalizerConfig) -> NDArray[np.float64]:
        """Return the probability of each placement, and last that of none, ``(K + 1,)``."""
        each = posterior(self.scores, self.wall_length_m, config)
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
    """
    Return the trials of generated pairs.

    Each map meets its own plan, the last one before it, and the last one of its own family.
    """
    sim = SimConfig()
    trials: list[Trial] = []
    last: MapSide | None = None
    last_of: dict[str, MapSide] = {}
    for index in range(count):
        scene = generate_scene(seed, index * sim.pairs_per_plan, sim)
        plan = plan_side(scene.plan_segmentation)
        truth = scene.pair.A_plan_submap
        trials.append(_trial(plan, scene, truth, config, matcher))
        others = dict.fromkeys((last, last_of.get(scene.pair.family)))
        trials += [_trial(other, scene, None, config, matcher) for other in others if other]
        last = last_of[scene.pair.family] = plan
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
        scores=found.estimates.score,
        wall_length_m=sub.evidence.wall_length_m,
        truth=None
        if truth is None
        else right_placement(found.estimates, truth, sub.evidence.free, RIGHT_M),
        is_foreign=truth is None,
    )


def right_placement(
    estimates: Placements,
    A_plan_submap: Affine2D,
    free: NDArray[np.float64],
    tolerance_m: float,
) -> int | None:
    """Return the index of the first estimate that moves ``free (F, 2)`` as the truth does."""
    moved = np.linalg.norm(estimates.apply(free) - A_plan_submap.apply(free), axis=2)
    is_right = np.median(moved, axis=1) < tolerance_m
    return int(is_right.argmax()) if is_right.any() else None


def robot_trials(
    pairs: Sequence[RobotPair],
    cuts: int,
    config: FpnetConfig,
    matcher: RegionMatcher,
    on_trial: Callable[[int], None] = lambda count: None,
) -> list[Trial]:
    """
    Return ``cuts`` trials of each real pair in each band of kept free space.

    Each cut meets its own plan and the next other building's.
    """
    trials: list[Trial] = []
    for index, pair in enumerate(pairs):
        in_turn = (*pairs[index:], *pairs[:index])
        foreign = next((other for other in in_turn if other.building != pair.building), None)
        for cut in range(cuts * len(BANDS)):
            rng = np.random.default_rng([index, cut])
            changed = varied(pair, rng, list(BANDS.values())[cut % len(BANDS)])
            trials.append(_robot_trial(changed, changed, config, matcher))
            if foreign is not None:
                trials.append(_robot_trial(changed, foreign, config, matcher))
            on_trial(1)
    return trials


def _robot_trial(
    robot: RobotPair, drawn: RobotPair, config: FpnetConfig, matcher: RegionMatcher
) -> Trial:
    """Compare one pair's robot map with a pair's plan, which may be another building's."""
    found = match_maps(drawn.plan, submap_from_grid(robot.robot), matcher, config)
    is_foreign = robot is not drawn
    return Trial(
        scores=found.comparison.estimates.score,
        wall_length_m=found.sub.evidence.wall_length_m,
        truth=None if is_foreign else _right_match(found, robot),
        is_foreign=is_foreign,
    )


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
