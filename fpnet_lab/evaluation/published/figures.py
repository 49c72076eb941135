# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Figures in the documentation that a command has written, between comments that no reader sees.

A table stands between two lines of its own, ``<!-- figures: NAME -->`` and ``<!-- end -->``; a
figure within a sentence is ``<!-- f:NAME -->60 of 66<!-- / -->``. A name means the same on every
page, so pages cannot state different figures for one thing.
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
    """A figure's name and what a page states for it."""

    page: Path
    name: str
    text: str


def pages(root: Path) -> list[Path]:
    """Return the pages of a checkout that may state figures."""
    folders = (root / 'docs', root / 'notes')
    return [root / 'README.md', *(page for each in folders for page in sorted(each.glob('*.md')))]


def stated(page: Path) -> Iterator[Stated]:
    """
    Yield what a page states between markers.

    Raises
    ------
    ConfigError
        If a marker is not closed, is written otherwise, or begins a line within a sentence.
    """
    text = page.read_text(encoding='utf-8')
    found = [*_TABLE.finditer(text), *_VALUE.finditer(text)]
    if len(found) != len(_OPENING.findall(text)):
        raise ConfigError(
            f'{page}: a marker of a figure is not closed; tables end with a line <!-- end -->, '
            'figures in a sentence with <!-- / --> on the same line'
        )
    if _AT_LINE_START.search(text):
        raise ConfigError(
            f'{page}: a line begins with the marker of a figure, which ends the paragraph above '
            'it; break the line elsewhere'
        )
    for match in found:
        yield Stated(page, match[2], match[3])


def with_figures(text: str, figures: Mapping[str, str]) -> str:
    """Return a page's text with what is between its markers replaced, where the name is known."""
    for pattern in (_TABLE, _VALUE):
        text = pattern.sub(
            lambda match: match[1] + figures.get(match[2], match[3]) + match[4], text
        )
    return text


def write_figures(on_pages: Sequence[Path], figures: Mapping[str, str]) -> list[Path]:
    """
    Write figures into all pages that name them, and return the pages that changed.

    Raises
    ------
    ConfigError
        If a marker is not closed; nothing is written then.
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
