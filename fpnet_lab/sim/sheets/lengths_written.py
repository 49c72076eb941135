# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Notations of lengths and areas, without errors in the values."""

from __future__ import annotations

from fpnet_core.drawings.lengths import INCH_M

_FOOT_IN = 12  # given: by definition
_SQUARE_FOOT_M2 = (_FOOT_IN * INCH_M) ** 2  # given: by definition


def feet_and_inches(metres: float, has_inches: bool) -> str:
    """Return a length in the format ``12'-6"``, or ``12'`` rounded to a foot."""
    inches = round(metres / INCH_M)
    if not has_inches:
        return f"{round(inches / _FOOT_IN)}'"
    return f'{inches // _FOOT_IN}\'-{inches % _FOOT_IN}"'


def length_text(metres: float, unit: int) -> str:
    """Return a length in one of six notations."""
    texts = (
        f'{metres:.2f}',
        f'{metres:.2f}'.replace('.', ','),
        f'{1e3 * metres:.0f}',
        f'{1e2 * metres:.0f}',
        feet_and_inches(metres, has_inches=True),
        f'{metres:.2f} m',
    )
    return texts[unit % len(texts)]


def size_text(long_m: float, short_m: float, unit: int) -> str:
    """Return a room's two side lengths in one of six notations."""
    if unit % 6 == 4:
        is_coarse = round(1e3 * long_m) % 2 == 0
        sides = [feet_and_inches(side, has_inches=not is_coarse) for side in (long_m, short_m)]
        return ' x '.join(sides)
    return f'{length_text(long_m, unit)} x {length_text(short_m, unit)}'


def area_text(square_metres: float, unit: int) -> str:
    """Return an area in one of six notations."""
    texts = (
        f'{square_metres:.0f} m\u00b2',
        f'{square_metres:.1f} m2',
        f'{square_metres:.2f} m\u00b2',
        f'NGF {square_metres:.1f}'.replace('.', ','),
        f'{square_metres / _SQUARE_FOOT_M2:.0f} sq ft',
        f'{square_metres:.2f} qm'.replace('.', ','),
    )
    return texts[unit % len(texts)]
