# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every module constant that is a number says what it is: see ``tools/constants.py``."""

from functools import cache
from pathlib import Path
import re
import runpy

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOL = runpy.run_path(str(ROOT / 'tools' / 'constants.py'))

PAGE = re.compile(r'(?:docs|notes)/\w+\.md')
COMMAND = re.compile(r'`(?:python |fpnet |benchmarks/)')


@cache
def every():
    """All constants of all packages."""
    return [constant for package in TOOL['PACKAGES'] for constant in TOOL['constants'](package)]


def listed(constants):
    return [f'{c.path}:{c.line} {c.name}  {c.text}' for c in constants]


def kinds(tmp_path, source):
    module = tmp_path / 'module.py'
    module.write_text(source)
    found = TOOL['module_constants'](module, tmp_path)
    return {constant.name: constant.kind for constant in found}


def test_every_number_says_what_it_is():
    unsaid = [constant for constant in every() if constant.kind == TOOL['UNSAID']]
    assert not unsaid, '\n'.join(listed(unsaid))


def test_what_is_fitted_names_the_page_or_command_that_tells_how():
    fitted = [constant for constant in every() if constant.kind == 'fitted']
    nameless = [c for c in fitted if not (COMMAND.search(c.text) or PAGE.search(c.text))]
    assert not nameless, '\n'.join(listed(nameless))


def test_what_is_physical_says_of_what():
    bare = [c for c in every() if c.kind == 'physical' and len(c.text.split()) < 3]
    assert not bare, '\n'.join(listed(bare))


def test_pages_that_constants_name_exist():
    named = [(constant, page) for constant in every() for page in PAGE.findall(constant.text)]
    assert len(named) > 10
    for constant, page in named:
        assert (ROOT / page).is_file(), f'{constant.path}:{constant.line} {page}'


def test_all_four_packages_are_read():
    assert {constant.path.parts[0] for constant in every()} == set(TOOL['PACKAGES'])


@pytest.mark.parametrize(
    ('source', 'expected'),
    [
        ('A = 1\n', {'A': 'unsaid'}),
        ('A = 1  # of walls; chosen\n', {'A': 'chosen'}),
        ('A = 1  # when neighbours are chosen\n', {'A': 'unsaid'}),
        ('A = (1, -2.5)  # numerical\n', {'A': 'numerical'}),
        ('A = 1\n"""Physical: a door."""\n', {'A': 'physical'}),
        ('A = 1\nB = 2\n"""Doors. Chosen."""\n', {'A': 'chosen', 'B': 'chosen'}),
        ('A = 1  # of rooms\nB = 2\n"""Doors. Chosen."""\n', {'A': 'unsaid', 'B': 'chosen'}),
        ('# Chosen:\nA = 1\nB = 2  # given: tag\n', {'A': 'chosen', 'B': 'given'}),
        ('# Chosen to span\n# all:\n# Rooms.\nA = 1\n', {'A': 'chosen'}),
        ('# Chosen:\nA = 1\n\nB = 2\n', {'A': 'chosen', 'B': 'unsaid'}),
        ("A, B = 'x', 2  # fmt: skip  # given\n", {'B': 'given'}),
        ("A = {1: 'x'}\nB = slice(0, 2)\nC = True\nD = np.zeros(3)\nE = 'x'\n", {}),
        ('A = np.radians(3.0)\nB = f(width=2)\n', {'A': 'unsaid', 'B': 'unsaid'}),
    ],
)
def test_kinds_are_read_from_comments_docstrings_and_headings(tmp_path, source, expected):
    assert kinds(tmp_path, source) == expected
