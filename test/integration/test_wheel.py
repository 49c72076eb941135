# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The wheel in an environment of its own: the command, the weights and the page templates."""

from email import message_from_bytes
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig
import zipfile

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = (
    *('fpnet', 'fpnet_core', 'fpnet_lab', 'fpnet_ros', 'msg_adapters'),
    *('config', 'launch', 'resource'),
    *('setup.py', 'setup.cfg', 'pyproject.toml', 'package.xml', 'LICENSE', 'README.md'),
)
PIP = (sys.executable, '-m', 'pip', '--disable-pip-version-check', '--no-input', '-q')
LOOK = """
from importlib.resources import files
import fpnet_core
from fpnet_core.config import load_config
from fpnet_core.io.weights import read_weights
from fpnet_core.types import FEATURE_SCHEMA
print(fpnet_core.__file__)
print(len(read_weights(None, FEATURE_SCHEMA).tensors))
print(*(p.name for p in (files('fpnet.report') / 'templates').iterdir()))
"""

PACKAGES = ('fpnet', 'fpnet_core', 'fpnet_lab', 'fpnet_ros', 'msg_adapters')
MAX_BYTES = 10_000_000

pytestmark = [pytest.mark.slow, pytest.mark.apart]


def run(*words, cwd):
    result = subprocess.run(
        list(map(str, words)), capture_output=True, text=True, check=False, cwd=cwd
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope='module')
def wheel(tmp_path_factory):
    """The wheel, built from what a checkout has of it."""
    folder = tmp_path_factory.mktemp('wheel')
    sources = folder / 'sources'
    sources.mkdir()
    skip = shutil.ignore_patterns('__pycache__', '*.egg-info')
    for name in SOURCES:
        path = ROOT / name
        if path.is_dir():
            shutil.copytree(path, sources / name, ignore=skip)
        else:
            shutil.copy(path, sources)
    options = ('--no-deps', '--no-build-isolation', '--no-index')
    run(*PIP, 'wheel', *options, '-w', folder, sources, cwd=folder)
    [wheel] = folder.glob('*.whl')
    return wheel


@pytest.fixture(scope='module')
def installed(wheel):
    """The wheel in an empty environment that borrows the libraries of this one."""
    folder = wheel.parent
    home = folder / 'environment'
    run(sys.executable, '-m', 'venv', '--without-pip', home, cwd=folder)
    python = home / 'bin' / 'python'
    run(*PIP, '--python', python, 'install', '--no-deps', '--no-index', wheel, cwd=folder)
    # Path files inside a borrowed folder are not read: what is editable here is unknown there.
    [site] = home.glob('lib/python*/site-packages')
    borrowed = {sysconfig.get_path('purelib'), sysconfig.get_path('platlib')}
    (site / 'borrowed.pth').write_text('\n'.join(sorted(borrowed)) + '\n')
    return home


def test_the_command_and_its_data_are_in_the_wheel(installed):
    text = run(installed / 'bin' / 'fpnet', '--help', cwd=installed)
    assert 'localize' in text
    assert run(installed / 'bin' / 'fpnet', '--version', cwd=installed).startswith('fpnet 0')
    where, tensors, templates = run(
        installed / 'bin' / 'python', '-c', LOOK, cwd=installed
    ).splitlines()
    assert Path(where).is_relative_to(installed)
    assert int(tensors) > 10
    shipped = {path.name for path in (ROOT / 'fpnet/report/templates').iterdir()}
    assert set(templates.split()) == shipped


def test_the_wheel_holds_all_code_weights_and_templates_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    skipped = {'__pycache__', '.pyc'}
    expected = {
        str(path.relative_to(ROOT))
        for package in PACKAGES
        for path in (ROOT / package).rglob('*')
        if path.is_file() and not any(each in str(path) for each in skipped)
    }
    assert expected - names == set(), 'missing in the wheel'
    [info] = {name.split('/')[0] for name in names if name.endswith('.dist-info/METADATA')}
    data = info.replace('.dist-info', '.data')
    others = {n for n in names - expected if not n.startswith((f'{info}/', f'{data}/data/share/'))}
    assert others == set(), 'only code, weights and templates belong there'
    share = {name.removeprefix(f'{data}/data/share/fpnet_ros/') for name in names}
    assert {'package.xml', 'config/fpnet.yaml', 'launch/localizer.launch.py'} <= share
    assert wheel.stat().st_size < MAX_BYTES


def test_the_wheel_states_its_commands_extras_and_licence(wheel):
    with zipfile.ZipFile(wheel) as archive:
        [at] = [name for name in archive.namelist() if name.endswith('/METADATA')]
        stated = message_from_bytes(archive.read(at))
        commands = archive.read(at.replace('METADATA', 'entry_points.txt')).decode()
    assert {'plans', 'report', 'ros', 'lab', 'train'} <= set(stated.get_all('Provides-Extra'))
    assert stated['Requires-Python'] == '>=3.11'
    needed = [each for each in stated.get_all('Requires-Dist') if 'extra ==' not in each]
    assert any(each.startswith('kiss-icp') for each in needed)
    assert not any(each.startswith(('torch', 'scikit', 'networkx', 'open3d')) for each in needed)
    assert 'fpnet = fpnet.cli:main' in commands
    assert stated.get_all('License-File') == ['LICENSE']


@pytest.mark.skipif('ROS_DISTRO' in os.environ, reason="the system's packages are not ours")
def test_the_installed_packages_agree():
    run(*PIP, 'check', cwd=ROOT)
