# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which level the name of a storey's drawing says, in the languages that plans are often in."""

from __future__ import annotations

from collections.abc import Sequence
import logging
import re

# Given: words of a name, which is split at all but letters and digits.
_GROUND = (
    'eg', 'erdgeschoss', 'parterre', 'g', 'gf', 'ground', 'groundfloor', 'rdc', 'rez', 'bg',
    'begane', 'pb', 'terreno', 'terra', 'parter',
)  # fmt: skip
_BELOW = (
    'ug', 'untergeschoss', 'kg', 'keller', 'kellergeschoss', 'b', 'basement', 'cellar', 'lg',
    'sous', 'sotano', 'sótano', 'interrato', 'kelder',
)  # fmt: skip
_ABOVE = (
    'og', 'obergeschoss', 'stock', 'etage', 'étage', 'floor', 'fl', 'f', 'level', 'l', 'storey',
    'story', 'piso', 'planta', 'piano', 'verdieping', 'ebene', 'geschoss',
)  # fmt: skip
_TOP = ('dg', 'dachgeschoss', 'roof', 'attic', 'dach', 'combles', 'zolder')
# Given: numbers in words.
_NUMBERS = {
    'first': 1, 'second': 2, 'third': 3, 'fourth': 4, 'fifth': 5, 'erstes': 1, 'zweites': 2,
    'drittes': 3, 'premier': 1, 'deuxième': 2, 'troisième': 3, 'primo': 1, 'primer': 1,
}  # fmt: skip
_ENDINGS = ('st', 'nd', 'rd', 'th', 'er', 'e', 'ème', 'eme', 'de', 'te')
_LETTERS = ('b', 'f', 'l')  # given: these take a number, or they only tell buildings apart
_PART = re.compile(r'([^\W\d_]*)(\d*)')  # a word with the number that is written to it

_log = logging.getLogger(__name__)


def levels_of(names: Sequence[str]) -> list[int]:
    """
    Return the level of each of a building's storeys, 0 of the ground.

    Those whose names say none come above all others, by the alphabet; one warning names them.
    """
    said = {name: _level(name) for name in names}
    levels = {name: level for name, level in said.items() if isinstance(level, int)}
    tops = sorted(name for name, level in said.items() if level == 'top')
    unsaid = sorted(name for name, level in said.items() if level is None)
    for name in (*unsaid, *tops):
        levels[name] = max(levels.values(), default=-1) + 1
    if unsaid and len(names) > 1:
        _log.warning(
            'levels follow the alphabet where names say none: %s; number them, as UG1, EG, OG1, '
            'or write a site.yaml',
            ', '.join(unsaid),
        )
    return [levels[name] for name in names]


def _level(name: str) -> int | str | None:
    """Return the level that a name says, ``top`` of a roof; None where it says none."""
    parts = _parts(name)
    for place, (word, number) in enumerate(parts):
        if word in _TOP:
            return 'top'
        level = number
        for beside, its in (*parts[place + 1 : place + 2], *parts[max(0, place - 1) : place]):
            level = its if level is None and not beside else level
        if word in _BELOW and (level or word not in _LETTERS):
            return -(level or 1)
        if word in _GROUND:
            return 0
        if word in _ABOVE and level is not None:
            return -level if f'-{level}' in name else level
    if len(parts) != 1 or parts[0][0] or parts[0][1] is None:
        return None
    return -parts[0][1] if f'-{parts[0][1]}' in name else parts[0][1]


def _parts(name: str) -> list[tuple[str, int | None]]:
    """Return words with the numbers that are written to them, and numbers without a word."""
    found: list[tuple[str, int | None]] = []
    for word, digits in _PART.findall(name.lower()):
        if word in _NUMBERS:
            found.append(('', _NUMBERS[word]))
        elif digits or (word and word not in _ENDINGS):
            found.append((word, int(digits) if digits else None))
    return found
