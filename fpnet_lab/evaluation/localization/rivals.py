# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Baselines on a recording: other pose estimators with the localizer's submaps and odometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
import time

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.localizer.scale import allowed_scales
from fpnet_core.pose import map_evidence
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import GridMap, LocalizerOutput
from fpnet_lab.baselines.answer import Answer
from fpnet_lab.baselines.branch_and_bound import BranchAndBound
from fpnet_lab.baselines.cloud_registration import CLOUD_METHODS
from fpnet_lab.baselines.correlative import search_placement
from fpnet_lab.baselines.matcher_ransac import place_by_ransac
from fpnet_lab.baselines.monte_carlo import MonteCarlo, MonteCarloSettings
from fpnet_lab.evaluation.localization.drives import ProductRun, Registrar, resident_mb
from fpnet_lab.evaluation.localization.records import MethodRun, UpdateEstimate, stamp_at_path

CHECKPOINTS_M = (10.0, 20.0, 40.0)
"""
Paths after which branch and bound and the cloud registration run; a result is kept until the next
run. Chosen.
"""

CORRELATIVE_CHECKPOINTS_M = (40.0,)
"""The same for the correlative search, which takes seconds per run. Chosen."""

_SHARED_STAGES = ('segment', 'graph', 'match')

Look = Callable[[LocalizerOutput], tuple[Answer | None, float]]
"""Places the submap of an update; also returns the duration in milliseconds."""


def run_rivals(
    product: ProductRun, registrar: Registrar, config: FpnetConfig, clouds: Sequence[str] = ()
) -> dict[str, MethodRun]:
    """
    Return the run of each baseline by name, on the plan of ``product``.

    ``clouds`` are the methods of :data:`CLOUD_METHODS` to run as well.
    """
    methods: dict[str, Baseline] = dict(BASELINES)
    methods |= {name: partial(_cloud, name) for name in clouds}
    return {name: run(product, registrar, config) for name, run in methods.items()}


def _matcher_ransac(product: ProductRun, registrar: Registrar, config: FpnetConfig) -> MethodRun:
    del registrar, config  # unused: all baselines share one signature
    return _run_on_updates(product, product.updates, _ransac(product))


def _branch_and_bound(product: ProductRun, registrar: Registrar, config: FpnetConfig) -> MethodRun:
    del registrar
    search = BranchAndBound(product.plan.evidence, allowed_scales(config.pose.scale_tolerance))
    look = _timed(lambda sub: search.place(map_evidence(sub)))
    return _run_on_updates(product, _checkpoints(product, CHECKPOINTS_M), look)


def _correlative(product: ProductRun, registrar: Registrar, config: FpnetConfig) -> MethodRun:
    del registrar
    plan, scales = product.plan.segmentation.grid, allowed_scales(config.pose.scale_tolerance)
    look = _timed(partial(_correlated, plan, scales))
    return _run_on_updates(product, _checkpoints(product, CORRELATIVE_CHECKPOINTS_M), look)


def _cloud(name: str, product: ProductRun, registrar: Registrar, config: FpnetConfig) -> MethodRun:
    del registrar, config
    look = _timed(CLOUD_METHODS[name](product.plan.segmentation.grid))
    return _run_on_updates(product, _checkpoints(product, CHECKPOINTS_M), look)


def _ransac(product: ProductRun) -> Look:
    def look(update: LocalizerOutput) -> tuple[Answer | None, float]:
        assert update.graph is not None and update.match is not None  # noqa: PT018
        start = time.perf_counter()
        placement = place_by_ransac(product.plan.graph, update.graph, update.match)
        own_ms = 1e3 * (time.perf_counter() - start)
        return placement, own_ms + sum(update.timings_ms.get(s, 0.0) for s in _SHARED_STAGES)

    return look


def _timed(place: Callable[[GridMap], Answer | None]) -> Look:
    def look(update: LocalizerOutput) -> tuple[Answer | None, float]:
        assert update.submap is not None
        start = time.perf_counter()
        placement = place(update.submap.grid)
        return placement, 1e3 * (time.perf_counter() - start)

    return look


def _correlated(plan: GridMap, scales: NDArray[np.float64], sub: GridMap) -> Answer | None:
    """Return the result of the exhaustive search; it has no null hypothesis, always accepts."""
    found = search_placement(plan, sub, scales)
    if found is None:
        return None
    return Answer(found.A_plan_submap, float(np.clip(found.score, 0.0, 1.0)), is_accepted=True)


