# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Texts that a file writes in pieces, joined to the words and numbers that they are."""

from __future__ import annotations

import numpy as np

from fpnet_core.drawings.types import Label

# Chosen, not measured:
_JOIN = 0.6  # of the letters' height between texts of one line
_LETTERED = 0.6  # of the texts are single letters in files that write each letter by itself
_LEVEL = 0.6  # of the smaller letters, in which texts of one line overlap
_ALIKE = 2.2  # the larger letters to the smaller ones, as of an f and an e
_LONGEST_GAP = 4.0  # of a text's height, behind which a line has ended
_SPACE = 0.2  # likewise, for a blank between them
_TURNED = 1.2  # height to width of a text that is turned


def merge_labels(labels: list[Label]) -> list[Label]:
    """
    Return labels with those joined that stand close together in a line: letters and words.

    Numbers stay apart where the file writes words as a whole: those of a scale bar stand close.
    """
    single = sum(len(label.text) == 1 for label in labels)
    is_whole = single < _LETTERED * len(labels)
    for axis in (0, 1):
        labels = _merged(labels, axis, is_whole)
    return labels


def _merged(labels: list[Label], axis: int, is_whole: bool) -> list[Label]:
    """Join along x (``axis`` 0, to the right) or along y (1, upwards: texts that are turned)."""
    across = 1 - axis
    result: list[Label] = []
    growing: list[Label] = []
    for label in sorted(labels, key=lambda k: k.box[0] if axis == 0 else -k.box[3]):
        size = label.box[across + 2] - label.box[across]
        length = label.box[axis + 2] - label.box[axis]
        is_level = axis == 1 and length < _TURNED * size and len(label.text) > 1
        if size <= 0.0 or is_level:
            result.append(label)
            continue
        at = next(
            (
                k for k, last in enumerate(growing)
                if _follows(last, label, axis)
                and not (is_whole and last.text[-1].isdigit() and label.text[0].isdigit())
            ),
            None,
        )  # fmt: skip
        if at is None:
            growing.append(label)
        else:
            growing[at] = _joined(growing[at], label, axis)
        ended = [last for last in growing if _gap(last, label, axis) > _LONGEST_GAP * size]
        result.extend(ended)
        growing = [last for last in growing if last not in ended]
    return result + growing


def _gap(first: Label, second: Label, axis: int) -> float:
    if axis == 0:
        return second.box[0] - first.box[2]
    return first.box[1] - second.box[3]


def _follows(first: Label, second: Label, axis: int) -> bool:
    """Tell whether a text goes on with another: level with it, close, of letters of its size."""
    across = 1 - axis
    one, two = (label.box[across + 2] - label.box[across] for label in (first, second))
    overlap = min(first.box[across + 2], second.box[across + 2]) - max(
        first.box[across], second.box[across]
    )
    is_level = overlap > _LEVEL * min(one, two) and max(one, two) < _ALIKE * min(one, two)
    return is_level and -0.3 * min(one, two) < _gap(first, second, axis) < _JOIN * max(one, two)


def _joined(first: Label, second: Label, axis: int) -> Label:
    across = 1 - axis
    size = max(label.box[across + 2] - label.box[across] for label in (first, second))
    space = ' ' if _gap(first, second, axis) > _SPACE * size else ''
    low = np.minimum(first.box[:2], second.box[:2]).tolist()
    high = np.maximum(first.box[2:], second.box[2:]).tolist()
    return Label(f'{first.text}{space}{second.text}', (low[0], low[1], high[0], high[1]))
