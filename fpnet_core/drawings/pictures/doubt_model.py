# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How surely a reading is wrong, and which of its rooms are.

A forest sees each room (extremely randomised trees: Geurts, Ernst and Wehenkel, 2006); a logistic
regression sees what the rooms come to and the reading as a whole, of which there are far fewer.
Both are evaluated without a learning library.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from fpnet_core.drawings.pictures.room_figures import ROOM_FIGURES
from fpnet_core.drawings.pictures.sheet_figures import SHEET_FIGURES, sheet_evidence
from fpnet_core.io.weights import Weights, check_shapes, network_of, read_weights
from fpnet_core.small_networks import standardised

Array = NDArray[np.float64]

DOUBT_SCHEMA = 1
"""Given: grows when a figure changes its meaning."""

DOUBT_NAME = 'doubts.safetensors'


NAMES = {'room_figures': ROOM_FIGURES, 'sheet_figures': SHEET_FIGURES}
"""Of what the model sees, as the manifest lists them."""


@dataclass(frozen=True, eq=False)
class DoubtModel:
    """
    ``tensors`` of the forest for rooms, ``room.NAME``, and for whole readings, ``sheet.NAME``.

    Letters: ``D`` figures, ``T`` trees, ``N`` nodes. ``usual (D,)`` stands in for figures that
    nothing could be measured of; ``feature (T, N)`` is what a node asks, -1 in a leaf, and
    ``below``, ``above (T, N)`` are the next nodes for figures up to ``limit (T, N)`` or beyond;
    ``value (T, N)`` is what leaves say. Of readings, ``mean`` and ``spread (D,)`` standardise,
    and ``weight (D,)`` and ``bias (1,)`` give log odds. A reading that is wrong with more than
    ``doubted_from`` is doubted.
    """

    tensors: dict[str, NDArray[Any]]
    doubted_from: float

    def right_rooms(self, rooms: Array) -> Array:
        """Return how probably (R,) each room of figures ``(R, D)`` is one of the building's."""
        t = {name: value for name, value in self.tensors.items() if name.startswith('room.')}
        x = np.where(np.isnan(rooms), t['room.usual'], rooms).astype(np.float32)
        feature = t['room.feature']
        rows, trees = np.arange(len(x))[:, None], np.arange(len(feature))[None]
        node = np.zeros((len(x), len(feature)), dtype=np.int64)
        while ((asked := feature[trees, node]) >= 0).any():
            is_below = x[rows, asked] <= t['room.limit'][trees, node]
            turned = np.where(is_below, t['room.below'][trees, node], t['room.above'][trees, node])
            node = np.where(asked >= 0, turned, node)
        return np.asarray(t['room.value'][trees, node].mean(axis=1), dtype=np.float64)

    def wrong(self, whole: Array, rooms: Array) -> float:
        """Return how probably a reading is wrong, of its figures and those (R, D) of its rooms."""
        evidence = sheet_evidence(whole, rooms, self.right_rooms(rooms))
        return float(self.wrong_sheets(evidence[None])[0])

    def wrong_sheets(self, evidence: Array) -> Array:
        """Return how probably (N,) readings of this ``evidence (N, D)`` are wrong."""
        t = self.tensors
        x = standardised(evidence, t['sheet.mean'], t['sheet.spread'])
        return np.asarray(expit(x @ t['sheet.weight'] + t['sheet.bias'][0]))


@cache
def packaged_doubt_model() -> DoubtModel:
    """Return the packaged model, read once."""
    return model_of(read_weights(None, DOUBT_SCHEMA, DOUBT_NAME))


def model_of(weights: Weights) -> DoubtModel:
    """Return the model that a checkpoint holds; WeightsError if it is made for other figures."""
    network = network_of(weights, 'doubt', NAMES, 'train-doubts')
    check_shapes(DOUBT_NAME, weights.tensors, shapes(*network['room_forest']))
    return DoubtModel(weights.tensors, float(network['doubted_from']))


def shapes(trees: int, nodes: int) -> dict[str, tuple[int, ...]]:
    """Return the shape of every tensor."""
    size = len(SHEET_FIGURES)
    names = ('feature', 'limit', 'below', 'above', 'value')
    return {
        'room.usual': (len(ROOM_FIGURES),),
        **{f'room.{name}': (trees, nodes) for name in names},
        **{f'sheet.{name}': (size,) for name in ('mean', 'spread', 'weight')},
        'sheet.bias': (1,),
    }
