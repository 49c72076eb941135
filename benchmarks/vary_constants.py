# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Sensitivity of results to the core's constants, each a fifth larger and smaller.

Usage::

    python benchmarks/vary_constants.py --json OUT                 # chosen and numerical ones
    python benchmarks/vary_constants.py --only segmentation,pose   # of some packages
    python benchmarks/vary_constants.py --factor 4                 # four times and a quarter of it
    python benchmarks/vary_constants.py --cases plans,picture      # only where names hold a word
    python benchmarks/vary_constants.py --known OUT                # of those that decided there
    fpnet bench figures constants_varied=OUT constants_varied=OTHER   # one table of several runs

Cases (``varied_cases.py``) are evaluated with changed constants. A different answer is defined as
in ``fpnet bench regression``. Inputs are created before.

Several constants are changed at a time, each in a random direction, and then all in the opposite
direction. If an answer changes, the group is bisected down to a single constant. Each group runs
in a separate process, with the fastest cases first, and only with cases that run a function which
looks up one of the constants; compiled kernels that do are recompiled there. Integers change by at
least one. A constant that no case looks up, or that is only read when a module is loaded, is
listed as ``not run``. A case that takes much longer than before counts as a different answer.
"""

from __future__ import annotations

from argparse import Namespace
import ast
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
import gc
import importlib
import json
import multiprocessing
from multiprocessing.connection import Connection
from pathlib import Path
import pkgutil
import resource
import runpy
import sys
from tempfile import TemporaryDirectory
import time
from types import CodeType, FrameType
from typing import Any

import numba
import numpy as np
from varied_cases import all_cases, first_difference

import fpnet_core
from fpnet_core.config import FpnetConfig
from fpnet_lab.cli.reports import script_parser, write_report
from fpnet_lab.evaluation.regression import Answer, RegressionCase
from fpnet_lab.training import use_threads

ROOT = Path(__file__).resolve().parents[1]
_SEED = 5  # numerical: of directions
_PATIENCE = 30.0, 60.0  # chosen: timeout as a multiple of the usual time, and its minimum [s]
_MEMORY_BYTES = 6 * 2**30  # numerical: memory limit of a trial

Name = tuple[str, str]
"""A module and a name in it."""


@dataclass(frozen=True, eq=False)
class Varied:
    """A constant, and all names under which it was imported."""

    module: str
    name: str
    homes: frozenset[Name]


@dataclass(eq=False)
class Timed:
    """A case, its answer, the names that its functions look up, and its CPU time [s]."""

    case: RegressionCase
    outcome: Answer
    lookups: frozenset[Name]
    seconds: float


@dataclass(eq=False)
class Trials:
    """Cases, and the changes of constants evaluated on them."""

    timed: list[Timed]
    config: FpnetConfig
    factor: float
    ups: dict[Varied, bool] = field(default_factory=dict)
    count: int = 0

    def deciding(self, group: Sequence[Varied], is_turned: bool) -> Iterator[tuple[Varied, str]]:
        """Yield the constants of a group that change an answer, with the first difference."""
        factors = {
            each: self.factor if self.ups[each] != is_turned else 1.0 / self.factor
            for each in group
        }
        line = self.other_answer(factors)
        if line and len(group) == 1:
            yield group[0], f'x {factors[group[0]]:.2f}: {line}'
        elif line:
            middle = len(group) // 2
            found = [
                each
                for half in (group[:middle], group[middle:])
                for each in self.deciding(half, is_turned)
            ]
            yield from found or [(each, f'only together: {line}') for each in group]

    def other_answer(self, factors: dict[Varied, float]) -> str:
        """Return the first difference caused by changed constants, or an empty string."""
        homes = frozenset[Name]().union(*(each.homes for each in factors))
        relevant = [t for t in self.timed if homes & t.lookups]
        context = multiprocessing.get_context('fork')
        receiver, sender = context.Pipe(duplex=False)
        process = context.Process(target=answer_all, args=(factors, relevant, self.config, sender))
        process.start()
        sender.close()
        self.count += 1
        try:
            return next(filter(None, (_received(receiver, t) for t in relevant)), '')
        finally:
            process.kill()
            process.join()


def main() -> None:
    """Vary the selected constants; print a line for each and write the report."""
    parser = script_parser(__doc__.splitlines()[1])
    parser.add_argument('--only', default='', help='packages or modules of fpnet_core, by commas')
    parser.add_argument('--kinds', default='chosen,numerical', help='kinds of constants')
    parser.add_argument('--cases', default='', help='parts of names of cases, by commas')
    parser.add_argument('--factor', type=float, default=1.2, help='factor of change')
    parser.add_argument('--group', type=int, default=8, help='constants per trial')
    parser.add_argument('--known', type=Path, help='report; try only constants decisive there')
    args = parser.parse_args()
    use_threads(1)
    for module in pkgutil.walk_packages(fpnet_core.__path__, 'fpnet_core.'):
        if not module.name.endswith('__main__'):
            importlib.import_module(module.name)
    with TemporaryDirectory() as folder:
        vary(args, FpnetConfig(), Path(folder))


def vary(args: Namespace, config: FpnetConfig, folder: Path) -> None:
    """Vary constants on cases with files in ``folder``."""
    words = args.cases.split(',')
    cases = (case for case in all_cases(config, folder) if any(w in case.name for w in words))
    timed = sorted(baseline(cases, config), key=lambda t: t.seconds)
    trials = Trials(timed, config, args.factor)
    gc.freeze()
    every = list(asked(args))
    seen = frozenset[Name]().union(*(t.lookups for t in trials.timed))
    rows = [_row(each, 'not run') for each in every if not each.homes & seen]
    tried = [each for each in every if each.homes & seen]
    rng = np.random.default_rng(_SEED)
    trials.ups = {each: bool(rng.integers(2)) for each in tried}
    for start in range(0, len(tried), args.group):
        group = tried[start : start + args.group]
        found = dict(trials.deciding(group, is_turned=False))
        left = [each for each in group if each not in found]
        found |= dict(trials.deciding(left, is_turned=True)) if left else {}
        rows += [
            _row(each, 'changed' if each in found else 'nothing', found.get(each, ''))
            for each in group
        ]
        for row in rows[-len(group) :]:
            print(f'{row["answer"]:8s} {row["module"]}.{row["name"]}  {row["first"]}', flush=True)
        write_report(args.json, {'factor': args.factor, 'cases': len(trials.timed), 'rows': rows})
    print(dict(Counter(row['answer'] for row in rows)), f'{trials.count} tries')


def asked(args: Namespace) -> Iterator[Varied]:
    """Yield the constants selected on the command line."""
    tool = runpy.run_path(str(ROOT / 'tools' / 'constants.py'))
    importers = imported()
    known = json.loads(args.known.read_text(encoding='utf-8'))['rows'] if args.known else None
    decided = {(row['module'], row['name']) for row in known or () if row['answer'] == 'changed'}
    every = [(_module_of(each.path), each) for each in tool['constants']('fpnet_core')]
    for only in args.only.split(','):
        for module, constant in every:
            name = (module, constant.name)
            if constant.kind not in args.kinds.split(',') or (known and name not in decided):
                continue
            if f'{module}.'.startswith(f'fpnet_core.{only}.' if only else 'fpnet_core.'):
                yield Varied(*name, frozenset(_homes(name, importers)))


def _module_of(path: Path) -> str:
    return '.'.join(path.with_suffix('').parts).removesuffix('.__init__')


def imported() -> dict[Name, list[Name]]:
    """Return the (module, name) pairs that import each name from another module of the core."""
    found: dict[Name, list[Name]] = {}
    for name, module in _modules():
        source = Path(str(module.__file__)).read_text(encoding='utf-8')
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    known = (name, alias.asname or alias.name)
                    found.setdefault((node.module, alias.name), []).append(known)
    return found


def _homes(name: Name, importers: dict[Name, list[Name]]) -> Iterator[Name]:
    yield name
    for importer in importers.get(name, ()):
        yield from _homes(importer, importers)


def baseline(cases: Iterable[RegressionCase], config: FpnetConfig) -> Iterator[Timed]:
    """Yield cases with their answers for unchanged constants; the second run is timed."""
    for case in cases:
        ran: set[tuple[str, CodeType]] = set()

        def note(
            frame: FrameType, event: str, _: object, ran: set[tuple[str, CodeType]] = ran
        ) -> None:
            if event == 'call':
                ran.add((frame.f_globals.get('__name__', ''), frame.f_code))

        forget()
        sys.setprofile(note)
        case.answer(config)
        sys.setprofile(None)
        start = time.process_time()
        outcome = case.answer(config)
        seconds = time.process_time() - start
        print(f'{case.name} {seconds:.2f} s', flush=True)
        yield Timed(case, outcome, lookups(ran), seconds)


def lookups(ran: Iterable[tuple[str, CodeType]]) -> frozenset[Name]:
    """Return the names that code of the core's modules looks up, including called kernels."""
    found: set[Name] = set()
    left = [(module, code) for module, code in ran if module.startswith('fpnet_core')]
    while left:
        module, code = left.pop()
        for name in code.co_names:
            if (module, name) in found:
                continue
            found.add((module, name))
            kernel = getattr(vars(sys.modules[module]).get(name), 'py_func', None)
            if kernel is not None:
                left += [(kernel.__module__, inner) for inner in nested(kernel.__code__)]
    return frozenset(found)


