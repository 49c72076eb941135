# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How surely a reading is wrong, and which of its rooms: two sets of small networks.

The first see each room, the second the reading as a whole with what the rooms come to. Networks
of different seeds vote by the mean of their log odds. They are evaluated without a deep-learning
framework.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.room_figures import ROOM_FIGURES
from fpnet_core.drawings.sheet_figures import SHEET_FIGURES, room_summary
from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import Weights, check_shapes, read_weights

Array = NDArray[np.float64]
Side = Literal['room', 'sheet']

DOUBT_SCHEMA = 1
"""Grows when a figure changes its meaning."""

DOUBT_NAME = 'doubts.safetensors'

CLIP = 3.0
"""Figures are standardised and held to so many standard deviations: nothing unseen counts more."""

SIDES: dict[Side, tuple[str, ...]] = {'room': ROOM_FIGURES, 'sheet': SHEET_FIGURES}


@dataclass(frozen=True, eq=False)
class DoubtModel:
    """
    ``tensors`` of the networks for rooms, ``room.NAME``, and for whole readings, ``sheet.NAME``.

    Letters: ``D`` figures, ``m`` networks, ``h`` width. ``mean`` and ``spread (D,)`` standardise
    the figures; ``first (m, h, D)``, ``second (m, h)`` and ``direct (m, D)`` are the layers,
    their biases called alike. A reading that is wrong with more than ``doubted_from`` is doubted.
    """

    tensors: dict[str, NDArray[np.float32]]
    doubted_from: float

    def right_rooms(self, rooms: Array) -> Array:
        """Return how probably (R,) each room of figures ``(R, D)`` is one of the building's."""
        return self._probability('room', rooms)

    def wrong(self, whole: Array, rooms: Array) -> float:
        """Return how probably a reading is wrong, of its figures and those (R, D) of its rooms."""
        figures = np.concatenate([whole, room_summary(rooms, self.right_rooms(rooms))])
        return float(self.of_sheets(figures[None])[0])

    def of_sheets(self, figures: Array) -> Array:
        """Return how probably (N,) readings of figures ``(N, D)`` are wrong."""
        return self._probability('sheet', figures)

    def _probability(self, side: Side, figures: Array) -> Array:
        t = {
            name.partition('.')[2]: value.astype(np.float64)
            for name, value in self.tensors.items()
            if name.startswith(f'{side}.')
        }
        x = np.clip(np.nan_to_num((figures - t['mean']) / t['spread']), -CLIP, CLIP)
        hidden = _silu(np.einsum('mhd,rd->mrh', t['first'], x) + t['first_bias'][:, None])
        votes = np.einsum('mh,mrh->mr', t['second'], hidden) + t['second_bias'][:, None]
        return np.asarray(1.0 / (1.0 + np.exp(-(votes + t['direct'] @ x.T).mean(axis=0))))


def _silu(x: Array) -> Array:
    return np.asarray(x / (1.0 + np.exp(-x)))


def read_doubt_model(path: Path | None = None) -> DoubtModel:
    """
    Read trained weights; None reads the packaged ones.

    Raises
    ------
    WeightsError
        If a file is missing or damaged, or was made for other figures.
    """
    return model_of(read_weights(path, DOUBT_SCHEMA, DOUBT_NAME))


@lru_cache(maxsize=1)
def packaged_doubt_model() -> DoubtModel:
    """Return the packaged model, read once."""
    return read_doubt_model()


def model_of(weights: Weights) -> DoubtModel:
    """Return the model that a checkpoint holds."""
    network = weights.manifest['network']
    for side, figures in SIDES.items():
        if network.get(f'{side}_figures') != list(figures):
            raise WeightsError(
                f'doubt weights: {side} figures differ from those of this version; train again '
                'with fpnet train-doubts'
            )
    found = {name: value.shape for name, value in weights.tensors.items()}
    check_shapes(DOUBT_NAME, found, shapes(int(network['members']), int(network['width'])))
    return DoubtModel(weights.tensors, float(network['doubted_from']))


def shapes(members: int, width: int) -> dict[str, tuple[int, ...]]:
    """Return the shape of every tensor."""
    found: dict[str, tuple[int, ...]] = {}
    for side, figures in SIDES.items():
        size = len(figures)
        found |= {
            f'{side}.mean': (size,), f'{side}.spread': (size,),
            f'{side}.first': (members, width, size), f'{side}.first_bias': (members, width),
            f'{side}.second': (members, width), f'{side}.second_bias': (members,),
            f'{side}.direct': (members, size),
        }  # fmt: skip
    return found
