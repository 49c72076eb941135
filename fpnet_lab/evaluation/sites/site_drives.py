# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Localization on generated multi-storey sites: correct storey and cost of the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.io.scans import Scan
from fpnet_core.localizer import ReplayResult, StoreyPlan, create_localizer, replay
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Status
from fpnet_lab.evaluation.localization.drives import kept_scans
from fpnet_lab.evaluation.localization.figures import median
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.localization.records import RIGHT, SCORED_AT_M, stamp_at_path
from fpnet_lab.evaluation.localization.runs import UPDATE_PERIOD_S
from fpnet_lab.evaluation.sites.storeys_apart import parted_at_m
from fpnet_lab.sim.drawn.storeys import DrawnStorey, Likeness, draw_storeys
from fpnet_lab.sim.drives.recording import Recording

FAMILIES = ('double_corridor', 'racetrack', 'branched', 'central_hall', 'bays', 'bent')
SIZES = (2, 3, 4, 6, 8, 12)
"""Numbers of storeys of the sites, in turn. Chosen."""

EQUAL_EVERY = 4
"""Stride of the sites with a storey equal to the true one. Chosen."""

_SENSOR = 'beams16'
_SITE_STREAM = 31  # given: second element of the seed


@dataclass(frozen=True)
class SiteRun:
    """
    Results of a recording on one storey of a site, and on the correct plan alone.

    Paths are None without an accepted pose; ``parted_m`` is the path after which the submap
    excludes all similar storeys (:func:`~fpnet_lab.evaluation.sites.storeys_apart.parted_at_m`).
    ``is_right``: storey and pose are right after 40 m; ``wrong_storeys`` counts poses on another
    storey; ``least_different`` is the share of differing walls of the most similar storey, 0 for
    an equal one.
    """

    name: str
    storeys: int
    alike: int
    least_different: float
    is_right: bool
    wrong_storeys: int
    wrong_poses: int
    status: str
    path_m: float | None
    path_alone_m: float | None
    tick_ms: float
    tick_alone_ms: float
    parted_m: float | None = None

    @property
    def has_equal(self) -> bool:
        """Return whether another storey has identical walls."""
        return self.least_different == 0.0


def site_likenesses(count: int, rng: np.random.Generator, has_equal: bool) -> tuple[Likeness, ...]:
    """Return the storeys of a site: true, optionally equal, then alternately alike and other."""
    rest = [Likeness.EQUAL] if has_equal else [Likeness.ALIKE]
    kinds = (Likeness.ALIKE, Likeness.OTHER)
    rest += [kinds[k % 2] for k in range(count - 2)]
    made = np.array([Likeness.TRUE, *rest[: count - 1]], dtype=object)
    return tuple(made[rng.permutation(count)])


@dataclass(frozen=True, eq=False)
class SiteDrive:
    """A recording on one storey of a site, its registered scans, and the localizer's replay."""

    name: str
    recording: Recording
    storeys: tuple[DrawnStorey, ...]
    scans: list[Scan]
    replayed: ReplayResult


