# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lengths in texts: what units are called, and what a dimension may say in metres."""

from __future__ import annotations

from collections.abc import Iterator
import re

FOOT_M, INCH_M = 0.3048, 0.0254
"""Physical: by definition of the international foot and inch."""

WRITTEN_UNITS_M = {
    'm': 1.0, 'mt': 1.0, 'mts': 1.0, 'meter': 1.0, 'meters': 1.0, 'metres': 1.0, 'metre': 1.0,
    'metros': 1.0, 'м': 1.0, 'cm': 0.01, 'mm': 0.001, 'ft': FOOT_M, 'feet': FOOT_M,
    "'": FOOT_M,
}  # fmt: skip
"""Physical: length of a unit [m] by what it is called in drawings, in lower case."""

_LENGTH = re.compile(r'(?:[≈~]\s*)?(\d{1,6}(?:[.,]\d{1,3})?)\s*([a-zм\']{1,6})?', re.IGNORECASE)
_FEET = re.compile(
    r'(\d{1,4})\s*[\'\u2032\u2019]\s*-?\s*'
    r'(?:(\d{1,2})?\s*(?:(\d{1,2})/(\d{1,2}))?\s*(?:["\u2033\u201d]|\'\'))?'
)
_BARE = (('m', re.compile(r'\d{1,3}[.,]\d{1,3}')), ('cm', re.compile(r'\d{2,4}')),
         ('mm', re.compile(r'\d{3,6}')))  # fmt: skip


def lengths(text: str) -> Iterator[tuple[float, str]]:
    """Yield (metres, unit) that a text may say; the unit is empty where the text says it."""
    feet = _FEET.fullmatch(text)
    if feet is not None:
        whole, inches, above, below = (int(part) if part else 0 for part in feet.groups())
        share = above / below if below else 0.0
        yield whole * FOOT_M + (inches + share) * INCH_M, ''
        return
    match = _LENGTH.fullmatch(text)
    if match is None:
        return
    number = float(match.group(1).replace(',', '.'))
    unit = (match.group(2) or '').lower()
    if unit:
        if unit in WRITTEN_UNITS_M:
            yield number * WRITTEN_UNITS_M[unit], ''
        return
    for name, pattern in _BARE:
        if pattern.fullmatch(match.group(1)):
            yield number * WRITTEN_UNITS_M[name], name


def number_and_unit(text: str) -> tuple[float | None, float | None]:
    """Return the number that a text is, and its unit [m] if it has one; None for no number."""
    match = _LENGTH.fullmatch(text.strip())
    if match is None:
        return None, None
    unit = (match.group(2) or '').lower()
    if unit and unit not in WRITTEN_UNITS_M:
        return None, None
    return float(match.group(1).replace(',', '.')), WRITTEN_UNITS_M.get(unit)
