# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Measure the first minute: compilation after an installation, and the way from shell to first work.

Run: python benchmarks/cold_start.py [--runs N]

Compiles everything that a robot needs in an empty folder, loads it from there in a second process,
and starts commands up to the first read of their floorplan. All times are processor seconds of one
process; the least of N runs is printed. Compilation is measured once.
"""

import ast
import os
from pathlib import Path
import subprocess
import sys
import tempfile

from fpnet_lab.cli.reports import script_parser

ROOT = Path(__file__).resolve().parents[1]
WARM_UP = """
import time
from fpnet_core.config import FpnetConfig
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.warm_up import warm_up
warm_up(create_localizer(FpnetConfig()))
print(time.process_time())
"""
START = """
import sys, time
def read(*_):
    print(time.process_time())
    raise SystemExit
import fpnet_core.drawings.read
fpnet_core.drawings.read.read_plan = read
from fpnet.cli import main
main(sys.argv[1:])
"""


def kernels(folder: Path) -> int:
    """Return the number of functions below ``folder`` that Numba compiles."""
    trees = [ast.parse(path.read_text(encoding='utf-8')) for path in folder.rglob('*.py')]
    functions = [n for tree in trees for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
    return sum('njit' in ast.unparse(d) for each in functions for d in each.decorator_list)


def seconds(code: str, *arguments: object, cache: Path) -> float:
    """Return the processor time that a new process prints."""
    environment = {**os.environ, 'NUMBA_CACHE_DIR': str(cache), 'OMP_NUM_THREADS': '1'}
    done = subprocess.run(  # noqa: S603 - our own code
        [sys.executable, '-c', code, *map(str, arguments)],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return float(done.stdout.split()[-1])


def main() -> None:
    """Print the times."""
    parser = script_parser(__doc__)
    parser.add_argument('--runs', type=int, default=3)
    runs = parser.parse_args().runs
    for package in ('fpnet_core', 'fpnet', 'fpnet_lab'):
        print(f'{package}: {kernels(ROOT / package)} compiled functions')
    with tempfile.TemporaryDirectory(prefix='cold-start-') as name:
        cache = Path(name) / 'kernels'
        print(f'first warm-up, empty cache: {seconds(WARM_UP, cache=cache):.1f} s')
        later = min(seconds(WARM_UP, cache=cache) for _ in range(runs))
        print(f'later warm-ups: {later:.2f} s')
        plan = Path(name) / 'plan.png'
        plan.touch()
        for words in (('match', '--submap', plan, '--floorplan', plan), ('plan', plan)):
            least = min(seconds(START, *words, cache=cache) for _ in range(runs))
            print(f'fpnet {words[0]} to its first work: {least:.2f} s')


if __name__ == '__main__':
    main()
