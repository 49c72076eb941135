# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A release: one version everywhere, a changelog with its day, and refusals in one line."""

from datetime import date
import importlib.util
from pathlib import Path
import shutil

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
