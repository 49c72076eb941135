# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the pages of this checkout state between markers: of one run, and the same everywhere."""

from pathlib import Path

from benchmark_reports import MADE, REPORTS, manifest, rows
import numpy as np
import pytest
from stated_figures import contradictions

from fpnet_lab.evaluation.published.figures import pages, stated
from fpnet_lab.evaluation.published.makers import MAKERS, published
from fpnet_lab.evaluation.published.weights import WEIGHTS

ROOT = Path(__file__).resolve().parents[4]


def on_pages():
    """What all pages state, by name; they agree, as another test has it."""
    return {each.name: each.text for page in pages(ROOT) for each in stated(page)}


MEASURED_APART = {
    'sites.differences': 'sites.differences',
    'sites.one': 'sites.one',
    'sites.library': 'sites.library',
    'sites.growth': 'sites.library',
}
"""Parts of a benchmark that have nothing in common but its name."""
"""Parts of a benchmark that have nothing in common but its name."""


def test_pages_agree_on_every_figure():
    on_pages = [each for page in pages(ROOT) for each in stated(page)]
    assert contradictions(on_pages) == []
    assert len({each.page for each in on_pages}) >= 3


def test_every_figure_on_a_page_is_one_that_a_benchmark_gives():
    known = {'constants', 'house'}  # counted by tools
    for name in MAKERS:
        known |= set(published(name, REPORTS[name](), MADE))
    named = {each.name for page in pages(ROOT) for each in stated(page)}
    assert named <= known


def test_every_table_on_a_page_says_what_made_it():
    tables = [each for page in pages(ROOT) for each in stated(page) if '\n' in each.text]
    for each in tables:
        assert each.text.startswith('`'), f'{each.page.name}: {each.name}'
        assert 'commit ' in each.text.partition('\n')[0], f'{each.page.name}: {each.name}'
    assert len(tables) >= 4


def test_tables_of_one_benchmark_are_of_one_run():
    """Their first lines have the command, the day and the commit."""
    made = {}
    for name, text in on_pages().items():
        if '\n' in text:
            run = MEASURED_APART.get(name, name.partition('.')[0])
            made.setdefault(run, set()).add(text.partition('\n')[0])
    assert {name: lines for name, lines in made.items() if len(lines) > 1} == {}


def test_every_figure_in_a_sentence_has_its_table_on_a_page():
    """The table says where the figure is from; scales of vector drawings are one row each."""
    names = on_pages()
    tables = {name.partition('.')[0] for name, text in names.items() if '\n' in text}
    sentences = {name.partition('.')[0] for name, text in names.items() if '\n' not in text}
    assert sentences - tables <= {'drawings_pdf', 'drawings_svg', 'drawings_dxf'}


def test_figures_in_sentences_are_those_of_the_tables():
    figures = on_pages()
    table = {row[0]: row for row in rows(figures['localization'])}
    assert figures['localization.right'] == table['all'][2]
    assert figures['localization.first_pose'] == table['all'][3]
    claims = [row for name, row in table.items() if name.startswith('on ')]
    assert len(claims) == 2
    false = sum(int(row[4].split()[0]) for row in claims)
    assert figures['localization.false_claims'] == str(false)
    *maps, whole, half, third, tenth = rows(figures['robot'])[-8:]
    names = ('whole', 'half', 'third', 'tenth')
    assert [figures[f'robot.right_{name}'] for name in names] == [row[2] for row in maps]
    undistorted = [row[2] for row in (whole, half, third, tenth)]
    assert [figures[f'robot.undistorted_{name}'] for name in names] == undistorted
    for column, wrong, cases in ((4, 'wrong', 'pairs'), (5, 'foreign', 'foreign_pairs')):
        counts = np.array([row[column].split(' of ') for row in maps], dtype=int).sum(axis=0)
        assert figures[f'robot.{wrong}'] == str(counts[0])
        assert figures[f'robot.{cases}'].replace(',', '') == str(counts[1])
    seeds = rows(figures['demo'])[2:]
    assert figures['demo.met'].endswith(f'of {len(seeds)}')
    assert figures['demo.wrong'] == str(sum(int(row[2]) for row in seeds))
    assert figures['demo.latest'] == f'{max(float(row[4]) for row in seeds):.1f} m'


def test_the_readme_says_on_how_many_foreign_plans_it_was_tried():
    table = {row[0]: row for row in rows(on_pages()['localization'])}
    foreign = sum(int(row[1]) for name, row in table.items() if name.startswith('on '))
    assert f' of {foreign} drives' in (ROOT / 'README.md').read_text(encoding='utf-8')


@pytest.mark.parametrize('name', WEIGHTS)
def test_pages_state_what_manifests_of_shipped_weights_hold(name):
    """Whatever was trained anew, and when: nobody can forget the page."""
    states = on_pages()
    expected = published(name, manifest(name), MADE)
    shown = {key: text for key, text in expected.items() if key in states}
    assert name in shown
    for key, text in shown.items():
        assert rows(states[key]) == rows(text), key
        assert states[key].startswith('`fpnet train ')
