# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What pyproject.toml says is needed is what set-up pins, and nothing else is pinned."""

from importlib.metadata import entry_points
from pathlib import Path
import re
import tomllib

from packaging.requirements import Requirement
import pytest

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['project']
# Of developers, not of users.
TOOLS_OF = (
    'axe', 'codespell', 'hypothesis', 'ipython', 'latex2mathml', 'mkdocs', 'mypy', 'nbformat',
    'pytest', 'ruff', 'selenium', 'types', 'colcon', 'setuptools', 'wheel',
)  # fmt: skip


# Of an environment of its own: one of them holds NumPy back.
UNPINNED = 'peers'


def asked_for():
    offered = PROJECT['optional-dependencies']
    extras = [entry for name in offered if name != UNPINNED for entry in offered[name]]
    return [Requirement(text) for text in (*PROJECT['dependencies'], *extras)]


def pinned():
    found = {}
    for name in ('core', 'dev', ''):
        path = ROOT / f'requirements-{name}.txt' if name else ROOT / 'requirements.txt'
        for line in path.read_text(encoding='utf-8').splitlines():
            if match := re.match(r'([\w.-]+)(?:\[\w+\])?==(\S+)', line):
                found[match[1].lower().replace('_', '-')] = match[2]
    return found


def test_every_requirement_is_pinned_to_a_version_that_it_allows():
    for requirement in asked_for():
        name = requirement.name.lower().replace('_', '-')
        if name != 'fpnet-ros':  # the lab asks for other extras
            assert requirement.specifier.contains(pinned()[name]), requirement


def test_every_pin_is_of_something_asked_for():
    names = {requirement.name.lower().replace('_', '-') for requirement in asked_for()}
    assert {name for name in pinned() if not name.startswith(TOOLS_OF)} <= names


def test_what_is_installed_imports_all_that_it_asks_for():
    packages = ('fpnet', 'fpnet_core', 'fpnet_ros', 'msg_adapters')
    sources = [path.read_text() for name in packages for path in (ROOT / name).rglob('*.py')]
    called = {'opencv-python-headless': 'cv2', 'pillow': 'PIL', 'PyYAML': 'yaml'}
    called |= {'scikit-image': 'skimage', 'kiss-icp': 'kiss_icp'}
    for name in (Requirement(text).name for text in PROJECT['dependencies']):
        imports = re.compile(rf'^\s*(?:import|from) {called.get(name, name)}\b', re.MULTILINE)
        assert any(imports.search(source) for source in sources), name


@pytest.mark.parametrize('group', ['fpnet.commands', 'fpnet.plan_tours', 'fpnet.live_nodes'])
def test_entry_points_are_installed(group):
    [entry] = entry_points(group=group)
    assert entry.load()


def test_the_build_without_cuda_is_of_the_version_that_is_pinned():
    text = (ROOT / 'constraints-cpu.txt').read_text(encoding='utf-8')
    assert f'torch=={pinned()["torch"]}+cpu' in text.splitlines()
    assert text.count('--extra-index-url') == 1
    for name in ('docs/install.md', 'docker/Dockerfile.cli'):
        assert 'constraints-cpu.txt' in (ROOT / name).read_text(encoding='utf-8')


def test_the_container_of_the_nodes_has_what_rosdep_has_not():
    """The libraries without a rosdep key or too old, as package.xml says which those are."""
    package = (ROOT / 'package.xml').read_text(encoding='utf-8')
    said = re.search(r'No rosdep key exists for ([^:]+):', package)[1]
    said += ', ' + re.search(r'Too old in Ubuntu 24\.04 are ([^.]+)\.', package)[1]
    without = set(re.findall(r'[a-z][a-z0-9-]+', said)) - {'and'}
    recipe = (ROOT / 'docker' / 'Dockerfile').read_text(encoding='utf-8')
    installed = set(re.search(r"grep -E '\^\(([^)]+)\)=='", recipe)[1].split('|'))
    assert installed == without
    assert installed <= set(pinned())
