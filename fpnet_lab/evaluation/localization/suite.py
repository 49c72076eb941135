# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Run many cases in several processes, and cache finished ones.

Names of cached cases hold a digest of the case, configuration, weights and source code: an
interrupted benchmark resumes where it stopped, and figures of different versions are never mixed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
import logging
from pathlib import Path

from fpnet_lab.evaluation.localization.cases import CaseKind
from fpnet_lab.evaluation.localization.inputs import MissingDataError
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.evaluation.localization.runs import Job, run_case
from fpnet_lab.kept import digest, make_once

_log = logging.getLogger(__name__)

_COST_S = {CaseKind.GENERATED: 35.0, CaseKind.MESH: 35.0, CaseKind.LOG: 120.0}
_FALSE_PLAN_COST_S, _BASELINES_COST_S = 4.0, 15.0
"""
CPU seconds of a recording with the localizer, of each wrong plan, and of the baselines. Chosen.
"""


@dataclass(frozen=True)
class CaseOutcome:
    """Records of a case, or none and the reason why it was skipped."""

    records: tuple[Record, ...]
    skipped: str = ''


def run_suite(
    jobs: Sequence[Job],
    work: Path | None = None,
    workers: int = 1,
    on_case: Callable[[float], None] = lambda count: None,
) -> tuple[list[Record], dict[str, str]]:
    """
    Run the jobs, or load their results from the work folder.

    Parameters
    ----------
    jobs : to run
    work : folder that caches finished cases; None: no cache
    workers : processes; 1 runs in this one
    on_case : called with 1.0 after each case

    Returns
    -------
    All records in the order of the jobs, and the skipped cases with their reasons.
    """
    tasks = {f'{job.case.name}-{_digest(job)}': job for job in jobs}
    outcomes = make_once(
        work, CaseOutcome, tasks, _attempt, workers, on_case, is_kept=lambda o: not o.skipped
    )
    skipped = {
        job.case.name: outcome.skipped
        for job, outcome in zip(jobs, outcomes, strict=True)
        if outcome.skipped
    }
    for name, reason in skipped.items():
        _log.warning('%s is skipped: %s', name, reason)
    return [record for outcome in outcomes for record in outcome.records], skipped


def estimated_minutes(jobs: Sequence[Job], workers: int) -> float:
    """Return the approximate duration of the jobs on ``workers`` idle cores without cache."""
    seconds = 0.0
    for job in jobs:
        case = job.case
        false_plans = len(case.wrong_cases) + case.has_mirrored_plan + case.has_rough_plan
        seconds += _COST_S[job.case.kind] + false_plans * _FALSE_PLAN_COST_S
        if job.with_baselines:
            seconds += _BASELINES_COST_S * (2 if false_plans else 1)
    return seconds / workers / 60.0


def _attempt(job: Job) -> CaseOutcome:
    try:
        return CaseOutcome(run_case(job))
    except MissingDataError as error:
        return CaseOutcome((), str(error))


def _digest(job: Job) -> str:
    config = job.config
    weights = (config.matcher.weights, config.localizer.scorer_weights)
    content = {
        'case': asdict(job.case),
        'config': config.model_dump(mode='json'),
        'suite_seed': job.suite_seed,
        'baselines': job.with_baselines,
        'clouds': job.clouds,
    }
    return digest(content, [Path(name) for name in weights if name])