def site_drive(
    number: int, seed: int, config: FpnetConfig, equal_every: int = EQUAL_EVERY
) -> SiteDrive:
    """Simulate on site ``number``; one in ``equal_every`` has an equal storey, 0: none."""
    rng = np.random.default_rng((seed, number, _SITE_STREAM))
    family = FAMILIES[number % len(FAMILIES)]
    # Without the shift, families and sizes would repeat in step.
    count = SIZES[(number + number // len(SIZES)) % len(SIZES)]
    recording = drive_through(family, _SENSOR, seed + number)
    has_equal = equal_every > 0 and number % equal_every == equal_every - 1
    likenesses = site_likenesses(count, rng, has_equal)
    storeys = draw_storeys(recording.building.plan, likenesses, rng)
    scans = kept_scans(recording, config.odometry)
    run = _replayed(scans, storeys, config)
    return SiteDrive(f'{family}_{count}', recording, storeys, scans, run)


def run_site(number: int, seed: int, config: FpnetConfig) -> SiteRun:
    """Run the localizer for site ``number`` with all storeys and with the true plan alone."""
    driven = site_drive(number, seed, config)
    true = [storey for storey in driven.storeys if storey.likeness is Likeness.TRUE]
    return _scored(driven, _replayed(driven.scans, true, config))


def _replayed(
    scans: Sequence[Scan], storeys: Sequence[DrawnStorey], config: FpnetConfig
) -> ReplayResult:
    localizer = create_localizer(config)
    localizer.set_storeys([StoreyPlan(each.name, each.drawn.grid) for each in storeys])
    return replay(scans, localizer, UPDATE_PERIOD_S)


def _scored(driven: SiteDrive, alone: ReplayResult) -> SiteRun:
    recording, storeys, run = driven.recording, driven.storeys, driven.replayed
    truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    named = {storey.name: storey for storey in storeys}
    is_true = [named[each].likeness is Likeness.TRUE for each in run.storeys]
    errors_m = _errors_m(run, truth, named)
    until_ns = stamp_at_path(run.odometry, SCORED_AT_M)
    before = np.flatnonzero(run.published.stamps_ns <= until_ns)
    is_right = len(before) > 0 and is_true[before[-1]] and errors_m[before[-1]] <= RIGHT[0]
    others = [s for s in storeys if s.likeness is not Likeness.TRUE]
    return SiteRun(
        driven.name,
        len(storeys),
        sum(s.likeness in (Likeness.ALIKE, Likeness.EQUAL) for s in storeys),
        min(s.different for s in others),
        bool(is_right),
        sum(not each for each in is_true),
        int((errors_m > RIGHT[0]).sum()),
        run.outputs[-1].status.value if run.outputs else Status.WAITING.value,
        _first_claim_m(run),
        _first_claim_m(alone),
        _mean(run),
        _mean(alone),
        parted_at_m(storeys, run, truth),
    )


def _errors_m(
    run: ReplayResult, truth: PlanarTrajectory, named: dict[str, DrawnStorey]
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the error [m] of each published pose on its storey; it is large on a wrong one."""
    at = np.searchsorted(truth.stamps_ns, run.published.stamps_ns)
    errors = []
    for xy, place, name in zip(run.published.xy, truth.xy[at], run.storeys, strict=True):
        storey = named[name]
        true_xy = storey.drawn.A_plan_building.apply(place)
        errors.append(float(np.linalg.norm(xy - true_xy)))
    return np.array(errors)


def _mean(run: ReplayResult) -> float:
    return float(run.tick_ms.mean()) if len(run.tick_ms) else 0.0


def _first_claim_m(run: ReplayResult) -> float | None:
    if not len(run.published):
        return None
    return run.odometry.path_length_m(int(run.published.stamps_ns[0]))


def site_report(runs: Sequence[SiteRun]) -> dict[str, Any]:
    """Return the part of the ``fpnet bench sites`` report on storeys."""
    apart = [run for run in runs if not run.has_equal]
    equal = [run for run in runs if run.has_equal]
    return {
        'apart': _row(apart),
        'equal': {
            **_row(equal),
            'ambiguous': sum(run.path_m is None for run in equal),
        },
        'runs': [asdict(run) for run in runs],
    }


def _row(runs: Sequence[SiteRun]) -> dict[str, Any]:
    both = [r for r in runs if r.path_m is not None and r.path_alone_m is not None]
    largest = [run for run in runs if run.storeys == max(SIZES)]
    return {
        'sites': len(runs),
        'right': sum(run.is_right for run in runs),
        'wrong_storeys': sum(run.wrong_storeys > 0 for run in runs),
        'wrong_poses': sum(run.wrong_poses for run in runs),
        'path_m_median': median([run.path_m for run in both]),
        'path_alone_m_median': median([run.path_alone_m for run in both]),
        'parted_m_median': median([run.parted_m for run in both]),
        'tick_ms_mean': median([run.tick_ms for run in runs]),
        'tick_alone_ms_mean': median([run.tick_alone_ms for run in runs]),
        'tick_ratio_12': median(
            [run.tick_ms / run.tick_alone_ms for run in largest if run.tick_alone_ms]
        ),
    }
