# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Run the tutorial's commands and compare their output with the page.

Run: python tools/walkthrough.py [PAGE] [--work DIR]    (make walkthrough)

The commands of ``bash`` blocks run in an empty folder. The block below a command is its expected
output and must hold every line that ``fpnet`` prints. Words must be equal; numbers may differ by
a fifth, 5 mm or one unit of the last digit; durations are ignored. Files that a command is told
to write must exist.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

from fpnet.cli.outputs import WRITTEN

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r'^```(\w*)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r'-?\d+(?:\.\d+)?')
DURATION = re.compile(r'\d+(?:\.\d+)? ?(?:ms|s)\b')
TABLE = re.compile('[\u2500-\u257f]')
NEAR, NEAR_M = 0.2, 0.005
TIMEOUT_S = 600


@dataclass(frozen=True)
class Step:
    """A command of a page, and its expected output lines."""

    command: str
    promised: tuple[str, ...]

    @property
    def words(self) -> list[str]:
        """The command's words."""
        return shlex.split(self.command)

    @property
    def program(self) -> str | None:
        """The program, preferably of this environment; None if it is not installed."""
        beside = str(Path(sys.executable).parent)
        return shutil.which(self.words[0], path=beside) or shutil.which(self.words[0])


def main() -> None:
    """Run all steps, print the duration of each, and exit 1 if any output differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('page', type=Path, nargs='?', default=ROOT / 'docs' / 'tutorial.md')
    parser.add_argument('--work', type=Path, help='an empty folder; default: a temporary one')
    arguments = parser.parse_args()
    work = arguments.work or Path(tempfile.mkdtemp(prefix='walkthrough-'))
    broken = 0
    for step in steps(arguments.page.read_text(encoding='utf-8')):
        if step.program is None:
            print(f'skipped, not installed: {step.command}')
            continue
        started = time.perf_counter()
        wrong = follow(step, work)
        took = f'{time.perf_counter() - started:.0f} s'
        print(f'{"not as promised" if wrong else "as promised"} ({took}): {step.command}')
        for line in wrong:
            print(f'    {line}')
        broken += bool(wrong)
    sys.exit(bool(broken))


def steps(page: str) -> list[Step]:
    """Return the page's commands in order, each with the output block that follows it."""
    found: list[Step] = []
    for kind, text in BLOCK.findall(page):
        if kind == 'bash':
            found += [Step(line.partition('  #')[0].strip(), ()) for line in text.splitlines()]
        elif not kind and found and not found[-1].promised and not is_command(text):
            found[-1] = Step(found[-1].command, tuple(text.splitlines()))
    return found


def is_command(text: str) -> bool:
    """Return whether a block holds commands (for example for a robot) and not output."""
    return text.startswith(('ros2 ', 'fpnet '))


def follow(step: Step, work: Path) -> list[str]:
    """Run a step and return its deviations from the page."""
    words = step.words
    done = subprocess.run(  # noqa: S603 - commands of our own pages
        [step.program, *words[1:]],
        cwd=work,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    wrong = [] if done.returncode == 0 else [f'exit status {done.returncode}: {done.stderr}']
    wrong += [f'{name} was not written' for name in written(words) if not (work / name).exists()]
    printed = done.stdout.splitlines()
    wrong += [f'promised: {line}' for line in missing(step.promised, printed)]
    return wrong + [f'not on the page: {line}' for line in unsaid(step, printed)]


def written(words: list[str]) -> Iterator[str]:
    """Yield the files and folders that a command is told to write."""
    return (value for option, value in pairwise(words) if option in WRITTEN)


def missing(promised: tuple[str, ...], printed: list[str]) -> list[str]:
    """Return the expected lines without a similar printed line; tables are not compared."""
    lines = [line for line in promised if line.strip() and not TABLE.search(line)]
    return [line for line in lines if not any(alike(line, each) for each in printed)]


def unsaid(step: Step, printed: list[str]) -> list[str]:
    """Return printed lines of an ``fpnet`` command that its expected output lacks."""
    if step.words[0] != 'fpnet' or not step.promised:
        return []
    lines = [line for line in printed if line.strip() and not TABLE.search(line)]
    return [line for line in lines if not any(alike(each, line) for each in step.promised)]


def alike(promised: str, printed: str) -> bool:
    """Return whether two lines have the same words and nearly the same numbers."""
    one, other = (DURATION.sub('', ' '.join(line.split())) for line in (promised, printed))
    if NUMBER.sub('#', one) != NUMBER.sub('#', other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(near(first, second) for first, second in pairs)


def near(first: str, second: str) -> bool:
    """
    Return whether two numbers differ by at most a fifth, 5 mm or one unit of the last digit.

    The least error of a trajectory is a few millimetres and differs between processors by more
    than a fifth.
    """
    unit = 10.0 ** -len(first.partition('.')[2])
    allowed = max(NEAR * abs(float(first)), NEAR_M, 1.001 * unit)
    return abs(float(first) - float(second)) <= allowed


if __name__ == '__main__':
    main()
