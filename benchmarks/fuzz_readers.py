# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fuzz every reader with damaged files and count the outcomes.

Usage: python benchmarks/fuzz_readers.py --count 10000 [--seed N] [--workers N]
       [--readers bags images ...] [--keep DIR] [--json FILE]; then
fpnet bench figures readers=FILE

Each input is a valid file after random mutations (test/fuzzing), read in a worker process limited
to 10 s of CPU time and 2 GiB. A reader may accept it or reject it with a clear FpnetError.
Anything else is a failure, printed with its index and stored in DIR. Exits 1 after a failure.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
import shutil
import sys
import tempfile
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))

from fuzzing.harness import GOOD, Case, Outcome, Result, fuzz, make_input, plan
from fuzzing.readers import READERS, readers_of

from fpnet.cli.progress import progress
from fpnet_lab.cli.reports import finish, script_parser

_BAD = tuple(outcome for outcome in Outcome if outcome not in GOOD)


def main() -> None:
    """Run the inputs, and print the table and the failures."""
    parser = script_parser(__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=10_000)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--workers', type=int, default=2)
    parser.add_argument(
        '--readers', nargs='*', default=[], choices=sorted({r.group for r in READERS})
    )
    parser.add_argument('--keep', type=Path, metavar='DIR', help='copy failing inputs here')
    arguments = parser.parse_args()
    cases = plan(readers_of(arguments.readers), arguments.count, arguments.seed)
    results: dict[str, list[Result]] = defaultdict(list)
    with progress('fuzzing', total=len(cases)) as advance:
        for result in fuzz(cases, arguments.workers):
            results[result.case.reader.group].append(result)
            advance(1.0)
            if result.outcome not in GOOD:
                report(result, arguments.keep)
    rows = [row(group, found) for group, found in results.items()]
    rows.append(row('all', [result for found in results.values() for result in found]))
    finish('readers', arguments.json, {'seed': arguments.seed, 'readers': rows})
    raise SystemExit(1 if rows[-1]['failures'] else 0)


def row(group: str, results: list[Result]) -> dict[str, Any]:
    """Return the counts of one group of readers."""
    counts = {
        outcome.value: sum(result.outcome == outcome for result in results) for outcome in Outcome
    }
    return {
        'reader': group,
        'inputs': len(results),
        **counts,
        'failures': sum(counts[outcome.value] for outcome in _BAD),
        'slowest_cpu_s': round(max(result.seconds for result in results), 2),
        'most_memory_mib': round(max(result.grown_bytes for result in results) / 2**20),
    }


def report(result: Result, keep: Path | None) -> None:
    """Print a failure, and store its input if ``keep`` is given."""
    case = result.case
    print(
        f'{case.reader.group}, {case.reader.name}, input {case.index}: {result.outcome}: '
        f'{result.detail}',
        file=sys.stderr,
    )
    if keep is not None:
        _keep(case, keep / f'{READERS.index(case.reader)}_{case.index}')


def _keep(case: Case, folder: Path) -> None:
    with tempfile.TemporaryDirectory() as scratch:
        valid = case.reader.write(Path(scratch))
        shutil.rmtree(folder, ignore_errors=True)
        make_input(case, valid if valid != Path(scratch) else valid / '', folder)


if __name__ == '__main__':
    main()
