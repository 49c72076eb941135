# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Generated figures in the documentation, between HTML comments.

A table is between the lines ``<!-- figures: NAME -->`` and ``<!-- end -->``; an inline figure is
``<!-- f:NAME -->60 of 66<!-- / -->``. A name has the same content on every page, so pages cannot
contradict each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import re

from fpnet_core.errors import ConfigError

_TABLE = re.compile(r'(<!-- figures: ([\w.]+) -->\n)(.*?)(<!-- end -->)', re.DOTALL)
_VALUE = re.compile(r'(<!-- f:([\w.]+) -->)(.*?)(<!-- / -->)')
_AT_LINE_START = re.compile(r'^\s*<!-- f:', re.MULTILINE)
_OPENING = re.compile(r'<!--\s*(?:figures:|f:)')


@dataclass(frozen=True)
class Stated:
    """Name and text of a figure on a page."""

    page: Path
    name: str
    text: str


def pages(root: Path) -> list[Path]:
    """Return the pages of a checkout that may contain figures."""
    folders = (root / 'docs', root / 'notes')
    return [root / 'README.md', *(page for each in folders for page in sorted(each.glob('*.md')))]


def stated(page: Path) -> Iterator[Stated]:
    """
    Yield the figures on a page.

    Raises
    ------
    ConfigError
        If a marker is not closed, is malformed, or begins a line within a sentence.
    """
    text = page.read_text(encoding='utf-8')
    found = [*_TABLE.finditer(text), *_VALUE.finditer(text)]
    if len(found) != len(_OPENING.findall(text)):
        raise ConfigError(
            f'{page}: a marker of a figure is not closed; end tables with a line <!-- end -->, '
            'inline figures with <!-- / --> on the same line'
        )
    if _AT_LINE_START.search(text):
        raise ConfigError(
            f'{page}: a line begins with the marker of a figure, which ends the paragraph above; '
            'break the line elsewhere'
        )
    for match in found:
        yield Stated(page, match[2], match[3])


def with_figures(text: str, figures: Mapping[str, str]) -> str:
    """Return a page's text with the figures of known names replaced."""
    for pattern in (_TABLE, _VALUE):
        text = pattern.sub(
            lambda match: match[1] + figures.get(match[2], match[3]) + match[4], text
        )
    return text


def write_figures(on_pages: Sequence[Path], figures: Mapping[str, str]) -> list[Path]:
    """
    Write figures into all pages that contain their names; return the changed pages.

    Raises
    ------
    ConfigError
        If a marker is not closed; then nothing is written.
    """
    for page in on_pages:
        list(stated(page))
    changed = []
    for page in on_pages:
        before = page.read_text(encoding='utf-8')
        after = with_figures(before, figures)
        if after != before:
            page.write_text(after, encoding='utf-8')
            changed.append(page)
    return changed
