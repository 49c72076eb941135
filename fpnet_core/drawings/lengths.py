# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parsing of lengths, sizes, areas and scale ratios in texts."""

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
"""Physical: length of a unit [m] by its lower-case name in drawings."""

# Physical: scales of drawings; 1/4 inch to the foot is 1:48.
RATIOS = frozenset({10, 20, 25, 33, 50, 75, 100, 125, 150, 200, 250, 300, 400, 500, 750, 1000})

_FOOT_SIGN, _INCH_SIGN = r'[\'\u2032\u2019]', r'(?:[\"\u2033\u201d]|\'\'|\u2019\u2019)'
_LENGTH = re.compile(r'(?:[≈~]\s*)?(\d{1,6}(?:[.,]\d{1,3})?)\s*([a-zм\']{1,6})?', re.IGNORECASE)
_FEET = re.compile(
    rf'(\d{{1,4}})\s*(?:{_FOOT_SIGN}|ft\.?\s(?=\s*\d))\s*-?\s*'
    rf'(?:(\d{{1,2}})?\s*(?:(\d{{1,2}})/(\d{{1,2}}))?\s*(?:{_INCH_SIGN}|in\.?)?)?',
    re.IGNORECASE,
)
_BARE = (('m', re.compile(r'\d{1,3}[.,]\d{1,3}')), ('cm', re.compile(r'\d{2,4}')),
         ('mm', re.compile(r'\d{3,6}')))  # fmt: skip

_BETWEEN = re.compile(r'\s*(?:[x\u00d7\u2715*]|\bby\b)\s*', re.IGNORECASE)
_SIDE = (
    rf'\d{{1,3}}\s*(?:{_FOOT_SIGN}|ft\.?)\s*-?\s*(?:\d{{0,2}}(?:\s*\d{{1,2}}/\d{{1,2}})?\s*'
    rf'(?:{_INCH_SIGN}|in\b\.?)?)?|\d{{1,5}}(?:[.,]\d{{1,3}})?\s*(?:mm|cm|m)?'
)
_SIZE = re.compile(
    rf'(?<![\d.,/])({_SIDE}){_BETWEEN.pattern}({_SIDE})(?![\d.,/²2])', re.IGNORECASE
)

_AMOUNT = r'(\d{1,5}(?:[.,]\d{1,3})?)'
_SQUARE_METRES = re.compile(
    rf'(?<![\d.,:/]){_AMOUNT}\s*(?:[mм]\s*[2²]|m\^2|qm\b|sq\.?\s*m\b)(?!\w)', re.IGNORECASE
)
_SQUARE_FEET = re.compile(
    rf'(?<![\d.,:/]){_AMOUNT}\s*(?:sq\.?\s*(?:ft|feet)\b|ft\s*[2²]|sf\b)(?!\w)', re.IGNORECASE
)
_NAMED_AREA = re.compile(
    rf'\b(?:NGF|NRF|NUF|NF|BGF|GIA|NIA|area|fläche)\s*(?:[:=]|ca\.?)?\s*{_AMOUNT}(?![\d.,:/])\s*$',
    re.IGNORECASE,
)
_THOUSANDS = re.compile(r'\d{1,2}[.,]\d{3}')

_RATIO = re.compile(r'(?<![\d:/.])1\s*[:/]\s*(\d{1,4})(?![\d:/.,])')
_INCH_TO_FOOT = re.compile(
    rf'(?:(\d{{1,2}})\s*/\s*(\d{{1,2}})|(\d{{1,2}}))\s*(?:{_INCH_SIGN}|in\b\.?|inch(?:es)?\b)'
    rf'\s*(?:=|to|:)\s*(\d{{1,3}})\s*-?\s*(?:{_FOOT_SIGN}|ft\b|foot\b|feet\b)',
    re.IGNORECASE,
)  # fmt: skip


_LONGEST = 80  # numerical: evaluated characters of a text; files may hold any number


def _short(text: str) -> str:
    """Return the start of a text with whitespace collapsed."""
    return ' '.join(text[: 2 * _LONGEST].split())[:_LONGEST]


def lengths(text: str) -> Iterator[tuple[float, str]]:
    """Yield possible (metres, assumed unit) of a text; the unit is empty if it is stated."""
    text = _short(text)
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
    """Return the number in a text and its unit [m]; None for what is missing."""
    match = _LENGTH.fullmatch(_short(text))
    if match is None:
        return None, None
    unit = (match.group(2) or '').lower()
    if unit and unit not in WRITTEN_UNITS_M:
        return None, None
    return float(match.group(1).replace(',', '.')), WRITTEN_UNITS_M.get(unit)


def room_sizes(text: str) -> Iterator[tuple[float, float, str]]:
    """
    Yield possible (metres, metres, assumed unit) of a room size such as ``325 x 285``.

    The unit is empty if it is stated; one behind the second side counts for both.
    """
    match = _SIZE.search(_short(text))
    if match is None:
        return
    first, second = (side.strip() for side in match.groups())
    unit = re.search(r'(mm|cm|m)$', second, re.IGNORECASE)
    if unit is not None and first[-1].isdigit():
        first += unit.group(1)
    others = {name: metres for metres, name in lengths(second)}
    for metres, name in lengths(first):
        if name in others and min(metres, others[name]) > 0.0:
            yield metres, others[name], name


def areas(text: str) -> Iterator[float]:
    """Yield possible areas [m2] of a text; ``1,250`` may be 1250 or 1.25."""
    match, unit_m2 = _area(_short(text))
    if match is None:
        return
    amount = match.group(1)
    values = {float(amount.replace(',', '.'))}
    if _THOUSANDS.fullmatch(amount):
        values.add(float(re.sub(r'[.,]', '', amount)))
    yield from sorted(value * unit_m2 for value in values if value > 0.0)


def without_area(text: str) -> str:
    """Return a text without its area: ``Office`` for ``Office 13.2 m2``."""
    text = _short(text)
    match, _ = _area(text)
    return text if match is None else f'{text[: match.start()]} {text[match.end() :]}'.strip()


def _area(text: str) -> tuple[re.Match[str] | None, float]:
    """Return the match of an area in a text, None if there is none, and its unit [m2]."""
    for pattern, unit_m2 in (
        (_SQUARE_METRES, 1.0),
        (_SQUARE_FEET, FOOT_M**2),
        (_NAMED_AREA, 1.0),
    ):
        match = pattern.search(text)
        if match is not None:
            return match, unit_m2
    return None, 1.0


def ratios(text: str) -> Iterator[float]:
    """Yield the scale denominators that a text states: 100 for ``1:100``."""
    text = _short(text)
    for match in _INCH_TO_FOOT.finditer(text):
        above, below, whole, feet = (int(part) if part else 0 for part in match.groups())
        inches = above / below if below else float(whole)
        if inches and feet:
            yield feet * FOOT_M / (inches * INCH_M)
    for match in _RATIO.finditer(text):
        if int(match.group(1)) in RATIOS:
            yield float(match.group(1))
