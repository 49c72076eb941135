# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Make a release: versions, changelog, wheel, commit and tag. It does not push anything.

Run: python tools/release.py 0.2.0    (make release VERSION=0.2.0)
"""

import argparse
from datetime import date
from pathlib import Path
import re
import subprocess
import sys

ROOT = Path(__file__).resolve().parents[1]
STATED = {
    'pyproject.toml': r"(?m)^version = '([^']+)'",
    'package.xml': r'<version>([^<]+)</version>',
    'interfaces/fpnet_msgs/package.xml': r'<version>([^<]+)</version>',
    'CITATION.cff': r'(?m)^version: (\S+)',
}
"""Files that state the version, and patterns whose first group is the version."""

CHANGELOG, NEW = 'CHANGELOG.md', r'(?m)^## (\S+) \(unreleased\)'
VERSION = re.compile(r'\d+\.\d+\.\d+')


class ReleaseError(Exception):
    """Reason why a release is not possible; its text is shown to the user."""


def stated_versions(root: Path) -> dict[str, str]:
    """Return the version stated in each file."""
    found = {}
    for name, pattern in STATED.items():
        match = re.search(pattern, (root / name).read_text(encoding='utf-8'))
        if match is None:
            raise ReleaseError(f'{name} states no version; expected a match of {pattern}')
        found[name] = match[1]
    return found


def check(root: Path, version: str) -> None:
    """Raise ReleaseError if ``version`` cannot be released."""
    if not VERSION.fullmatch(version):
        raise ReleaseError(f'{version} is no version; expected three numbers, for example 0.2.0')
    stated = stated_versions(root)
    if len(set(stated.values())) != 1:
        said = ', '.join(f'{name} {each}' for name, each in stated.items())
        raise ReleaseError(f'the files state different versions: {said}; make them agree')
    before = next(iter(stated.values()))
    is_first = not (root / CHANGELOG).read_text(encoding='utf-8').count('\n## ') > 1
    if numbers(version) < numbers(before) or (version == before and not is_first):
        raise ReleaseError(f'{version} is not newer than {before}')
    if not re.search(NEW, (root / CHANGELOG).read_text(encoding='utf-8')):
        raise ReleaseError(
            f'{CHANGELOG} has no unreleased section; add "## {version} (unreleased)" '
            'with the changes for users'
        )


def numbers(version: str) -> tuple[int, ...]:
    """Return a version's numbers, for comparison."""
    return tuple(map(int, version.split('.')))


def write_version(root: Path, version: str, day: date) -> None:
    """Write the version into all files that state it, and the date into the changelog."""
    for name, pattern in STATED.items():
        replace(root / name, pattern, version)
    path = root / CHANGELOG
    text = path.read_text(encoding='utf-8')
    path.write_text(re.sub(NEW, f'## {version} ({day})', text, count=1), encoding='utf-8')


def replace(path: Path, pattern: str, version: str) -> None:
    """Replace the first group of the first match."""
    text = path.read_text(encoding='utf-8')
    match = re.search(pattern, text)
    assert match is not None  # checked by stated_versions
    path.write_text(text[: match.start(1)] + version + text[match.end(1) :], encoding='utf-8')


def run(*words: str) -> str:
    """Run a command in the checkout and return its output; raise ReleaseError if it fails."""
    done = subprocess.run(  # noqa: S603
        words, cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise ReleaseError(f'{" ".join(words)}: {done.stderr.strip() or done.stdout.strip()}')
    return done.stdout


def release(version: str) -> None:
    """Check and write the version, build the wheel, commit and tag."""
    if changed := run('git', 'status', '--porcelain', '--untracked-files=no').strip():
        raise ReleaseError(f'the working tree has changes; commit or discard them:\n{changed}')
    check(ROOT, version)
    write_version(ROOT, version, date.today())
    run(sys.executable, '-m', 'pip', 'wheel', '-q', '--no-deps', '-w', 'dist', '.')
    run('git', 'commit', '-m', f'Release {version}', *STATED, CHANGELOG)
    run('git', 'tag', '-a', f'v{version}', '-m', f'Release {version}')


def main() -> None:
    """Make the release, or exit with the reason in one line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('version')
    try:
        release(parser.parse_args().version)
    except ReleaseError as error:
        sys.exit(f'release: {error}')


if __name__ == '__main__':
    main()