def nested(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object and its nested code objects."""
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from nested(inner)


def answer_all(
    factors: dict[Varied, float], timed: list[Timed], config: FpnetConfig, sender: Connection
) -> None:
    """Evaluate cases with changed constants; send each one's difference or an empty string."""
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY_BYTES, _MEMORY_BYTES))
    forget()
    change(factors)
    for each in timed:
        try:
            found = each.case.answer(config)
            line = first_difference(each.case, found, each.outcome)
        except Exception as error:
            line = f'{each.case.name}: {type(error).__name__}: {error}'
        sender.send(line)


def _received(receiver: Connection, timed: Timed) -> str:
    """Return the received line of a case, or a line about a timeout or crash."""
    if not receiver.poll(max(_PATIENCE[0] * timed.seconds, _PATIENCE[1])):
        return f'{timed.case.name}: takes much longer'
    try:
        return str(receiver.recv())
    except EOFError:
        return f'{timed.case.name}: ends the process'


def change(factors: dict[Varied, float]) -> None:
    """Change constants in this process, and recompile the kernels that read them."""
    for each, by in factors.items():
        value = scaled(getattr(sys.modules[each.module], each.name), by)
        for module, name in each.homes:
            setattr(sys.modules[module], name, value)
    changed = frozenset[Name]().union(*(each.homes for each in factors))
    for _, module in _modules():
        for name, kernel in list(vars(module).items()):
            function = getattr(kernel, 'py_func', None)
            if function is None or function.__module__ != module.__name__:
                continue
            codes = [(module.__name__, code) for code in nested(function.__code__)]
            if changed & lookups(codes):
                new = numba.jit(**kernel.targetoptions)(function)
                for _, other in _modules():
                    if vars(other).get(name) is kernel:
                        setattr(other, name, new)


