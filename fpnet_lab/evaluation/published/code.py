# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of reports on the program itself: constants, damaged files, growth, disk usage."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from fpnet_lab.evaluation.speed.aims import AIM_M2, AIM_PEAK_BYTES, AIM_TICK_S
from fpnet_lab.scores import (
    Column,
    Figures,
    Row,
    Score,
    Table,
    Unit,
    Units,
    columns,
    reports_of,
)

_ALONE, _TOGETHER, _LATE, _NOTHING, _UNSEEN = range(5)
# Prefix and suffix written by `benchmarks/vary_constants.py`:
_ONLY_TOGETHER, _FAR_LONGER = 'only together', 'takes far longer'
_VARIED = (
    'change an answer alone',
    'only with neighbours',
    'not told: took too long',
    'change nothing',
    'looked up by no case',
)

_OUTCOMES = ('unclear', 'exception', 'memory', 'executed', 'timeout', 'crash')
_READERS = (  # numerical: digits
    *columns(Units.COUNT, {key: key for key in ('reader', 'inputs', 'accepted', 'refused')}),
    *columns(Units.COUNT, {key: key for key in _OUTCOMES}),
    Column('slowest [CPU s]', 'slowest_cpu_s', Units.NUMBER),
    Column('most memory', 'most_memory_mib', Unit(' MiB').in_title(0)),
)

_GIGABYTES = Unit(' GB', 2, 1e-9)  # given
_GROWTH = (  # numerical: digits
    Column('storey [m²]', lambda row: f'{row["area_m2"]:,.0f}'),
    Column('rooms found', lambda row: f'{row["rooms"]:,}'),
    Column('seen [m²]', lambda row: f'{row["explored_m2"]:,.0f}'),
    Column('floorplan, once', lambda row: row['plan'][1], Units.SECONDS.to(2)),
    Column('searching tick', lambda row: row['update'][1], Units.SECONDS.to(2)),
    Column('memory at its peak', 'peak_bytes', _GIGABYTES),
)
_WHEELS = (
    Column('Python', 'python'),
    Column('extra', 'name'),
    Column('size', 'megabytes', Unit(' MB')),
    Column('installed in', 'seconds', Unit(' s')),
)


def constants_varied(report: Row) -> Figures:
    """Return how many constants of each package affect results, by variation factor."""
    answers = _answers(reports_of(report))
    rows = []
    for factor in sorted({factor for factor, _, _ in answers}):
        found = {key: kind for key, kind in answers.items() if key[0] == factor}
        by_package: dict[str, list[int]] = {}
        for (_, module, _), kind in found.items():
            by_package.setdefault(module.split('.')[1], []).append(kind)
        order = sorted(by_package, key=lambda name: (-len(by_package[name]), name))
        rows += [_varied(factor, f'`{name}`', by_package[name]) for name in order]
        rows.append(_varied(factor, 'all', list(found.values())))
    titles = ('times', 'package', 'tried', *_VARIED)
    return {'': Table(titles, rows)}, {}


def _answers(reports: Sequence[Row]) -> dict[tuple[float, str, str], int]:
    """Return each constant's effect by factor, module and name; the strongest of all reports."""
    found: dict[tuple[float, str, str], int] = {}
    for report in reports:
        for row in report['rows']:
            key = (report['factor'], row['module'], row['name'])
            found[key] = min(_kind(row), found.get(key, _UNSEEN))
    return found


def _kind(row: Row) -> int:
    """Return the index of a constant's effect in :data:`_VARIED`."""
    if row['answer'] != 'changed':
        return _NOTHING if row['answer'] == 'nothing' else _UNSEEN
    first = str(row['first'])
    if first.startswith(_ONLY_TOGETHER):
        return _TOGETHER
    return _LATE if first.endswith(_FAR_LONGER) else _ALONE


def _varied(factor: float, name: str, kinds: Sequence[int]) -> list[str]:
    """Return a row; constants that no case reads do not count as tried."""
    counts = [kinds.count(kind) for kind in range(len(_VARIED))]
    return [f'{factor:g}', name, *map(str, (sum(counts[:_UNSEEN]), *counts))]


def readers(report: Row) -> Figures:
    """Return the outcomes of damaged files, by group of readers."""
    return {'': Table.of(_READERS, report['readers'])}, {}


def growth(report: Row) -> Figures:
    """Return costs by storey size; with aims and stages of an update for the size with aims."""
    storeys = report['growth']
    tables = {'': Table.of(_GROWTH, storeys)}
    values: dict[str, str] = {}
    for storey in storeys:
        if storey['area_m2'] == AIM_M2:
            tables['aims'] = Table.of_aims(_growth_scores(storey))
            tables['stages'] = _stages(storey)
    return tables, values


def _growth_scores(storey: Row) -> Sequence[Score]:
    update, memory = f'searching tick on {AIM_M2:,} m², by the clock', 'memory at its peak'
    return (
        Score(update, storey['update'][0], Units.SECONDS.to(2), AIM_TICK_S),
        Score(memory, storey['peak_bytes'], _GIGABYTES, AIM_PEAK_BYTES),
    )


def _stages(storey: Row) -> Table:
    """Return the stages of an update by wall time, longest first."""
    unit = Units.SECONDS.in_title(2)
    stages = sorted(storey['stages_s'].items(), key=lambda item: -item[1])
    rows = [[name, unit.text(seconds)] for name, seconds in stages]
    return Table((f'stage of it, on {AIM_M2:,} m²', unit.title('by the clock')), rows)


def wheels(report: Row) -> Figures:
    """Return the disk usage of each extra in addition to the base installation."""
    rows: list[Row] = [*_beside(report['environments'])]
    return {'': Table.of(_WHEELS, rows)}, {}


def _beside(environments: Iterable[Row]) -> Iterable[dict[str, Any]]:
    """Yield environments; an extra's size is relative to the base installation of its Python."""
    without = {e['python']: e['megabytes'] for e in environments if e['extra'] == 'none'}
    for each in environments:
        is_bare = each['extra'] == 'none'
        size = each['megabytes'] - (0 if is_bare else without[each['python']])
        name = 'none: what a robot needs' if is_bare else f'`{each["extra"]}`'
        yield {**each, 'name': name, 'megabytes': size}
