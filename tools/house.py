# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Count the lines of each part of the project and compare them with their limits.

Usage: ``python tools/house.py``; ``--write`` puts the table into docs/architecture.md.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
import sys

from fpnet_lab.evaluation.published.figures import pages as pages_of
from fpnet_lab.evaluation.published.figures import write_figures
from fpnet_lab.provenance import Provenance
from fpnet_lab.scores import Table

ROOT = Path(__file__).resolve().parents[1]

# Given: most lines of each part. None: no limit.
PARTS = {
    'floorplans: formats, parser, model, scale': (('fpnet_core/drawings',), 5400),
    'rooms and doors of maps': (('fpnet_core/segmentation',), 1400),
    'likelihood and alignment': (('fpnet_core/pose', 'fpnet_core/scoring'), 900),
    'search and matcher': (
        ('fpnet_core/matching', 'fpnet_core/models', 'fpnet_core/graphs'),
        1300,
    ),
    'posterior and localizer': (('fpnet_core/localizer',), 2600),
    'reasons and causes': (
        tuple(
            f'fpnet_core/scoring/{name}.py'
            for name in ('invocation', 'causes', 'findings', 'reasons')
        ),
        600,
    ),
    'core in all': (('fpnet_core',), 29_000),
    'desk': (('fpnet',), None),
    'nodes and adapters': (('fpnet_ros', 'msg_adapters'), 4000),
    'lab': (('fpnet_lab',), 22_000),
    'tests': (('test',), 25_000),
}


def lines_of(places: Iterable[str]) -> dict[Path, int]:
    """Return the number of lines of each Python file among and below ``places``."""
    paths = [ROOT / place for place in places]
    files = [path for path in paths if path.is_file()]
    files += [file for path in paths for file in path.rglob('*.py')]
    return {file: len(file.read_text(encoding='utf-8').splitlines()) for file in files}


def table() -> str:
    """Return the line counts of all parts as a Markdown table."""
    counted = {name: lines_of(places) for name, (places, _) in PARTS.items()}
    for file in counted['reasons and causes']:
        del counted['likelihood and alignment'][file]
    rows = []
    for name, (places, most) in PARTS.items():
        homes = ', '.join(f'`{place}`' for place in places)
        aim = '' if most is None else f'{most:,}'
        rows.append([name, homes, f'{sum(counted[name].values()):,}', aim])
    return Table(['part', 'home', 'lines', 'aim'], rows).markdown()


def main() -> None:
    """Print the table, or write it into its page."""
    if sys.argv[1:] != ['--write']:
        print(table())
        return
    made = replace(Provenance.now(), command='python tools/house.py')
    for page in write_figures(pages_of(ROOT), {'house': f'{made}:\n\n{table()}\n\n'}):
        print(f'wrote {page}')


if __name__ == '__main__':
    main()
