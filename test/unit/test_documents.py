# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pages that list what the repository holds list all of it, and links lead somewhere."""

from importlib.metadata import PackageNotFoundError, metadata
from importlib.util import module_from_spec, spec_from_file_location
from itertools import pairwise
from pathlib import Path
import re

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
RUN_TIME = ('requirements.txt', 'requirements-core.txt', 'requirements-jazzy.txt')
NOTICES = dict(
    re.findall(
        r'^\| ([a-z0-9-]+) \| ([^|]+) \|',
        (ROOT / 'docs' / 'third_party.md').read_text(encoding='utf-8'),
        re.MULTILINE,
    )
)


def required():
    """Return the versions that are pinned of each requirement, with and without ROS 2's."""
    found = {}
    for name in RUN_TIME:
        for line in (ROOT / name).read_text(encoding='utf-8').splitlines():
            if pin := re.match(r'([A-Za-z0-9][\w.-]*)(?:\[\w+\])?==(\S+)', line):
                found.setdefault(pin[1].lower(), set()).add(pin[2])
    return found


def test_the_notices_name_every_requirement():
    assert set(NOTICES) - {'package'} == set(required())


@pytest.mark.parametrize('name', sorted(set(required())))
def test_the_notices_agree_with_the_installed_packages(name):
    try:
        facts = metadata(name)
    except PackageNotFoundError:
        pytest.skip('not installed: the other kind of ROS 2')
    if facts['Version'].partition('+')[0] not in required()[name]:
        pytest.skip('the notices are of the version that is pinned')
    stated = ' '.join(
        [
            facts.get('License-Expression') or '',
            (facts.get('License') or '')[:200],
            *(c for c in facts.get_all('Classifier') or [] if 'License' in c),
        ]
    )
    if not stated.strip():
        pytest.skip('the package does not state its licence')
    named = NOTICES[name].replace('PSF', 'Python').replace('Mulan', 'Mulan ')
    assert re.split(r'[-\s]', named)[0] in stated, f'{name} states {stated}'


def test_the_benchmarks_page_names_every_benchmark():
    page = (ROOT / 'docs' / 'benchmarks.md').read_text(encoding='utf-8')
    scripts = {path.name for path in (ROOT / 'benchmarks').glob('*.py')}
    assert {name for name in scripts if name not in page} == set()
    source = (ROOT / 'fpnet_lab' / 'cli' / 'bench.py').read_text(encoding='utf-8')
    subcommands = re.findall(r"app\.command\('([a-z-]+)'", source)
    assert len(subcommands) >= 5
    assert {name for name in subcommands if f'fpnet bench {name}' not in page} == set()


def test_every_page_is_in_the_navigation():
    text = (ROOT / 'mkdocs.yml').read_text(encoding='utf-8')
    nav = re.findall(r': ([a-z0-9_]+\.md)$', text, re.MULTILINE)
    assert sorted(nav) == sorted(path.name for path in (ROOT / 'docs').glob('*.md'))


def _word_pairs(text):
    words = re.findall(r"[a-z']+", text.lower())
    return list(pairwise(words))


@pytest.mark.parametrize(
    ('name', 'least'), [('docs/troubleshooting.md', 8), ('notes/doctor.md', 5)]
)
def test_what_pages_of_symptoms_quote_is_what_is_said(name, least):
    """Most pairs of words are: between the others a message is filled in."""
    page = (ROOT / name).read_text(encoding='utf-8')
    folders = (ROOT / name for name in ('fpnet', 'fpnet_core', 'fpnet_ros'))
    files = [path for folder in folders for path in folder.rglob('*.py')]
    literals = '\n'.join(path.read_text(encoding='utf-8') for path in files)
    said = set(_word_pairs(re.sub(r"""['"]\s*\n\s*f?['"]|\{[^{}\n]*\}""", '', literals)))
    quotes = {
        quote
        for row in re.findall(r'^\| (.*?) \|', page, re.MULTILINE)
        for quote in re.findall(r'`([^`]+)`', row)
        if quote.count(' ') >= 2 and quote[0].isalpha()
    }
    assert len(quotes) >= least
    shares = {q: np.mean([pair in said for pair in _word_pairs(q)]) for q in quotes}
    assert {quote: share for quote, share in shares.items() if share < 0.5} == {}


