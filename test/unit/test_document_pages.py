# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pages that list what the repository holds list all of it."""

from importlib.metadata import PackageNotFoundError, metadata
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
    for name in RUN_TIME:
        for line in (ROOT / name).read_text(encoding='utf-8').splitlines():
            if found := re.match(r'[A-Za-z0-9][A-Za-z0-9_.-]*', line):
                yield found[0].lower()


def test_the_notices_name_every_requirement():
    assert set(NOTICES) - {'package'} == set(required())


@pytest.mark.parametrize('name', sorted(set(required())))
def test_the_notices_agree_with_the_installed_packages(name):
    try:
        facts = metadata(name)
    except PackageNotFoundError:
        pytest.skip('not installed: the other kind of ROS 2')
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


def test_what_the_page_of_symptoms_quotes_is_what_is_said():
    """Most pairs of words are: between the others a message is filled in."""
    page = (ROOT / 'docs' / 'troubleshooting.md').read_text(encoding='utf-8')
    files = [*(ROOT / 'fpnet_core').rglob('*.py'), *(ROOT / 'fpnet_ros').rglob('*.py')]
    literals = '\n'.join(path.read_text(encoding='utf-8') for path in files)
    said = set(_word_pairs(re.sub(r"""['"]\s*\n\s*f?['"]""", '', literals)))
    quotes = {
        quote
        for row in re.findall(r'^\| (.*?) \|', page, re.MULTILINE)
        for quote in re.findall(r'`([^`]+)`', row)
        if quote.count(' ') >= 2 and quote[0].isalpha()
    }
    assert len(quotes) >= 8
    shares = {q: np.mean([pair in said for pair in _word_pairs(q)]) for q in quotes}
    assert {quote: share for quote, share in shares.items() if share < 0.5} == {}
