# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Which constants of the core decide anything: each a fifth larger and smaller, what is answered?

Usage::

    python benchmarks/vary_constants.py --json OUT            # those that say `chosen`
    python benchmarks/vary_constants.py --only segmentation   # of one package
    python benchmarks/vary_constants.py --factor 4            # four times and a quarter of it

The first cases of ``fpnet bench regression`` are answered with one constant changed after another,
and so are submaps that are cut into rooms and drawings that are read from files; what counts as
another answer is that benchmark's. Inputs are made before. A module's
constants are only tried on cases that run something of a module that uses them. Whole numbers move
by one at least. Those that compiled kernels hold, and those that are read where a module is
loaded, keep their values here: they are listed, not varied. A try that takes far longer than
before counts as another answer.
"""

from __future__ import annotations

from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import partial
import importlib
from itertools import chain
from pathlib import Path
import runpy
import signal
import sys
from tempfile import TemporaryDirectory
import time
from types import CodeType, FrameType, ModuleType
from typing import Any

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.types import Segmentation
from fpnet_lab.cli.reports import script_parser, write_report
from fpnet_lab.evaluation.drawings import segmented, written
from fpnet_lab.evaluation.regression import Answer, RegressionCase, differences, make_cases
from fpnet_lab.evaluation.submap_recordings import RegisteredDrive, registered_drive
from fpnet_lab.evaluation.submap_segmentation import segment_drive
from fpnet_lab.sim.sheets import SheetKind, draw_sheet
from fpnet_lab.training import use_threads

ROOT = Path(__file__).resolve().parents[1]
CASES = {'plans': 6, 'pairs': 8, 'drives': 4}
"""Of each kind; all bands, families and sensors of the benchmark. Chosen: some seconds a try."""

SENSORS = ('planar', 'dome')
SHEETS = (('clean', 'picture'), ('office', 'dxf'), ('office', 'svg'), ('scan', 'picture'))
"""Whose submaps are cut; kinds of drawings and their files. Chosen: half a minute for all."""

_SEED = 77  # numerical: of the first submap, and of the first drawing, both of tune halves
_PATIENCE = 10.0, 20.0  # chosen: times as long as before, and so many seconds at least

ANSWERS = ('changed', 'nothing', 'compiled', 'at import', 'not run')
"""What a constant may turn out to be: see the module's text for the third and the fourth."""


@dataclass(frozen=True)
class Timed:
    """A case, what it answered, the modules that ran, and how long it took [s]."""

    case: RegressionCase
    outcome: Answer
    modules: frozenset[str]
    seconds: float


def main() -> None:
    """Vary what the command line asks for; print a line each and write all."""
    parser = script_parser(__doc__.splitlines()[1])
    parser.add_argument('--only', default='', help='package of fpnet_core')
    parser.add_argument('--kind', default='chosen', help='what the constants say of themselves')
    parser.add_argument('--factor', type=float, default=1.2, help='by how much')
    args = parser.parse_args()
    use_threads(1)
    signal.signal(signal.SIGALRM, too_slow)
    config = FpnetConfig()
    with TemporaryDirectory() as folder:
        vary(args, config, Path(folder))


def vary(args: Namespace, config: FpnetConfig, folder: Path) -> None:
    """Vary constants on cases whose files lie in a folder."""
    timed = sorted(baseline(config, folder), key=lambda t: t.seconds)
    print(', '.join(f'{t.case.name} {t.seconds:.1f} s' for t in timed), flush=True)
    tool = runpy.run_path(str(ROOT / 'tools' / 'constants.py'))
    rows = []
    for constant in tool['constants']('fpnet_core'):
        name = '.'.join(constant.path.with_suffix('').parts).removesuffix('.__init__')
        if constant.kind != args.kind or not name.startswith(f'fpnet_core.{args.only}'):
            continue
        answer, why = tried(name, constant.name, args.factor, timed, config)
        rows.append({'module': name, 'name': constant.name, 'answer': answer, 'first': why})
        print(f'{answer:10s} {name}.{constant.name}  {why}', flush=True)
        write_report(args.json, {'factor': args.factor, 'cases': len(timed), 'rows': rows})
    print(dict(Counter(row['answer'] for row in rows)))


def submap_cases(config: FpnetConfig) -> Iterator[RegressionCase]:
    """Yield a drive of each of some sensors, to be laid into a submap and cut into rooms."""
    for number, sensor in enumerate(SENSORS):
        drive = registered_drive(_SEED + number, sensor, config)
        yield RegressionCase('plans', f'submap-{sensor}', partial(cut_submap, drive))


def cut_submap(drive: RegisteredDrive, config: FpnetConfig) -> Answer:
    """Return the rooms and doors of all that a drive has seen."""
    return rooms_of(segment_drive(drive, config), [len(drive.sweeps)])


