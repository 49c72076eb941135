# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Run many cases, in several processes, and keep what is done.

Every finished case is a line of ``runs.jsonl`` in the work folder, so that an interrupted
benchmark goes on where it stopped. The line's key covers the case, the configuration, the weights
and the program's own text: figures of two versions are never mixed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
import hashlib
import json
import logging
from pathlib import Path
from typing import Any

import fpnet_core
from fpnet_lab.evaluation.localization.cases import Kind
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.evaluation.localization.runs import Job, run_case
from fpnet_lab.evaluation.localization.scenes import MissingDataError
from fpnet_lab.pool import each_done

RUNS_NAME = 'runs.jsonl'

_log = logging.getLogger(__name__)

_IRRELEVANT = ('cli', 'viz', 'training')  # folders whose text changes no figure

_COST_S = {Kind.GENERATED: 35.0, Kind.MESH: 35.0, Kind.LOG: 120.0}
_FALSE_PLAN_COST_S, _BASELINES_COST_S = 4.0, 15.0
"""
CPU seconds of a drive with the localizer, of each wrong plan on it, and of the baselines. Chosen.
"""

Outcome = tuple[tuple[Record, ...], str]
"""A case's records, or none and the reason why it was skipped."""


def run_suite(
    jobs: Sequence[Job],
    work: Path | None = None,
    workers: int = 1,
    on_case: Callable[[float], None] = lambda count: None,
) -> tuple[list[Record], dict[str, str]]:
    """
    Run the jobs, or take over what the work folder holds of them.

    Parameters
    ----------
    jobs : what to run
    work : folder that keeps finished cases; None keeps nothing
    workers : processes; 1 runs in this one
    on_case : is told 1.0 after each case

    Returns
    -------
    All records in the order of the jobs, and the skipped cases with their reasons.
    """
    version = _program_version()
    keys = {job.case.name: _key(job, version) for job in jobs}
    done = _read(work, set(keys.values()))
    for _ in done:
        on_case(1.0)
    skipped: dict[str, str] = {}
    waiting = [job for job in jobs if keys[job.case.name] not in done]
    for job, (records, reason) in each_done(_attempt, waiting, workers):
        if reason:
            skipped[job.case.name] = reason
            _log.warning('%s is skipped: %s', job.case.name, reason)
        else:
            done[keys[job.case.name]] = records
            _append(work, keys[job.case.name], records)
        on_case(1.0)
    ordered = [done.get(keys[job.case.name], ()) for job in jobs]
    return [record for records in ordered for record in records], skipped


def estimated_minutes(jobs: Sequence[Job], workers: int) -> float:
    """Return about how long the jobs take on so many idle cores, none of them done before."""
    seconds = 0.0
    for job in jobs:
        case = job.case
        false_plans = len(case.wrong_cases) + case.has_mirrored_plan + case.has_rough_plan
        seconds += _COST_S[job.case.kind] + false_plans * _FALSE_PLAN_COST_S
        if job.with_baselines:
            seconds += _BASELINES_COST_S * (2 if false_plans else 1)
    return seconds / workers / 60.0


def _attempt(job: Job) -> Outcome:
    try:
        return run_case(job), ''
    except MissingDataError as error:
        return (), str(error)


def _key(job: Job, version: str) -> str:
    content = {
        'version': version,
        'case': job.case.as_json(),
        'config': job.config.model_dump(mode='json'),
        'suite_seed': job.suite_seed,
        'baselines': job.with_baselines,
    }
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def _program_version() -> str:
    """Return a digest of the package's modules and its weights' manifest."""
    root = Path(fpnet_core.__file__).parent
    digest = hashlib.sha256()
    for path in sorted((*root.rglob('*.py'), *root.glob('weights/*.json'))):
        if path.relative_to(root).parts[0] not in _IRRELEVANT:
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _read(work: Path | None, keys: set[str]) -> dict[str, tuple[Record, ...]]:
    """Return the kept cases that are asked for; a torn last line is left out."""
    path = None if work is None else work / RUNS_NAME
    if path is None or not path.exists():
        return {}
    kept: dict[str, tuple[Record, ...]] = {}
    for line in path.read_text(encoding='utf-8').splitlines():
        try:
            entry: dict[str, Any] = json.loads(line)
        except ValueError:
            continue
        if entry['key'] in keys:
            kept[entry['key']] = tuple(Record.from_json(values) for values in entry['records'])
    return kept


def _append(work: Path | None, key: str, records: Sequence[Record]) -> None:
    if work is None:
        return
    work.mkdir(parents=True, exist_ok=True)
    line = json.dumps({'key': key, 'records': [record.as_json() for record in records]})
    with (work / RUNS_NAME).open('a', encoding='utf-8') as stream:
        stream.write(line + '\n')
