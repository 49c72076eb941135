# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Measured figures stand in tables that a command has written: none is copied by hand."""

from pathlib import Path
import re

import pytest

from fpnet_lab.evaluation.published.figures import pages

ROOT = Path(__file__).resolve().parents[2]
_WRITTEN = re.compile(r'<!-- figures: [\w.]+ -->\n.*?<!-- end -->', re.DOTALL)
_VALUE = re.compile(r'<!-- f:[\w.]+ -->.*?<!-- / -->')
_CODE = re.compile(r'^```.*?^```', re.DOTALL | re.MULTILINE)
_TABLE = re.compile(r'(?:^\|.*\n)+', re.MULTILINE)
_FIGURE = re.compile(r'[-\u2212±<>~]?\d[\d.,]*')
_PROSE = re.compile(r'[^\W\d_]{6,}')
"""A cell that begins with a number is a figure; with longer words it is a sentence."""

BY_HAND = {
    ('simulator.md', 'sensor'): 'beams and columns of the simulated sensors: given',
    ('ros.md', 'parameter'): 'defaults of what may be set',
}
"""Tables by page and a word of their first title that hold numbers nobody measured, and why."""

WRITTEN_WHOLE = {'matching_tables.md': 'python benchmarks/paper_tables.py write'}
"""Pages that a command writes from top to bottom, and that say which one."""


def tables(text):
    """Yield the rows of each table that no command writes, as lists of cells."""
    for pattern in (_WRITTEN, _CODE, _VALUE):
        text = pattern.sub('', text)
    for table in _TABLE.findall(text):
        yield [[cell.strip() for cell in line[1:-1].split('|')] for line in table.splitlines()]


def figures(rows):
    """Return the cells of a table that are figures; the first of a row is its name."""
    cells = (cell.strip('* ') for row in rows[2:] for cell in row[1:])
    return [cell for cell in cells if _FIGURE.match(cell) and not _PROSE.search(cell)]


def by_hand(page):
    """Return the first titles of a page's tables with figures, and one figure of each."""
    found = {rows[0][0]: figures(rows) for rows in tables(page.read_text(encoding='utf-8'))}
    return {title: cells[0] for title, cells in found.items() if cells}


def test_no_table_of_figures_is_written_by_hand():
    found = {
        (page.name, title): figure
        for page in pages(ROOT)
        if page.name not in WRITTEN_WHOLE
        for title, figure in by_hand(page).items()
        if not any(page.name == name and word in title for name, word in BY_HAND)
    }
    assert found == {}, 'give it a maker: docs/benchmarks.md, Another benchmark'


@pytest.mark.parametrize(('name', 'word'), BY_HAND)
def test_what_may_be_written_by_hand_is_there(name, word):
    assert any(word in title for title in by_hand(ROOT / 'docs' / name))


@pytest.mark.parametrize('name', WRITTEN_WHOLE)
def test_pages_that_a_command_writes_whole_say_so(name):
    top = (ROOT / 'docs' / name).read_text(encoding='utf-8').partition('\n## ')[0]
    assert f'Written by `{WRITTEN_WHOLE[name]}`' in top


@pytest.mark.parametrize(
    'cell', ['12', '0.05 m', '95 %', '3 of 20', '-0.3 deg', '1.6 GB', '**2**']
)
def test_a_measured_cell_is_noticed_and_between_markers_it_is_not(cell):
    table = f'| what | now |\n|---|---|\n| tick | {cell} |\n'
    (rows,) = tables(f'Above.\n\n{table}\nBelow.\n')
    assert figures(rows) == [cell.strip('*')]
    assert list(tables(f'<!-- figures: x -->\n{table}\n<!-- end -->\n')) == []
    (rows,) = tables(f'| what | now |\n|---|---|\n| tick | <!-- f:x -->{cell}<!-- / --> |\n')
    assert figures(rows) == []


@pytest.mark.parametrize('cell', ['none', '`0.5`', '42 generated buildings', 'needs 2 more', ''])
def test_words_are_no_figures(cell):
    assert figures([['what', 'now'], ['---', '---'], ['tick', cell]]) == []