def _checkpoints(product: ProductRun, paths_m: Sequence[float]) -> tuple[LocalizerOutput, ...]:
    """Return the last update before each checkpoint, or before the end of a shorter run."""
    stamps = [stamp_at_path(product.run.odometry, path_m) for path_m in paths_m]
    found = []
    for stamp_ns in stamps:
        before = [update for update in product.updates if update.stamp_ns <= stamp_ns]
        if before and before[-1] not in found:
            found.append(before[-1])
    return tuple(found)


def _run_on_updates(
    product: ProductRun, updates: Sequence[LocalizerOutput], look: Look
) -> MethodRun:
    """Place the submaps of some updates; odometry propagates the pose between them."""
    beliefs: list[UpdateEstimate] = []
    claims: list[Affine2D | None] = []
    tick_ms: list[float] = []
    rss_mb = resident_mb()
    for update in updates:
        assert update.submap is not None
        placement, took_ms = look(update)
        tick_ms.append(took_ms)
        rss_mb = max(rss_mb, resident_mb())
        A = placement.A_plan_submap @ update.submap.T_odom_submap.inv() if placement else None
        beliefs.append(UpdateEstimate(update.stamp_ns, placement.score if placement else 0.0, A))
        claims.append(A if placement and placement.is_accepted else None)
    stamps = [update.stamp_ns for update in updates]
    return MethodRun(
        published=carried(product.run.odometry, stamps, claims),
        odometry=product.run.odometry,
        beliefs=tuple(beliefs),
        tick_ms=np.array(tick_ms, dtype=np.float64),
        add_scan_ms=product.run.add_scan_ms,
        rss_mb=rss_mb,
    )


def carried(
    odometry: PlanarTrajectory, stamps_ns: Sequence[int], claims: Sequence[Affine2D | None]
) -> PlanarTrajectory:
    """
    Return the poses from accepted placements, each used from its stamp until the next one.

    ``claims[k]`` maps ``odom`` to the plan from ``stamps_ns[k]`` on; None: not localized.
    """
    latest = np.searchsorted(np.asarray(stamps_ns), odometry.stamps_ns, side='right') - 1
    published = PlanarTrajectory.empty()
    for k, claim in enumerate(claims):
        chosen = latest == k
        if claim is not None and chosen.any():
            published = published.joined(odometry.take(chosen).mapped(claim))
    return published


@dataclass(frozen=True, eq=False)
class _Claim:
    """Estimate of the particle filter after a filter update."""

    stamp_ns: int
    share: float
    T_plan_odom: SE2
    is_accepted: bool


def _monte_carlo(product: ProductRun, registrar: Registrar, config: FpnetConfig) -> MethodRun:
    """Run the particle filter on the planar slice of every scan."""
    rng = np.random.default_rng(config.seed)
    filter_ = MonteCarlo(product.plan.evidence, rng, MonteCarloSettings())
    odometry = product.run.odometry
    answers: list[_Claim] = []
    tick_ms: list[float] = []
    add_ms: list[float] = []
    rss_mb = resident_mb()
    for index, beams in enumerate(registrar.slices[: len(odometry)]):
        x, y = odometry.xy[index]
        T_odom_base = SE2.from_xy_yaw(x, y, float(odometry.yaw[index]))
        start = time.perf_counter()
        is_updated = filter_.add_scan(beams, T_odom_base)
        took_ms = 1e3 * (time.perf_counter() - start)
        (tick_ms if is_updated else add_ms).append(took_ms)
        if is_updated:
            mean = filter_.estimate()
            answers.append(
                _Claim(
                    int(odometry.stamps_ns[index]),
                    mean.share,
                    mean.T_plan_base @ T_odom_base.inv(),
                    mean.is_accepted,
                )
            )
            rss_mb = max(rss_mb, resident_mb())
    claims = [a.T_plan_odom if a.is_accepted else None for a in answers]
    return MethodRun(
        published=carried(odometry, [a.stamp_ns for a in answers], claims),
        odometry=odometry,
        beliefs=tuple(UpdateEstimate(a.stamp_ns, a.share, a.T_plan_odom) for a in answers),
        tick_ms=np.array(tick_ms),
        add_scan_ms=np.array(add_ms),
        rss_mb=rss_mb,
    )


Baseline = Callable[[ProductRun, Registrar, FpnetConfig], MethodRun]
"""Runs a method on the submaps and the odometry of a localizer's run."""

BASELINES: dict[str, Baseline] = {
    'matcher_ransac': _matcher_ransac,
    'branch_and_bound': _branch_and_bound,
    'correlative': _correlative,
    'monte_carlo': _monte_carlo,
}
"""Baselines by name that need no additional package."""