def test_the_readmes_demo_is_the_first_row_of_the_demos():
    readme = (ROOT / 'README.md').read_text(encoding='utf-8')
    [said] = re.findall(r'^seed 0: (.*); see out/demo', readme, re.MULTILINE)
    page = (ROOT / 'docs' / 'benchmarks.md').read_text(encoding='utf-8')
    [row] = re.findall(r'^\| 0 \| (.*) \|$', page.partition('figures: demo')[2], re.MULTILINE)[:1]
    poses, wrong, first_s, first_m, error_m, error_deg, *_ = map(float, row.split(' | '))
    stated = [float(number) for number in re.findall(r'[\d.]+', said)]
    assert stated[0] == poses
    assert stated[3] == wrong
    assert stated[1:3] == pytest.approx([first_s, first_m], abs=0.0501)
    assert stated[4:] == pytest.approx([error_m, error_deg], abs=0.0501)


def test_the_readme_states_the_papers_tables_as_their_page_does():
    page = (ROOT / 'docs' / 'matching_tables.md').read_text(encoding='utf-8')
    rows = [
        [cell.strip() for cell in line[1:-1].split('|')]
        for line in page.splitlines()
        if re.match(r'\| (fpnet|paper) \|', line)
    ]
    own, paper = ([row for row in rows if row[0] == name][:3] for name in ('fpnet', 'paper'))
    auc, ts = 1, 5  # columns
    stated = [re.fullmatch(r'([\d.]+) \(([\d.]+)\)', row[ts]).groups() for row in paper]
    auc_stated = [re.search(r'\(([\d.]+)\)', row[auc])[1] for row in paper]
    shown = (
        [f'{float(row[ts]):.0f}' for row in own], [theirs for _, theirs in stated],
        [f'{float(ours):.0f}' for ours, _ in stated], [row[auc] for row in own], auc_stated,
    )  # fmt: skip
    readme = (ROOT / 'README.md').read_text(encoding='utf-8')
    for first, second, third in shown:
        assert f'{first}, {second} and {third}' in readme


def test_the_overview_links_every_page():
    overview = (ROOT / 'docs' / 'index.md').read_text(encoding='utf-8')
    names = {path.name for path in (ROOT / 'docs').glob('*.md')} - {'index.md'}
    assert {name for name in names if f']({name}' not in overview} == set()


ELSEWHERE = {'architecture.svg', 'reliability.png', 'growth.png'}
"""Drawn by hand, or a benchmark's of an hour; tour_*.png are the notebook's."""


def test_every_picture_has_the_commands_that_make_it_and_a_page_that_shows_it():
    pictures = {path.name for path in (ROOT / 'docs' / 'images').iterdir()}
    made = {name for name in pictures - ELSEWHERE if not name.startswith('tour_')}
    spec = spec_from_file_location('pictures', ROOT / 'tools' / 'pictures.py')
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    recipes = module.recipes()
    assert set(recipes) == made
    assert {name for name, commands in recipes.items() if 'fpnet' not in commands} <= {
        'segmentation.png',
        'submaps.png',
    }
    pages = [ROOT / 'README.md', *(ROOT / 'docs').glob('*.md'), *(ROOT / 'notes').glob('*.md')]
    shown = '\n'.join(p.read_text(encoding='utf-8') for p in pages if p.name != 'images.md')
    assert {name for name in pictures if f'images/{name})' not in shown} == set()


@pytest.mark.parametrize('name', ['README.md', 'CHANGELOG.md'])
def test_relative_links_lead_to_files(name):
    text = re.sub(r'```.*?```', '', (ROOT / name).read_text(encoding='utf-8'), flags=re.DOTALL)
    links = [link for link in re.findall(r'\]\(([^)#\s]+)', text) if '://' not in link]
    assert [link for link in links if not (ROOT / link).exists()] == []
