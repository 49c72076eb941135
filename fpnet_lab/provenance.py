# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How a figure came about: the command, the commit of the code, the day and the machine."""

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
"""Where a report of a benchmark keeps it."""

WHERE_TO_WRITE = frozenset({'--json', '--out', '--work', '--plot', '--strips'})
"""Options of benchmarks that change no figure."""


@dataclass(frozen=True)
class Provenance:
    """
    Which command made a report, and of what.

    ``commit`` is abbreviated, with a ``+`` where files differed from it, and empty outside of a
    checkout; ``date`` is ISO 8601.
    """

    command: str
    commit: str
    date: str
    machine: str

    @classmethod
    def now(cls) -> Self:
        """Return that of this process: call it at the start, before anyone commits."""
        name, *arguments = sys.argv
        program = Path(name).name
        if program.endswith('.py'):
            program = f'python {Path(name).parent.name}/{program}'
        command = f'{program} {shlex.join(_of_the_figures(arguments))}'.strip()
        return cls(command, _commit(), date.today().isoformat(), machine())

    @classmethod
    def of(cls, report: dict[str, Any]) -> Self | None:
        """Return what a report says of itself, None where it says nothing."""
        said = report.get(KEY)
        if said is None:
            return None
        try:
            return cls(**said)
        except TypeError as error:
            raise ConfigError(
                f'{KEY!r} holds {sorted(said)}; expected command, commit, date and machine: '
                'run the benchmark again'
            ) from error

    @classmethod
    def of_weights(cls, manifest: dict[str, Any], path: Path) -> Self | None:
        """
        Return that of weights, whose manifest holds the command; None where it holds none.

        Commit and day are the manifest's last ones, and it stands in place of a machine.
        """
        data = manifest.get('data')
        if not isinstance(data, dict) or 'command' not in data:
            return None
        log = ('log', '-1', '--format=%h %cs', '--abbrev=7', '--', path.name)
        commit, _, day = _git(path.resolve().parent, *log).partition(' ')
        return cls(str(data['command']), commit, day, path.as_posix())

    def in_report(self, report: dict[str, Any]) -> dict[str, Any]:
        """Return the report with this in it."""
        return {**report, KEY: asdict(self)}

    def __str__(self) -> str:
        """Return a sentence's beginning for the line above a table."""
        commit = f'commit {self.commit}' if self.commit else 'outside of a checkout'
        return f'`{self.command}` ({self.date}, {commit}, {self.machine})'


def _of_the_figures(arguments: Sequence[str]) -> Iterator[str]:
    """
    Yield the arguments but those that say where to write: nobody else has those folders.

    Of a path from the root its name is left, for the same reason.
    """
    remaining = iter(arguments)
    for argument in remaining:
        if argument in WHERE_TO_WRITE:
            next(remaining, None)
        elif argument.partition('=')[0] not in WHERE_TO_WRITE:
            option, equals, value = argument.rpartition('=')
            yield option + equals + (Path(value).name if value.startswith('/') else value)


def machine() -> str:
    """Return cores and processor, as ``2 cores of an AMD EPYC 7B13``."""
    count = os.cpu_count() or 1
    name = processor().replace('(R)', '').replace('(TM)', '')
    return f'{count} core{"s" if count > 1 else ""}, {name}'


def processor() -> str:
    """Return the processor's name, as far as the system tells it."""
    try:
        lines = Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines()
    except OSError:
        lines = []
    names = [line.partition(':')[2].strip() for line in lines if line.startswith('model name')]
    return names[0] if names else platform.processor() or platform.machine()


def _commit() -> str:
    """Return the commit of the checkout that this package is in."""
    describe = ('describe', '--always', '--dirty=+', '--exclude=*', '--abbrev=7')
    return _git(Path(__file__).parent, *describe)


def _git(folder: Path, *words: str) -> str:
    """Return what git says in a folder; nothing outside of a checkout."""
    git = ['git', '-C', str(folder), *words]
    try:
        found = subprocess.run(  # noqa: S603 - our own arguments
            git, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ''
    return found.stdout.strip()
