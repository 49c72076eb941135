# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Convert CHANGELOG.md to the reStructuredText that ROS's release tools read.

Run: python tools/changelog.py > CHANGELOG.rst

Run it for a release. Developers edit CHANGELOG.md only.
"""

from __future__ import annotations

from pathlib import Path
import re

_ROOT = Path(__file__).resolve().parents[1]
_TITLE = 'Changelog for package fpnet_ros'
_UNRELEASED = 'Forthcoming'  # given: catkin's heading for unreleased changes


def as_catkin(markdown: str) -> str:
    """
    Return a changelog in catkin's format: one section per version, with a list.

    Subheadings and tables are left out: the format supports lists only.
    """
    line = '^' * len(_TITLE)
    parts = [f'{line}\n{_TITLE}\n{line}\n']
    for section in re.split(r'^## ', markdown, flags=re.MULTILINE)[1:]:
        listed = re.sub(r'^(### |\|).*$', '', section, flags=re.MULTILINE)
        heading, _, body = listed.partition('\n')
        heading = _UNRELEASED if 'unreleased' in heading else heading.strip()
        items = [_item(text) for text in re.split(r'^- ', body, flags=re.MULTILINE)[1:]]
        parts.append('\n'.join([heading, '-' * len(heading), *items]) + '\n')
    return '\n'.join(parts)


def _item(text: str) -> str:
    """Return an entry on one line, with Markdown converted to reStructuredText."""
    text = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', ' '.join(text.split()))
    pieces = text.split('`')
    for at in range(0, len(pieces), 2):  # outside of code stars and underscores are markup
        pieces[at] = re.sub(r'([*_|\\])', r'\\\1', pieces[at].replace('**', ''))
    pieces[1::2] = [f'``{code}``' for code in pieces[1::2]]
    return '* ' + ''.join(pieces)


if __name__ == '__main__':
    print(as_catkin((_ROOT / 'CHANGELOG.md').read_text(encoding='utf-8')), end='')
