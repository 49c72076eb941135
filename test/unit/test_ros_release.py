# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What ROS's release tools read: manifests and the changelog, by their own parsers."""

from pathlib import Path
import re
import runpy
import tomllib

import pytest

ROOT = Path(__file__).parents[2]
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
        '0.2.0 (2026-12-01)',
        '------------------',
        '* It, ``a_b`` and c\\_d.',
        '* B',
        '',
    ]
