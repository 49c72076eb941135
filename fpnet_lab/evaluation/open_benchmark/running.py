# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Run of programs on a folder of cases: one answer file per case, and a summary."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import hashlib
import json
from pathlib import Path
import re
import time
from typing import TYPE_CHECKING, Any

from fpnet.recordings.truth import read_json
from fpnet_core.errors import ConfigError, FpnetError
from fpnet_lab.evaluation.open_benchmark.protocol import (
    CASES_NAME,
    CaseSet,
    OpenCase,
    StatedPoses,
    read_answer,
    write_answer,
)

if TYPE_CHECKING:  # it loads the localizer and all baselines
    from fpnet_lab.evaluation.open_benchmark.programs import Program

RUN_NAME, ANSWERS_NAME = 'run.json', 'answers'
_REMEDY = 'run the program with: fpnet bench open run'
_NAME = re.compile(r'[\w.-]+')


@dataclass(frozen=True)
class ProgramRun:
    """Folder with the answers of one program; ``failures`` has the reason by case."""

    name: str
    folder: Path
    failures: Mapping[str, str]

    @classmethod
    def read(cls, folder: Path, cases: CaseSet) -> ProgramRun:
        """
        Read a program's results.

        Raises
        ------
        FpnetError
            If the folder has no results, or they are of other cases.
        """
        said = read_json(folder / RUN_NAME, _REMEDY)
        if said.get('cases_sha256') != digest_of(cases):
            raise FpnetError(f'{folder} has results of other cases than {cases.folder}; {_REMEDY}')
        failures = {name: each['failure'] for name, each in said['cases'].items()}
        return cls(str(said['program']), folder, {k: v for k, v in failures.items() if v})

    def answer(self, cases: CaseSet, case: OpenCase) -> StatedPoses:
        """Return the answer to a case: nothing if the program failed."""
        if case.name in self.failures:
            return StatedPoses.nothing()
        return read_answer(_answer(self.folder, case), cases.odometry(case))


def digest_of(cases: CaseSet) -> str:
    """Return the SHA-256 of the description of a folder of cases."""
    return hashlib.sha256((cases.folder / CASES_NAME).read_bytes()).hexdigest()


def read_runs(folder: Path, cases: CaseSet) -> list[ProgramRun]:
    """Return the runs in a folder of results, one per program; raises as ProgramRun.read."""
    folders = sorted(path.parent for path in folder.glob(f'*/{RUN_NAME}'))
    if not folders:
        raise FpnetError(f'{folder} has no results; {_REMEDY}')
    return [ProgramRun.read(each, cases) for each in folders]


def run_programs(
    cases: CaseSet,
    programs: Mapping[str, Program],
    out: Path,
    on_answer: Callable[[], None] = lambda: None,
) -> dict[str, dict[str, str]]:
    """
    Run programs on all cases; return the reasons of failures by program and case.

    A program is a function of two paths, plan and scans, that returns its poses. It fails where it
    raises an error; that counts as "cannot say". ``out`` gets a folder for each program.

    Raises
    ------
    ConfigError
        If a program's name cannot be that of a folder.
    """
    for name in programs:
        if not _NAME.fullmatch(name) or not name.strip('.'):
            raise ConfigError(f'program name {name!r}: use letters, digits, "-", "_" and "."')
    said: dict[str, dict[str, Any]] = {name: {} for name in programs}
    for case in cases.cases:
        for name, program in programs.items():
            start = time.perf_counter()
            failure = _run_one(program, cases, case, out / name)
            seconds = round(time.perf_counter() - start, 3)
            said[name][case.name] = {'seconds': seconds, 'failure': failure}
            on_answer()
    for name, results in said.items():
        content = {'program': name, 'cases_sha256': digest_of(cases), 'cases': results}
        path = out / name / RUN_NAME
        path.write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')
    return {
        name: {case: each['failure'] for case, each in results.items() if each['failure']}
        for name, results in said.items()
    }


def _run_one(program: Program, cases: CaseSet, case: OpenCase, out: Path) -> str:
    """Write a program's answer to a case; return why it failed, empty if it did not."""
    plan, scans = cases.folder / case.plan, cases.folder / case.scans
    answer, failure = StatedPoses.nothing(), ''
    try:
        answer = program(plan.resolve(), scans.resolve())
    except FpnetError as error:
        failure = str(error)
    except Exception as error:
        failure = f'{type(error).__name__}: {error}'
    write_answer(_answer(out, case), answer)
    return failure


def _answer(folder: Path, case: OpenCase) -> Path:
    return folder / ANSWERS_NAME / f'{case.name}.tum'
