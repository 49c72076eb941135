# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Merging of text fragments into words, numbers and lines."""

from __future__ import annotations

import numpy as np

from fpnet_core.drawings.types import Label

# Chosen, not measured:
_JOIN = 0.6  # of the letters' height: largest gap between texts of one line
_LETTERED = 0.6  # of the texts are single letters if the file writes each letter separately
_LEVEL = 0.6  # of the smaller height: overlap of texts of one line
_ALIKE = 2.2  # largest ratio of heights on one line, e.g. of f and e
_LONGEST_GAP = 4.0  # of a text's height: larger gaps end a line
_SPACE = 0.2  # of a text's height: larger gaps are spaces
_TURNED = 1.2  # height to width of vertical text


def merge_labels(labels: list[Label]) -> list[Label]:
    """
    Return labels with close neighbours on a line merged: letters and words.

    Numbers are not merged if the file writes whole words: those of a scale bar are close.
    """
    single = sum(len(label.text) == 1 for label in labels)
    is_whole = single < _LETTERED * len(labels)
    for axis in (0, 1):
        labels = _merged(labels, axis, is_whole)
    return labels


def _merged(labels: list[Label], axis: int, is_whole: bool) -> list[Label]:
    """Merge along x (``axis`` 0, to the right) or along y (1, upwards: vertical text)."""
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
    """Return whether ``second`` continues ``first``: aligned, close, of similar letter size."""
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
