# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Ensemble of small networks that decides whether a line divides two rooms.

The networks see features of the line and its surroundings, of the rooms on both sides as merged so
far, and of the map type. Drawings, finished maps and a robot's own submaps share the networks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from fpnet_core.io.weights import Weights, check_shapes, network_of, read_weights
from fpnet_core.segmentation.door_figures import LINE_FIGURES
from fpnet_core.segmentation.joining import ROOM_FIGURES
from fpnet_core.small_networks import silu, standardised

Array = NDArray[np.float64]

DOOR_SCHEMA = 1
"""Given: incremented when a feature changes its meaning."""

DOOR_NAME = 'doors.safetensors'


MAP_FIGURES = ('is_gap', 'is_drawing', 'has_scans', 'sees_lintels')
"""Whether the line continues a wall's face, and properties of the whole map."""

FIGURES = (*LINE_FIGURES, *MAP_FIGURES, *ROOM_FIGURES)
"""All inputs of a network, in this order."""


@dataclass(frozen=True, eq=False)
class DoorModel:
    """
    ``tensors`` of the networks.

    Letters: ``D`` features, ``m`` networks, ``h`` width. ``mean`` and ``spread (D,)`` standardise
    the features. ``first (m, h, D)``, ``second (m, h, h)`` and ``out (m, h)`` are the layers; each
    has a ``NAME_bias``.
    """

    tensors: dict[str, NDArray[np.float32]]

    def probability_of_one_room(self, figures: Array) -> Array:
        """Return probabilities (L,) that lines with ``figures (L, D)`` divide nothing."""
        t = self._layers
        x = standardised(figures, t['mean'], t['spread'])
        hidden = silu(x @ t['first'] + t['first_bias'])
        hidden = silu(hidden @ t['second'] + t['second_bias'])
        votes = hidden @ t['out'] + t['out_bias']
        return np.asarray(expit(votes.sum(axis=0)[:, 0] / len(votes)))

    @cached_property
    def _layers(self) -> dict[str, Array]:
        """Tensors in double precision, arranged to evaluate all networks at once."""
        layers = {name: tensor.astype(np.float64) for name, tensor in self.tensors.items()}
        for name in ('first', 'second'):
            layers[name] = np.ascontiguousarray(layers[name].transpose(0, 2, 1))
            layers[f'{name}_bias'] = layers[f'{name}_bias'][:, None]
        return layers | {
            'out': layers['out'][:, :, None],
            'out_bias': layers['out_bias'][:, None, None],
        }


@cache
def packaged_door_model() -> DoorModel:
    """Return the packaged model, read once."""
    return model_of(read_weights(None, DOOR_SCHEMA, DOOR_NAME))


def model_of(weights: Weights) -> DoorModel:
    """Return the model of a checkpoint; WeightsError if it was trained on other features."""
    network = network_of(weights, 'doors', {'figures': FIGURES}, 'train doors')
    members, width = (int(network.get(key, 0)) for key in ('members', 'width'))
    check_shapes(DOOR_NAME, weights.tensors, shapes(members, width))
    return DoorModel(weights.tensors)


def shapes(members: int, width: int) -> dict[str, tuple[int, ...]]:
    """Return the shape of every tensor."""
    size = len(FIGURES)
    return {
        'mean': (size,), 'spread': (size,),
        'first': (members, width, size), 'first_bias': (members, width),
        'second': (members, width, width), 'second_bias': (members, width),
        'out': (members, width), 'out_bias': (members,),
    }  # fmt: skip
