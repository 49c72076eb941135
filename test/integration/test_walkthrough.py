# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The tutorial, word for word: every command with its own input gives what the page promises."""

import importlib.util
from pathlib import Path
import sys

import pytest

ROOT = Path(__file__).resolve().parents[2]
_spec = importlib.util.spec_from_file_location('walkthrough', ROOT / 'tools' / 'walkthrough.py')
walkthrough = importlib.util.module_from_spec(_spec)
sys.modules['walkthrough'] = walkthrough
_spec.loader.exec_module(walkthrough)

TUTORIAL = walkthrough.steps((ROOT / 'docs' / 'tutorial.md').read_text(encoding='utf-8'))
PROMISE = 'localized (p 1.00): explains 78 % of 508 m of observed wall in 316 ms'


@pytest.mark.parametrize(
    ('printed', 'is_kept'),
    [
        (PROMISE, True),
        ('localized (p 0.99): explains 74 % of 530 m of observed wall in 2 ms', True),
        ('searching (p 0.25): explains 78 % of 508 m of observed wall in 316 ms', False),
        ('localized (p 0.25): explains 78 % of 508 m of observed wall in 316 ms', False),
        ('localized (p 1.00): explains 78 % of 208 m of observed wall in 316 ms', False),
    ],
)
def test_outputs_are_compared_by_words_and_figures(printed, is_kept):
    assert (walkthrough.missing((PROMISE,), ['first', printed]) == []) is is_kept


@pytest.mark.parametrize(
    ('first', 'second', 'is_near'),
    [
        ('0.001410', '0.000600', True),
        ('0.110708', '0.130000', True),
        ('0.110708', '0.140000', False),
    ],
)
def test_a_few_millimetres_make_no_difference(first, second, is_near):
    assert walkthrough.near(first, second) is is_near


def test_a_line_that_the_page_does_not_have_is_noticed():
    step = walkthrough.Step('fpnet localize drive', (PROMISE,))
    more = 'the drawing is out of date here'
    assert walkthrough.unsaid(step, ['', PROMISE, more]) == [more]


def test_a_step_that_fails_or_writes_nothing_is_noticed(tmp_path):
    plain = walkthrough.Step('false --out missing', ('promised line',))
    exit_status, not_written, promised = walkthrough.follow(plain, tmp_path)
    assert exit_status.startswith('exit status 1')
    assert not_written == 'missing was not written'
    assert promised == 'promised: promised line'


def test_the_tutorials_steps_are_found_with_their_promises():
    names = [step.words[:2] for step in TUTORIAL]
    assert names[:4] == [
        ['fpnet', 'simulate'], ['fpnet', 'segment'], ['fpnet', 'check-plan'], ['fpnet', 'localize']
    ]  # fmt: skip
    assert all(step.promised for step in TUTORIAL)


@pytest.mark.slow
@pytest.mark.apart
def test_the_tutorial_gives_what_it_promises(tmp_path):
    here = [step for step in TUTORIAL if step.program is not None]
    assert len(here) >= 4
    found = {step.command: walkthrough.follow(step, tmp_path) for step in here}
    assert {command: wrong for command, wrong in found.items() if wrong} == {}
