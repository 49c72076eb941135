# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One command line: options that mean the same everywhere, completion, documented commands."""

from functools import cache
import inspect
import os
from pathlib import Path
import re
import shlex
import subprocess
import sys
from typing import Annotated, Literal, get_args, get_origin, get_type_hints

import pytest
import typer

from fpnet.cli import build_app, common, installed_commands

ROOT = Path(__file__).resolve().parents[3]
SHARED = {
    '--config': common.ConfigOption,
    '--seed': common.SeedOption,
    '--device': common.DeviceOption,
    '--json': common.JsonOption,
}
DOCUMENTS = (
    'README.md', 'docs/cli.md', 'docs/reports.md', 'docs/simulator.md', 'docs/floorplans.md',
    'docs/formats.md',
)  # fmt: skip


@cache
def command_tree():
    """Every command by its words, as ('simulate', 'plan')."""
    found = {}

    def walk(words, command):
        children = getattr(command, 'commands', None)
        if children is None:
            found[words] = command
        for name, child in (children or {}).items():
            walk((*words, name), child)

    for name in installed_commands():
        root = typer.main.get_command(build_app(name))
        walk((name,), root.commands[name])
    return found


def options(command):
    return {name: p for p in command.params for name in (*p.opts, *p.secondary_opts)}


@pytest.mark.parametrize('name', SHARED)
def test_shared_options_are_the_same_everywhere(name):
    expected = SHARED[name].__metadata__[0]
    users = {words: options(c)[name] for words, c in command_tree().items() if name in options(c)}
    assert users
    for words, option in users.items():
        assert (option.help, option.metavar) == (expected.help, expected.metavar), words


def test_settings_are_keys_and_values_and_outputs_are_places():
    """Some commands say what their folder holds, and pictures are files, not folders."""
    for words, command in command_tree().items():
        known = options(command)
        if '--set' in known and words != ('bench', 'matching'):  # there it names a set of pairs
            assert known['--set'].metavar == 'KEY=VALUE', words
        if '--out' in known:
            assert known['--out'].metavar in ('DIR', 'FILE'), words


def test_options_of_words_are_those_that_older_typer_takes():
    """Typer reads a Literal by itself from 0.19 on; a robot's may be older."""
    seen = 0
    for words, command in command_tree().items():
        hints = get_type_hints(inspect.unwrap(command.callback), include_extras=True)
        for hint in hints.values():
            kind, *told = get_args(hint) if get_origin(hint) is Annotated else (hint,)
            if any(get_origin(each) is Literal for each in (kind, *get_args(kind))):
                seen += 1
                assert told, words
                assert told[0].parser is not None, (words, told[0].param_decls)
    assert seen >= 5


@pytest.mark.parametrize('word', ['kiss', 'both'])
def test_an_option_of_words_takes_them_and_no_others(word):
    option = common.choice('--odometry', Literal['kiss', 'both'], 'Which.')
    assert option.parser(word) == word
    assert option.metavar == '[kiss|both]'
    assert option.autocompletion('b') == ['both']
    with pytest.raises(typer.BadParameter, match="'wheels' is not one of kiss, both"):
        option.parser('wheels')


def test_every_command_shows_an_example():
    for words, command in command_tree().items():
        assert f'Example: fpnet {" ".join(words)}' in ' '.join(command.help.split()), words


def documented():
    """Commands in fenced blocks of the documents, with what comes after a comment cut off."""
    for name in DOCUMENTS:
        text = (ROOT / name).read_text(encoding='utf-8')
        for block in re.findall(r'```(?:bash)?\n(.*?)```', text, re.DOTALL):
            for line in block.replace('\\\n', ' ').splitlines():
                if line.startswith('fpnet '):
                    yield name, shlex.split(line, comments=True)[1:]


@pytest.mark.parametrize(('document', 'words'), list(documented()))
def test_documented_commands_exist(document, words):
    bare = [word for word in words if not word.startswith('-')]
    if not bare:  # fpnet --help
        return
    for name in bare[0].split('|'):
        assert name in installed_commands()
    first, second, third = (word.split('|') for word in (*bare, '', '')[:3])
    paths = [(a, b, c) for a in first for b in second for c in third]
    paths = [path[:length] for path in paths for length in (1, 2, 3)]
    chosen = [path for path in paths if path in command_tree()]
    assert chosen, f'{document}: no command {" ".join(bare[:2])}'
    for path in chosen:
        known = options(command_tree()[path])
        for word in words:
            if word.startswith('--') and word != '--help':
                assert word.split('=')[0] in known, f'{document}: {" ".join(words)}'


@pytest.mark.parametrize(
    ('shell', 'typed', 'expected'),
    [
        ('bash', 'fpnet loc', 'localize'),
        ('bash', 'fpnet localize --floor', '--floorplan'),
        ('zsh', 'fpnet check-plan --tou', '--tours'),
        ('fish', 'fpnet simulate rec', 'recording'),
        ('bash', 'fpnet simulate recording --sensor beams1', 'beams16'),
        ('zsh', 'fpnet simulate recording --building li', 'lived_in'),
        ('bash', 'fpnet simulate plan --style sk', 'sketch'),
        ('bash', 'fpnet localize --set localizer.accept', 'localizer.accept_probability='),
        ('fish', 'fpnet demo --sensor pl', 'planar'),
    ],
)
def test_shells_complete_subcommands_their_options_and_values(shell, typed, expected):
    environment = {
        **os.environ,
        '_FPNET_COMPLETE': f'complete_{shell}',
        'COMP_WORDS': typed if shell == 'bash' else '',
        'COMP_CWORD': str(len(typed.split()) - 1),
        '_TYPER_COMPLETE_ARGS': typed,
        '_TYPER_COMPLETE_FISH_ACTION': 'get-args',
    }
    code = 'from fpnet.cli import main; main()'
    result = subprocess.run(
        [sys.executable, '-c', code], env=environment, capture_output=True, text=True, check=False
    )
    assert expected in result.stdout
    assert result.stderr == ''