def forget() -> None:
    """Clear the caches of the core's functions."""
    for _, module in _modules():
        for value in vars(module).values():
            if hasattr(value, 'cache_clear'):
                value.cache_clear()


def _modules() -> list[tuple[str, Any]]:
    return [(name, m) for name, m in list(sys.modules.items()) if name.startswith('fpnet_core')]


def scaled(value: Any, by: float) -> Any:
    """Return a number, or each of several, times ``by``; integers change by at least one."""
    if isinstance(value, bool | str) or value is None:
        return value
    if isinstance(value, int):
        moved = round(value * by)
        return moved if moved != value else max(value + (1 if by > 1.0 else -1), 0)
    if isinstance(value, dict):
        return {key: scaled(item, by) for key, item in value.items()}
    if isinstance(value, tuple | list):
        parts = [scaled(item, by) for item in value]
        return type(value)(*parts) if hasattr(value, '_fields') else type(value)(parts)
    if is_dataclass(value) and not isinstance(value, type):
        moved = {field.name: scaled(getattr(value, field.name), by) for field in fields(value)}
        return replace(value, **moved)
    return value * by if isinstance(value, float | np.ndarray | np.floating) else value


def _row(each: Varied, answer: str, first: str = '') -> dict[str, str]:
    return {'module': each.module, 'name': each.name, 'answer': answer, 'first': first}


if __name__ == '__main__':
    main()
