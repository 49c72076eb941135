# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names that others gave reach a terminal without control characters."""

import logging

import pytest

from fpnet.cli import common, main
from fpnet_core.printable import printable

EVIL = '/scan\x1b]0;owned\x07\x1b[2K\b\u202e'
WRITTEN = '/scan\\x1b]0;owned\\x07\\x1b[2K\\x08\\u202e'


@pytest.mark.parametrize(
    ('text', 'written'),
    [('/points', '/points'), ('Büro 3,5 m²\n  next', 'Büro 3,5 m²\n  next'), (EVIL, WRITTEN)],
)
def test_control_characters_are_written_out(text, written):
    assert printable(text) == written


def test_so_they_are_in_lines_and_tables(capsys):
    common.say(EVIL, None)
    common.show_table(['topic', 'n'], [(EVIL, '3')], None, width=120)
    said = capsys.readouterr().out
    assert said.count(WRITTEN) == 2
    assert '\x1b' not in said


def test_so_they_are_in_errors(capsys):
    with pytest.raises(SystemExit):
        main(['doctor', EVIL])
    said = capsys.readouterr().err
    assert WRITTEN in said
    assert '\x1b' not in said


def test_so_they_are_in_the_log(capsys, monkeypatch):
    root = logging.getLogger()
    monkeypatch.setattr(root, 'handlers', [])
    with pytest.raises(SystemExit):
        main(['doctor', 'missing.bag'])
    logging.getLogger('fpnet_core.test').warning('left out: %s', EVIL)
    assert WRITTEN in capsys.readouterr().err
