# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Write CHANGELOG.md as the reStructuredText that ROS's release tools read.

Run: python tools/changelog.py > CHANGELOG.rst

A part of a release: CHANGELOG.md is what developers write, and the one place of it.
"""

from __future__ import annotations

from pathlib import Path
import re

_ROOT = Path(__file__).resolve().parents[1]
_TITLE = 'Changelog for package fpnet_ros'
_UNRELEASED = 'Forthcoming'  # given: catkin's word for what has no version yet


def as_catkin(markdown: str) -> str:
    """
    Return a changelog in catkin's format: a section for each version, a list in each.

    Subheadings and tables are left out: the format has lists only.
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
    """Return an entry as one line: what wraps lines is of no use there."""
    text = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', ' '.join(text.split()))
    pieces = text.split('`')
    for at in range(0, len(pieces), 2):  # outside of code a star or an underscore means something
        pieces[at] = re.sub(r'([*_|\\])', r'\\\1', pieces[at].replace('**', ''))
    pieces[1::2] = [f'``{code}``' for code in pieces[1::2]]
    return '* ' + ''.join(pieces)


if __name__ == '__main__':
    print(as_catkin((_ROOT / 'CHANGELOG.md').read_text(encoding='utf-8')), end='')
