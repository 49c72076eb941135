# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scores with name, value and unit, and tables of scores."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
import math
import re
from typing import Any, Self

Row = Mapping[str, Any]
"""A part of a benchmark's report, as its JSON holds it."""


@dataclass(frozen=True)
class Unit:
    """
    Number format: the value times ``factor`` with ``digits``, then ``symbol`` with its space.

    Values of ``whole_from`` or more have no digits. ``halves_up`` rounds halves up, otherwise
    halves round to even. With ``is_in_title`` the symbol is in the column title, not in the cells.
    ``nothing`` replaces None and NaN.
    """

    symbol: str = ''
    digits: int = 0
    factor: float = 1.0
    whole_from: float = math.inf
    halves_up: bool = False
    is_in_title: bool = False
    nothing: str = ''

    def to(self, digits: int, nothing: str = '') -> Unit:
        """Return the unit with another number of digits."""
        return replace(self, digits=digits, nothing=nothing)

    def in_title(self, digits: int, nothing: str = '') -> Unit:
        """Return the unit for a column that shows the symbol in its title."""
        return replace(self, digits=digits, nothing=nothing, is_in_title=True)

    def title(self, name: str) -> str:
        """Return the title of a column."""
        return f'{name} [{self.symbol.strip()}]' if self.is_in_title else name

    def text(self, value: Any) -> str:
        """Return a value as text."""
        if isinstance(value, str):
            return value
        if value is None or math.isnan(value):
            return self.nothing
        digits = 0 if value >= self.whole_from else self.digits
        number = self.factor * value
        if self.halves_up:
            number = math.floor(number * 10.0**digits + 0.5) / 10.0**digits
        return f'{number:.{digits}f}{"" if self.is_in_title else self.symbol}'


class Units:
    """Units of scores; the numbers of digits are chosen."""

    COUNT, NUMBER = Unit(), Unit(digits=2)
    SHARE, FINE_SHARE = Unit(' %', factor=100.0), Unit(' %', 1, 100.0)
    METRES, PATH, DEGREES = Unit(' m', 2), Unit(' m', 1), Unit(' deg', 1)
    AREA = Unit(' m²')
    SECONDS, MS = Unit(' s', 1), Unit(' ms')


@dataclass(frozen=True)
class Score:
    """
    A measured value: a number, a text, or None if nothing was measured.

    ``aim`` is the upper limit of the value, or its lower limit if ``is_floor``; None: no aim.
    """

    name: str
    value: Any
    unit: Unit = Units.COUNT
    aim: float | None = None
    is_floor: bool = False

    @property
    def is_met(self) -> bool:
        """Return whether the aim is met: True without an aim, False without a value."""
        if self.aim is None or self.value is None:
            return self.aim is None
        return bool(self.value >= self.aim if self.is_floor else self.value <= self.aim)

    def __str__(self) -> str:
        """Return the value with its unit."""
        return self.unit.text(self.value)

    @property
    def said_aim(self) -> str:
        """Return the aim as text, marked if it is missed."""
        return self.unit.text(self.aim) + ('' if self.is_met else ', missed')


@dataclass(frozen=True)
class Column:
    """One score of each row of a report; ``source`` is its key or computes it from the row."""

    title: str
    source: str | Callable[[Row], Any]
    unit: Unit = Units.COUNT

    def score(self, row: Row) -> Score:
        """Return the score of a row; KeyError if the row has none."""
        value = row[self.source] if isinstance(self.source, str) else self.source(row)
        return Score(self.title, value, self.unit)


@dataclass(frozen=True)
class Table:
    """Titles, rows of cells, and an optional sentence below."""

    titles: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ''

    @classmethod
    def of(cls, columns: Sequence[Column], rows: Iterable[Row], note: str = '') -> Self:
        """Return a table of the rows of a report."""
        titles = [column.unit.title(column.title) for column in columns]
        cells = [[str(column.score(row)) for column in columns] for row in rows]
        return cls(titles, cells, note)

    @classmethod
    def of_scores(cls, rows: Sequence[Sequence[Score]]) -> Self:
        """Return a table of scores; all rows, at least one, hold the same scores."""
        titles = [score.unit.title(score.name) for score in rows[0]]
        return cls(titles, [[str(score) for score in row] for row in rows])

    @classmethod
    def of_aims(cls, scores: Sequence[Score]) -> Self:
        """Return a table with one score per row, its aim, and whether the aim is met."""
        rows = [
            [
                score.name,
                str(score),
                score.unit.text(score.aim),
                'met' if score.is_met else 'missed',
            ]
            for score in scores
        ]
        return cls(('what', 'measured', 'aim', ''), rows)

    def markdown(self) -> str:
        """Return the table as Markdown."""
        lines = [self.titles, ['---'] * len(self.titles), *self.rows]
        written = '\n'.join(f'| {" | ".join(cells)} |' for cells in lines)
        table = re.sub(r'\|  (?=\|)', '| ', written)
        return f'{table}\n\n{self.note}' if self.note else table


Figures = tuple[dict[str, Table], dict[str, str]]
"""Tables and inline figures of a benchmark for the documentation, by name."""

REPORTS = 'reports'
"""Key of a merged report for the reports of the single runs."""


def reports_of(report: Row) -> Sequence[Row]:
    """Return the reports of all merged runs, or the only report."""
    several: Sequence[Row] = report.get(REPORTS, [report])
    return several


def columns(unit: Unit, titles: Mapping[str, str]) -> list[Column]:
    """Return columns of one unit; ``titles`` are by key."""
    return [Column(title, key, unit) for key, title in titles.items()]


def named(rows: Mapping[str, Row], pattern: str = '{}') -> Iterator[dict[str, Any]]:
    """Yield the rows with their name, formatted by ``pattern``, as ``name``."""
    for name, row in rows.items():
        yield {**row, 'name': pattern.format(name)}


def together(*scores: tuple[str, Unit]) -> Callable[[Row], str]:
    """Return a function that joins several scores in one cell; unknown ones are omitted."""
    return lambda row: ', '.join(filter(None, (unit.text(row[key]) for key, unit in scores)))


def of(hits: str, cases: str) -> Callable[[Row], str]:
    """Return a function that formats two counts as ``3 of 7``."""
    return lambda row: f'{row[hits]} of {row[cases]}'


def share_of(share: str, cases: str) -> Callable[[Row], Any]:
    """Return a function that formats a share and a count as ``3 of 7``; None if unknown."""

    def text(row: Row) -> Any:
        hits = None if row[share] is None else round(row[share] * row[cases])
        return None if hits is None else f'{hits} of {row[cases]}'

    return text
