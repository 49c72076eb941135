# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Print the disk usage of the base installation and of each extra with all that they require.

Run: python tools/installed_sizes.py

Sums up the files of the installed packages of this environment, without an installation.
`tools/wheels.py` installs and tests them.
"""

from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
import tomllib

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]


def required(texts: Iterable[str]) -> dict[str, int]:
    """Return the size in bytes of each required package, directly or indirectly; 0 if missing."""
    found: dict[str, int] = {}
    left = [Requirement(text) for text in texts]
    while left:
        name = canonicalize_name(left.pop().name)
        if name in found:
            continue
        try:
            package = distribution(name)
        except PackageNotFoundError:
            print(f'{name} is not installed')
            found[name] = 0
            continue
        files = [Path(file.locate()) for file in package.files or ()]
        found[name] = sum(file.stat().st_size for file in files if file.is_file())
        needs = [Requirement(text) for text in package.requires or ()]
        left += [n for n in needs if n.marker is None or n.marker.evaluate({'extra': ''})]
    return found


def main() -> None:
    """Print a line for the base installation and for each extra beside it."""
    project = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['project']
    base = required(project['dependencies'])
    print(f'base: {sum(base.values()) / 1e6:.0f} MB in {len(base)} packages')
    for extra, texts in sorted(project['optional-dependencies'].items()):
        own = [text for text in texts if not text.startswith('fpnet_ros[')]
        more = {name: size for name, size in required(own).items() if name not in base}
        print(f'{extra}: {sum(more.values()) / 1e6:.0f} MB in {len(more)} packages')


if __name__ == '__main__':
    main()
