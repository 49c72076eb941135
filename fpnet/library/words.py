# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Pairs of keypoints as words: quantized distance and direction of each towards the other.

A word does not depend on the pose of a map, and each pair of equal words implies a placement of
one map on the other: geometric hashing (Lamdan and Wolfson, 1988) with oriented points.
"""

from __future__ import annotations

from dataclasses import dataclass
import itertools

import numpy as np
from numpy.typing import NDArray

from fpnet.library.keypoints import KINDS, PERIOD, Keypoints

# Chosen, not measured:
# Distances of pairs [m]: nearer ones are not distinctive, farther ones vary with the scale.
_NEAREST_M, _FARTHEST_M = 0.8, 9.0
# Bin of distance [m]: drawings are stretched by some per cent.
_STEP_M = 0.3
# Angle bins per turn, 30 degrees each.
_TURNS = 12
# Nearest partners of a keypoint in plans, and in robot maps, where some keypoints are missing.
_PARTNERS, _ASKED_PARTNERS = 6, 10

_STEPS = int((_FARTHEST_M - _NEAREST_M) / _STEP_M) + 1  # numerical
_TURNS_OF = np.array(
    [_TURNS // 2, _TURNS, _TURNS]
)  # given, by kind: doors repeat after 180 degrees
_NEIGHBOURS = np.array(list(itertools.product((0, 1), repeat=3)))  # given: corners of a cube

WORDS = KINDS * KINDS * _STEPS * _TURNS * _TURNS
"""Numerical: number of possible words; most never occur."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """
    Words of a map, ``word (P,)``, and the positions of their pairs.

    Midpoint ``middle (P, 2)`` [m] and ``bearing (P,)`` [rad] from first to second keypoint.
    """

    word: NDArray[np.int64]
    middle: NDArray[np.float32]
    bearing: NDArray[np.float32]

    def __len__(self) -> int:
        """Return the number of words."""
        return len(self.word)


def pairs_of_plan(keypoints: Keypoints) -> Pairs:
    """Return the word of each pair of near keypoints once."""
    ends = _near(keypoints, _PARTNERS)
    kind = keypoints.kind[ends]
    ends = np.where((kind[:, :1] > kind[:, 1:]), ends[:, ::-1], ends)
    features = _Features.of(keypoints, ends)
    return features.pairs(np.floor(features.places).astype(np.int64), np.arange(len(ends)))


def pairs_of_query(keypoints: Keypoints) -> Pairs:
    """
    Return the possible words of each pair in a plan's index, up to sixteen.

    They include both nearest bins per axis, and both orders of two keypoints of the same kind.
    """
    ends = _near(keypoints, _ASKED_PARTNERS)
    both = np.concatenate([ends, ends[:, ::-1]])
    kind = keypoints.kind[both]
    features = _Features.of(keypoints, both[kind[:, 0] <= kind[:, 1]])
    below = np.floor(features.places - 0.5).astype(np.int64)
    cells = (below[:, None] + _NEIGHBOURS).reshape(-1, 3)
    return features.pairs(cells, np.repeat(np.arange(len(below)), len(_NEIGHBOURS)))


def _near(keypoints: Keypoints, partners: int) -> NDArray[np.int64]:
    """Return the pairs ``(P, 2)`` of keypoints of which one is among the other's nearest."""
    if len(keypoints) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    apart = keypoints.xy[:, None] - keypoints.xy[None]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    distance[(distance < _NEAREST_M) | (distance > _FARTHEST_M)] = np.inf
    partners = min(partners, len(keypoints))
    nearest = np.argpartition(distance, partners - 1, axis=1)[:, :partners]
    first = np.repeat(np.arange(len(keypoints)), partners)
    second = nearest.ravel()
    is_near = np.isfinite(distance[first, second])
    first, second = first[is_near], second[is_near]
    # Sorting one number for each pair is faster than sorting pairs.
    both = np.unique(np.minimum(first, second) * len(keypoints) + np.maximum(first, second))
    return np.stack(np.divmod(both, len(keypoints)), axis=1).astype(np.int64)


@dataclass(frozen=True, eq=False)
class _Features:
    """Pairs with their coordinates ``places (P, 3)`` in bins, and their ``kinds``."""

    places: NDArray[np.float64]
    kinds: NDArray[np.int64]
    middle: NDArray[np.float32]
    bearing: NDArray[np.float32]

    @classmethod
    def of(cls, keypoints: Keypoints, ends: NDArray[np.int64]) -> _Features:
        first, second = keypoints.xy[ends[:, 0]], keypoints.xy[ends[:, 1]]
        along = second - first
        bearing = np.arctan2(along[:, 1], along[:, 0])
        kinds = keypoints.kind[ends].astype(np.int64)
        turns = (keypoints.angle[ends] - bearing[:, None]) % PERIOD[kinds]
        steps = (np.hypot(along[:, 0], along[:, 1]) - _NEAREST_M) / _STEP_M
        places = np.column_stack([steps, turns / PERIOD[kinds] * _TURNS_OF[kinds]])
        return cls(places.astype(np.float64), kinds, (first + second) / 2.0, bearing)

    def pairs(self, cell: NDArray[np.int64], which: NDArray[np.int64]) -> Pairs:
        """Return the words of bins ``(P, 3)``; distances out of range have none."""
        is_word = (cell[:, 0] >= 0) & (cell[:, 0] < _STEPS)
        cell, which = cell[is_word], which[is_word]
        kinds = self.kinds[which]
        turns = cell[:, 1:] % _TURNS_OF[kinds]
        word = (kinds[:, 0] * KINDS + kinds[:, 1]) * _STEPS + cell[:, 0]
        word = (word * _TURNS + turns[:, 0]) * _TURNS + turns[:, 1]
        return Pairs(word, self.middle[which], self.bearing[which])