def sheet_cases(folder: Path) -> Iterator[RegressionCase]:
    """Yield drawings that are read as a user's are, vector files in this process, too."""
    worker = importlib.import_module('fpnet_core.drawings.worker')
    worker.read_apart = worker._read  # type: ignore[attr-defined]
    for number, (kind, file_format) in enumerate(SHEETS):
        sheet = draw_sheet(_SEED + number, SheetKind(kind))
        path, _ = written(sheet, folder / f'{number}-{kind}', file_format)
        yield RegressionCase('plans', f'{file_format}-{kind}', partial(cut_sheet, path))


def cut_sheet(path: Path, config: FpnetConfig) -> Answer:
    """Return the rooms and doors of a drawing; its scale is part of their areas."""
    reading = read_plan(path, ReadOptions(), config)
    return rooms_of(segmented(reading, config.segmentation), [len(reading.doubts) + 1])


def rooms_of(found: Segmentation, told: list[int]) -> Answer:
    """Return rooms and doors as the benchmark compares them, and what else must be the same."""
    areas = sorted((round(room.area_m2, 2) for room in found.rooms), reverse=True)
    return {
        'input': told, 'rooms': len(found.rooms), 'doors': len(found.doors), 'areas_m2': areas
    }  # fmt: skip


def baseline(config: FpnetConfig, folder: Path) -> Iterator[Timed]:
    """Yield the cases with what they answer as things are; the second run is timed."""
    for case in chain(make_cases(CASES), submap_cases(config), sheet_cases(folder)):
        ran: set[str] = set()

        def note(frame: FrameType, *_: object, ran: set[str] = ran) -> None:
            ran.add(frame.f_globals.get('__name__', ''))

        sys.setprofile(note)
        case.answer(config)
        sys.setprofile(None)
        start = time.perf_counter()
        outcome = case.answer(config)
        yield Timed(case, outcome, frozenset(ran), time.perf_counter() - start)


def tried(
    module: str, name: str, factor: float, timed: list[Timed], config: FpnetConfig
) -> tuple[str, str]:
    """Return what a constant turned out to be, and the first answer that it changed."""
    if module not in sys.modules:
        return 'not run', ''
    value = getattr(sys.modules[module], name)
    homes = [
        other
        for other in list(sys.modules.values())
        if getattr(other, '__name__', '').startswith('fpnet_core')
        and getattr(other, '__dict__', {}).get(name) is value
    ]
    readers = [home for home in homes if any(name in c.co_names for c in codes(home))]
    if any(name in c.co_names for home in homes for c in compiled(home)):
        return 'compiled', ''
    if not readers:
        return 'at import', ''
    names = {home.__name__ for home in readers}
    relevant = [t for t in timed if names & t.modules]
    if not relevant:
        return 'not run', ''
    for by in (factor, 1.0 / factor):
        with changed(homes, name, scaled(value, by)):
            for t in relevant:
                if line := other_answer(t, config):
                    return 'changed', f'x {by:.2f}: {line}'
    return 'nothing', ''


def other_answer(timed: Timed, config: FpnetConfig) -> str:
    """Return how a case is answered otherwise now, or nothing."""
    kind, name = timed.case.kind, timed.case.name
    signal.setitimer(signal.ITIMER_REAL, max(_PATIENCE[0] * timed.seconds, _PATIENCE[1]))
    try:
        found = timed.case.answer(config)
    except Exception as error:
        return f'{name}: {type(error).__name__}: {error}'
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    lines = differences({kind: {name: found}}, {kind: {name: timed.outcome}})
    return lines[0] if lines else ''


def too_slow(_number: int, _frame: FrameType | None) -> None:
    """End a try that takes too long."""
    raise TimeoutError('takes far longer')


@contextmanager
def changed(homes: list[ModuleType], name: str, value: object) -> Iterator[None]:
    """Give a constant another value wherever it has been imported to."""
    before = [getattr(home, name) for home in homes]
    for home in homes:
        setattr(home, name, value)
    try:
        yield
    finally:
        for home, old in zip(homes, before, strict=True):
            setattr(home, name, old)


def scaled(value: Any, by: float) -> Any:
    """Return a number, or each of several, times ``by``; whole ones move by one at least."""
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


def codes(module: ModuleType) -> Iterator[CodeType]:
    """Yield the code of a module's own functions and classes, what is inside of them included."""
    path = Path(str(module.__file__))
    whole = compile(path.read_text(encoding='utf-8'), str(path), 'exec')
    for inner in whole.co_consts:
        if isinstance(inner, CodeType):
            yield from nested(inner)


def nested(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object and those inside of it."""
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from nested(inner)


def compiled(module: ModuleType) -> Iterator[CodeType]:
    """Yield the code of a module's compiled kernels."""
    for value in vars(module).values():
        kernel: Callable[..., object] | None = getattr(value, 'py_func', None)
        if kernel is not None and kernel.__module__ == module.__name__:
            yield from nested(kernel.__code__)


if __name__ == '__main__':
    importlib.import_module('fpnet_core.localizer.maps')
    main()
