# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Provenance of a figure: command, commit, date and machine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from datetime import date
import os
from pathlib import Path
import platform
import shlex
import subprocess
import sys
from typing import Any, Self

from fpnet_core.errors import ConfigError

KEY = 'made'
"""Key of the provenance in a benchmark report."""

WHERE_TO_WRITE = frozenset({'--json', '--out', '--work', '--plot', '--strips'})
"""Benchmark options that do not affect any figure."""


@dataclass(frozen=True)
class Provenance:
    """
    The command that made a report, with commit, date and machine.

    ``commit`` is abbreviated, with a ``+`` for uncommitted changes, and empty outside of a
    checkout; ``date`` is ISO 8601.
    """

    command: str
    commit: str
    date: str
    machine: str

    @classmethod
    def now(cls) -> Self:
        """Return the provenance of this process; call it at the start, before HEAD can change."""
        name, *arguments = sys.argv
        program = Path(name).name
        if program.endswith('.py'):
            program = f'python {Path(name).parent.name}/{program}'
        command = f'{program} {shlex.join(_without_outputs(arguments))}'.strip()
        return cls(command, _commit(), date.today().isoformat(), machine())

    @classmethod
    def of(cls, report: dict[str, Any]) -> Self | None:
        """Return the provenance in a report; None if the report has none."""
        stored = report.get(KEY)
        if stored is None:
            return None
        try:
            return cls(**stored)
        except TypeError as error:
            raise ConfigError(
                f'{KEY!r} holds {sorted(stored)}; expected command, commit, date and machine: '
                'run the benchmark again'
            ) from error

    @classmethod
    def of_weights(cls, manifest: dict[str, Any], path: Path) -> Self | None:
        """
        Return the provenance of weights whose manifest holds the command; None if it holds none.

        Commit and date are those of the manifest's last commit; its path replaces the machine.
        """
        data = manifest.get('data')
        if not isinstance(data, dict) or 'command' not in data:
            return None
        log = ('log', '-1', '--format=%h %cs', '--abbrev=7', '--', path.name)
        commit, _, day = _git(path.resolve().parent, *log).partition(' ')
        return cls(str(data['command']), commit, day, path.as_posix())

    def in_report(self, report: dict[str, Any]) -> dict[str, Any]:
        """Return the report with this provenance added."""
        return {**report, KEY: asdict(self)}

    def __str__(self) -> str:
        """Return the first words of the line above a table."""
        commit = f'commit {self.commit}' if self.commit else 'outside of a checkout'
        return f'`{self.command}` ({self.date}, {commit}, {self.machine})'


def _without_outputs(arguments: Sequence[str]) -> Iterator[str]:
    """
    Yield the arguments without output paths, which exist on this machine only.

    An absolute path is reduced to its file name for the same reason.
    """
    remaining = iter(arguments)
    for argument in remaining:
        if argument in WHERE_TO_WRITE:
            next(remaining, None)
        elif argument.partition('=')[0] not in WHERE_TO_WRITE:
            option, equals, value = argument.rpartition('=')
            yield option + equals + (Path(value).name if value.startswith('/') else value)


def machine() -> str:
    """Return the number of cores and the processor: ``2 cores, AMD EPYC 7B13``."""
    count = os.cpu_count() or 1
    name = processor().replace('(R)', '').replace('(TM)', '')
    return f'{count} core{"s" if count > 1 else ""}, {name}'


def processor() -> str:
    """Return the processor's name as the operating system reports it."""
    try:
        lines = Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines()
    except OSError:
        lines = []
    names = [line.partition(':')[2].strip() for line in lines if line.startswith('model name')]
    return names[0] if names else platform.processor() or platform.machine()


def _commit() -> str:
    """Return the commit of the checkout that contains this package."""
    describe = ('describe', '--always', '--dirty=+', '--exclude=*', '--abbrev=7')
    return _git(Path(__file__).parent, *describe)


def _git(folder: Path, *words: str) -> str:
    """Return the output of git in a folder; empty outside of a checkout."""
    git = ['git', '-C', str(folder), *words]
    try:
        found = subprocess.run(  # noqa: S603 - our own arguments
            git, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ''
    return found.stdout.strip()
