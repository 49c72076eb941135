# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Follow the tutorial word for word, and compare what comes out with what the page promises.

Run: python tools/walkthrough.py [PAGE] [--work DIR]    (make walkthrough)

Each command of a ``bash`` block is run in an empty folder; the lines of the block below it are
its promised output, and what ``fpnet`` prints must all be there. Words must be the same, and
numbers nearly: a fifth of them or one unit off their last digit; durations may be any. A file
that a command is told to write must be there.
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
NEAR = 0.2
TIMEOUT_S = 600


@dataclass(frozen=True)
class Step:
    """A command of a page, and the lines that it promises."""

    command: str
    promised: tuple[str, ...]

    @property
    def words(self) -> list[str]:
        """The command's words."""
        return shlex.split(self.command)

    @property
    def program(self) -> str | None:
        """The program, of this environment first; None where it is not installed."""
        beside = str(Path(sys.executable).parent)
        return shutil.which(self.words[0], path=beside) or shutil.which(self.words[0])


def main() -> None:
    """Run all steps, say how long each took, and exit 1 where one is not as promised."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('page', type=Path, nargs='?', default=ROOT / 'docs' / 'tutorial.md')
    parser.add_argument('--work', type=Path, help='an empty folder; default: a temporary one')
    arguments = parser.parse_args()
    work = arguments.work or Path(tempfile.mkdtemp(prefix='walkthrough-'))
    broken = 0
    for step in steps(arguments.page.read_text(encoding='utf-8')):
        if step.program is None:
            print(f'left out, as it is not installed here: {step.command}')
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
    """Return the page's commands in their order, with the output that follows each."""
    found: list[Step] = []
    for kind, text in BLOCK.findall(page):
        if kind == 'bash':
            found += [Step(line.partition('  #')[0].strip(), ()) for line in text.splitlines()]
        elif not kind and found and not found[-1].promised and not is_command(text):
            found[-1] = Step(found[-1].command, tuple(text.splitlines()))
    return found


def is_command(text: str) -> bool:
    """Tell commands that are not to be run, as those that need a robot, from outputs."""
    return text.startswith(('ros2 ', 'fpnet '))


def follow(step: Step, work: Path) -> list[str]:
    """Run a step and return what is not as promised."""
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
    """Return the promised lines that nothing printed is like; tables are left to the eye."""
    lines = [line for line in promised if line.strip() and not TABLE.search(line)]
    return [line for line in lines if not any(alike(line, each) for each in printed)]


def unsaid(step: Step, printed: list[str]) -> list[str]:
    """Return the lines of an own command that the page does not have, though it promises some."""
    if step.words[0] != 'fpnet' or not step.promised:
        return []
    lines = [line for line in printed if line.strip() and not TABLE.search(line)]
    return [line for line in lines if not any(alike(each, line) for each in step.promised)]


def alike(promised: str, printed: str) -> bool:
    """Tell whether two lines have the same words, and nearly the same numbers."""
    one, other = (DURATION.sub('', ' '.join(line.split())) for line in (promised, printed))
    if NUMBER.sub('#', one) != NUMBER.sub('#', other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(near(first, second) for first, second in pairs)


def near(first: str, second: str) -> bool:
    """Tell whether two numbers are a fifth of them, or one unit of the last digit, apart."""
    unit = 10.0 ** -len(first.partition('.')[2])
    return abs(float(first) - float(second)) <= max(NEAR * abs(float(first)), 1.001 * unit)


if __name__ == '__main__':
    main()
