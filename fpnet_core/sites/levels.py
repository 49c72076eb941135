# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Level of a storey from the name of its drawing, in several languages."""

from __future__ import annotations

from collections.abc import Sequence
import logging
import re

# Given: words for levels; names are split at all characters but letters and digits.
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
# Given: number words.
_NUMBERS = {
    'first': 1, 'second': 2, 'third': 3, 'fourth': 4, 'fifth': 5, 'erstes': 1, 'zweites': 2,
    'drittes': 3, 'premier': 1, 'deuxième': 2, 'troisième': 3, 'primo': 1, 'primer': 1,
}  # fmt: skip
_ENDINGS = ('st', 'nd', 'rd', 'th', 'er', 'e', 'ème', 'eme', 'de', 'te')
_LETTERS = ('b', 'f', 'l')  # given: levels only with a number; else they may name buildings
_PART = re.compile(r'([^\W\d_]*)(\d*)')  # a word with a number directly after it

_log = logging.getLogger(__name__)


def levels_of(names: Sequence[str]) -> list[int]:
    """
    Return the level of each storey of a building; the ground floor is 0.

    Names without a level are put above all others, alphabetically; one warning lists them.
    """
    parsed = {name: _level(name) for name in names}
    levels = {name: level for name, level in parsed.items() if isinstance(level, int)}
    tops = sorted(name for name, level in parsed.items() if level == 'top')
    unknown = sorted(name for name, level in parsed.items() if level is None)
    for name in (*unknown, *tops):
        levels[name] = max(levels.values(), default=-1) + 1
    if unknown and len(names) > 1:
        _log.warning(
            'ordered alphabetically, as the names give no level: %s; number them (UG1, EG, OG1), '
            'or write a site.yaml',
            ', '.join(unknown),
        )
    return [levels[name] for name in names]


def _level(name: str) -> int | str | None:
    """Return the level in a name, ``top`` for a roof, or None."""
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
    """Return words with the numbers directly after them, and numbers with an empty word."""
    found: list[tuple[str, int | None]] = []
    for word, digits in _PART.findall(name.lower()):
        if word in _NUMBERS:
            found.append(('', _NUMBERS[word]))
        elif digits or (word and word not in _ENDINGS):
            found.append((word, int(digits) if digits else None))
    return found
