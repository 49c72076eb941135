# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Releases, manifests and requirements agree."""

from datetime import date
from importlib.metadata import entry_points
import importlib.util
from pathlib import Path
import re
import runpy
import shutil
import tomllib

from packaging.requirements import Requirement
import pytest

ROOT = Path(__file__).resolve().parents[2]
_spec = importlib.util.spec_from_file_location('release', ROOT / 'tools' / 'release.py')
release = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(release)


@pytest.fixture
def checkout(tmp_path):
    for name in (*release.STATED, release.CHANGELOG):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    release.write_version(tmp_path, '0.3.1', date(2026, 1, 2))
    changelog = tmp_path / release.CHANGELOG
    text = '# Changelog\n\n## 0.4.0 (unreleased)\n\n- New.\n\n## 0.3.1 (2026-01-02)\n\n- Old.\n'
    changelog.write_text(text)
    return tmp_path


def test_all_files_state_the_same_version():
    assert len(set(release.stated_versions(ROOT).values())) == 1


def test_a_release_states_its_version_and_day_everywhere(checkout):
    release.check(checkout, '0.4.0')
    release.write_version(checkout, '0.4.0', date(2026, 12, 24))
    assert set(release.stated_versions(checkout).values()) == {'0.4.0'}
    text = (checkout / release.CHANGELOG).read_text()
    assert '## 0.4.0 (2026-12-24)' in text
    assert '## 0.3.1 (2026-01-02)' in text
    with pytest.raises(release.ReleaseError, match='no unreleased section'):
        release.check(checkout, '0.5.0')


@pytest.mark.parametrize(
    ('version', 'said'),
    [('0.3.1', 'not newer'), ('0.3.0', 'not newer'), ('0.4', 'no version'), ('v1.0.0', 'no ver')],
)
def test_what_is_no_new_version_is_refused(checkout, version, said):
    with pytest.raises(release.ReleaseError, match=said):
        release.check(checkout, version)


def test_ten_is_newer_than_nine(checkout):
    release.write_version(checkout, '0.9.0', date(2026, 1, 2))
    (checkout / release.CHANGELOG).write_text('# Changelog\n\n## 0.10.0 (unreleased)\n')
    release.check(checkout, '0.10.0')


def test_files_that_disagree_are_named(checkout):
    path = checkout / 'package.xml'
    path.write_text(path.read_text().replace('0.3.1', '0.3.0'))
    with pytest.raises(release.ReleaseError, match=r'package\.xml 0\.3\.0'):
        release.check(checkout, '0.4.0')


MANIFESTS = [ROOT / 'package.xml', ROOT / 'interfaces' / 'fpnet_msgs' / 'package.xml']


@pytest.mark.parametrize('path', MANIFESTS, ids=lambda path: path.parent.name)
def test_manifests_are_valid_and_of_one_version(path):
    package = pytest.importorskip('catkin_pkg.package')
    warnings: list[str] = []
    found = package.parse_package(str(path), warnings=warnings)
    found.validate(warnings=warnings)
    assert warnings == []
    project = tomllib.loads((ROOT / 'pyproject.toml').read_text())['project']
    assert found.version == project['version']
    assert [str(each) for each in found.licenses] == [project['license']['text']]


def test_the_changelog_is_one_that_catkin_reads():
    changelog = pytest.importorskip('catkin_pkg.changelog')
    as_catkin = runpy.run_path(str(ROOT / 'tools' / 'changelog.py'))['as_catkin']
    markdown = (ROOT / 'CHANGELOG.md').read_text(encoding='utf-8')
    assert '\nForthcoming\n-----------\n* ' in as_catkin(markdown)
    dated = as_catkin(re.sub(r'\(unreleased\)', '(2026-11-22)', markdown))
    read = changelog.Changelog('fpnet_ros')
    changelog.populate_changelog_from_rst(read, dated)
    ((version, date, contents),) = read.foreach_version()
    assert (version, str(date)[:10]) == ('0.1.0', '2026-11-22')
    entries = [entry for content in contents for entry in content.bullets]
    assert len(entries) == len(re.findall(r'^- ', markdown, flags=re.MULTILINE))


def test_markup_of_entries_becomes_that_of_restructured_text():
    as_catkin = runpy.run_path(str(ROOT / 'tools' / 'changelog.py'))['as_catkin']
    text = '## 0.2.0 (2026-12-01)\n\n- [It](a.md), `a_b`\n  and c_d.\n\n### More\n\n- **B**\n'
    text += '\n### Renamed\n\n| old | new |\n|---|---|\n| `a` | `b` |\n'
    assert as_catkin(text).split('\n')[4:] == [
        '0.2.0 (2026-12-01)', '------------------', '* It, ``a_b`` and c\\_d.', '* B', '',
    ]  # fmt: skip


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
    called |= {'kiss-icp': 'kiss_icp'}
    for name in (Requirement(text).name for text in PROJECT['dependencies']):
        imports = re.compile(rf'^\s*(?:import|from) {called.get(name, name)}\b', re.MULTILINE)
        assert any(imports.search(source) for source in sources), name


@pytest.mark.parametrize('group', ['fpnet.commands', 'fpnet.plan_tours', 'fpnet.listeners'])
def test_entry_points_are_installed(group):
    [entry] = entry_points(group=group)
    assert entry.load()


def test_the_build_without_cuda_is_of_the_version_that_is_pinned():
    text = (ROOT / 'constraints-cpu.txt').read_text(encoding='utf-8')
    assert f'torch=={pinned()["torch"]}+cpu' in text.splitlines()
    assert text.count('--extra-index-url') == 1
    assert 'constraints-cpu.txt' in (ROOT / 'docs/install.md').read_text(encoding='utf-8')


def test_a_robot_installs_no_libraries_of_the_lab():
    names = {Requirement(text).name for text in PROJECT['dependencies']}
    assert not names & {
        'torch', 'scikit-image', 'scikit-learn', 'networkx', 'open3d', 'matplotlib',
    }  # fmt: skip


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
