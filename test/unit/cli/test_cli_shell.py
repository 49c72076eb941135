# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The shell around the subcommands: lazy loading, exit codes, options, output."""

import logging
import re
import subprocess
import sys
import time

import pytest

from fpnet import cli
from fpnet.cli import COMMANDS, Subcommand, common, installed_commands, main
from fpnet.cli.progress import progress, track
from fpnet_core.errors import ConfigError, FpnetError


def run(*arguments):
    """Call the command line in this process; returns its exit status."""
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    return stop.value.code or 0


@pytest.fixture
def subcommand(monkeypatch):
    """Plug in a subcommand for the duration of a test; returns a function to do so."""

    def plug(function, name='fpnet.cli.plugged'):
        module = type(sys)(name)
        module.command = function
        monkeypatch.setitem(sys.modules, name, module)
        monkeypatch.setitem(COMMANDS, 'plugged', Subcommand(name, 'Only in this test.'))

    return plug


def test_help_names_every_subcommand(capsys):
    assert run('--help') == 0
    text = capsys.readouterr().out
    for name, entry in installed_commands().items():
        assert re.search(rf'\b{name}\b', text)
        assert entry.summary.split()[0] in text


def test_help_loads_no_subcommand_and_nothing_heavy():
    heavy = ('cv2', 'matplotlib', 'numba', 'numpy', 'open3d', 'pydantic', 'scipy', 'torch')
    code = (
        'import sys\n'
        'from fpnet.cli import main\n'
        'try: main(["--help"])\n'
        'except SystemExit: pass\n'
        'print([m for m in sys.modules if m.startswith(("fpnet.cli.", "fpnet_lab.cli."))'
        f' or m in {heavy}], file=sys.stderr)'
    )
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True
    )
    assert result.stderr.splitlines() == ['[]']


@pytest.mark.parametrize(
    'arguments', [('nonsense',), ('segment',), ('segment', '--resolution', 'x')]
)
def test_wrong_usage_exits_2(capsys, arguments):
    assert run(*arguments) == 2
    assert 'Usage: fpnet' in capsys.readouterr().err


def test_known_errors_are_one_line_and_exit_1(capsys, subcommand):
    def fail():
        raise FpnetError('the map is\n   upside down')

    subcommand(fail)
    assert run('plugged') == 1
    assert capsys.readouterr().err == 'fpnet: the map is upside down\n'


def test_unwritable_output_is_one_line(capsys, subcommand, tmp_path):
    (tmp_path / 'file').write_text('')
    subcommand(lambda: common.write_json(tmp_path / 'file' / 'out.json', {}))
    assert run('plugged') == 1
    assert capsys.readouterr().err.startswith(f'fpnet: {tmp_path}')


def test_programming_errors_are_not_hidden(subcommand):
    def fail():
        raise KeyError('a defect')

    subcommand(fail)
    with pytest.raises(KeyError):
        main(['plugged'])


@pytest.mark.parametrize('words', [('-v', 'plugged'), ('plugged', '-v'), ('plugged', '--verbose')])
def test_details_are_logged_wherever_the_flag_stands(subcommand, monkeypatch, words):
    levels = []
    monkeypatch.setattr(logging, 'basicConfig', lambda **options: levels.append(options['level']))
    subcommand(lambda: None)
    assert run(*words) == 0
    assert run('plugged') == 0
    assert levels == [logging.INFO, logging.WARNING]


def test_interrupt_exits_130_without_a_traceback(capsys, subcommand):
    def interrupted():
        raise KeyboardInterrupt

    subcommand(interrupted)
    assert run('plugged') == 130
    assert 'Traceback' not in capsys.readouterr().err


def test_an_interrupt_that_a_library_swallows_comes_again(capsys, subcommand):
    class Lost:
        def __del__(self):
            raise KeyboardInterrupt

    def interrupted():
        lost = Lost()
        del lost
        time.sleep(5.0)
        pytest.fail('it went on')

    subcommand(interrupted)
    assert run('plugged') == 130
    assert capsys.readouterr().err.strip() in ('', 'Aborted!')


def test_common_options_reach_the_configuration(subcommand, tmp_path):
    seen = []

    def command(
        config: common.ConfigOption = None,
        settings: common.SetOption = None,
        seed: common.SeedOption = None,
    ):
        seen.append(common.load(config, settings, seed))

    subcommand(command)
    (tmp_path / 'fpnet.yaml').write_text('seed: 3\nsubmap: {resolution_m: 0.1, max_range_m: 9}\n')
    arguments = ['--config', str(tmp_path / 'fpnet.yaml'), '--set', 'submap.max_range_m=7.5']
    assert run('plugged', *arguments) == 0
    assert run('plugged', *arguments, '--seed', '5') == 0
    assert (seen[0].seed, seen[1].seed) == (3, 5)
    assert (seen[0].submap.resolution_m, seen[0].submap.max_range_m) == (0.1, 7.5)


@pytest.mark.parametrize('setting', ['submap', '=1', 'a..b=1', '.a=1', 'a=[', ''])
def test_malformed_settings_are_named(setting):
    with pytest.raises(ConfigError, match='--set'):
        common.parse_settings([setting])


def test_settings_are_typed():
    parsed = common.parse_settings(['a.b=1', 'a.c=0.5', 'a.d=true', 'a.e=text', 'a.f=x=y'])
    assert parsed == {'a.b': 1, 'a.c': 0.5, 'a.d': True, 'a.e': 'text', 'a.f': 'x=y'}


def test_progress_is_silent_without_a_terminal(capfd):
    with progress('working', total=3) as advance:
        advance(1.0)
    assert list(track([1, 2, 3], 'counting')) == [1, 2, 3]
    assert capfd.readouterr() == ('', '')


def test_status_is_a_line_a_second_without_a_terminal(capfd, monkeypatch):
    now = iter([0.0, 0.4, 1.2, 1.2, 1.9, 2.3, 2.3])
    monkeypatch.setattr(time, 'monotonic', lambda: next(now))
    with progress('localizing') as advance:
        for update in ('first', 'second', 'third', 'fourth'):
            advance.status('short', update)
    assert capfd.readouterr() == ('', 'second\nfourth\n')


def test_version(monkeypatch, capsys):
    monkeypatch.setattr('importlib.metadata.version', lambda name: '9.8.7')
    assert run('--version') == 0
    assert capsys.readouterr().out == 'fpnet 9.8.7\n'


def test_runs_as_a_module():
    started = time.monotonic()
    command = [sys.executable, '-m', 'fpnet', 'segment', 'nowhere.png']
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert result.stderr == 'fpnet: nowhere.png does not exist; give an existing file or folder\n'
    assert time.monotonic() - started < 20.0
    assert cli.__doc__ is not None
