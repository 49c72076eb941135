# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Network of the ``fpnet`` preset: joint attention with invariant relations.

Differences from the paper's network: The nodes of both graphs form one sequence, so one attention
layer replaces a self and a cross layer at a quarter of the calls. A small network adds the
relation of two nodes of a graph (distance, direction relative to either axis, connection) to their
attention logit, where the paper multiplies weights by a function of normalised positions. Absolute
positions are not used. Every layer predicts its own assignment and is trained on it. A double
softmax with a matchability per node replaces dustbins and the forty sweeps of Sinkhorn's
iteration.

Inference uses arrays, training tensors (``fpnet_lab.training.networks``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnet_core.graphs.invariant import AXIS, INVARIANT_LAYOUT, POSITION_UNITS, invariant_rows
from fpnet_core.graphs.layout import POSITION, FeatureLayout
from fpnet_core.models.arrays import MASKED, Array, JointBias, Library
from fpnet_core.models.batch import GraphBatch, PreparedBatch
from fpnet_core.models.config import InvariantConfig
from fpnet_core.types import RegionGraph

NODE_FEATURES = INVARIANT_LAYOUT.size - AXIS.stop
"""Given: columns of a node in its descriptor; position and axis only enter the relations."""

RELATIONS = 12
"""Given: number of features of a pair of nodes, see :func:`relations`."""

RELATION_WIDTH = 16
"""Hidden units between relations and attention logits. Chosen."""

_PAIRS_AT_ONCE = 2**16  # numerical: bounds memory; 2,000 regions at once would take gigabytes
_NEAR_UNITS = 1.0  # distances enter by their logarithm from about here on; chosen
_TINY = float(np.finfo(np.float32).tiny)  # numerical: no division by zero

Graphs = GraphBatch | PreparedBatch


@dataclass(frozen=True, eq=False)
class JointAttention:
    """
    The network on arrays of ``library``; ``parameters`` by name, see :meth:`shapes`.

    Letters: ``B`` pairs of graphs, ``M`` and ``N`` nodes of plan and submap, ``R`` either.
    """

    config: InvariantConfig
    library: Library
    parameters: Mapping[str, Array]

    layout: ClassVar[FeatureLayout] = INVARIANT_LAYOUT

    @staticmethod
    def rows(graph: RegionGraph) -> NDArray[np.float32]:
        """Return the invariant rows of ``graph``."""
        return invariant_rows(graph)

    def log_assignment(self, plan: Graphs, sub: Graphs) -> Array:
        """
        Return the log-assignment ``(B, M+1, N+1)`` of the last layer, dustbins last.

        Equivariant to permutations of the nodes of either side.
        """
        return self._assignment(self._states(plan, sub)[-1], plan.mask, sub.mask)

    def assignments(self, plan: Graphs, sub: Graphs) -> list[Array]:
        """Return the log-assignment of every layer; the last is :meth:`log_assignment`."""
        return [self._assignment(s, plan.mask, sub.mask) for s in self._states(plan, sub)]

    def prepared(self, batch: GraphBatch) -> PreparedBatch:
        """Return what depends on one batch only: a plan is matched many times."""
        return PreparedBatch(self._encoded(batch), self._relation_logits(batch), batch.mask)

    def _encoded(self, batch: GraphBatch) -> Array:
        """Return the nodes ``(B, R, width)`` at the input of the first layer."""
        linear, gelu = self.library.linear, self.library.gelu
        hidden = gelu(linear(batch.node_feat[..., AXIS.stop :], *self._of('encoder.0')))
        return linear(hidden, *self._of('encoder.2'))

    def _relation_logits(self, batch: GraphBatch) -> Array:
        """Return the attention logits of the relations, ``(B, layers, heads, R, R)``."""
        size = batch.mask.shape[1]
        step = max(1, _PAIRS_AT_ONCE // size)
        parts = [
            self._logits_of_rows(batch, slice(start, start + step))
            for start in range(0, size, step)
        ]
        return parts[0] if len(parts) == 1 else self.library.module.concatenate(parts, axis=-2)

    def _logits_of_rows(self, batch: GraphBatch, rows: slice) -> Array:
        xp, mixed = self.library.module, self.library.mixed
        seen = relations(self.library, batch, rows)
        pairs = seen.reshape(len(seen), RELATIONS, -1)
        hidden = xp.clip(mixed(pairs, *self._of('relation_bias.hidden')), 0.0, None)
        both = xp.concatenate([hidden, pairs], axis=1)
        logits = mixed(both, *self._of('relation_bias.out'))
        heads = (self.config.layers, self.config.heads)
        return logits.reshape(len(seen), *heads, *seen.shape[2:])

    def _of(self, name: str) -> tuple[Array, Array]:
        return self.parameters[f'{name}.weight'], self.parameters[f'{name}.bias']

    def _states(self, plan: Graphs, sub: Graphs) -> list[Array]:
        """Return the nodes ``(B, M+N, width)`` after each layer."""
        sides = [self.prepared(x) if isinstance(x, GraphBatch) else x for x in (plan, sub)]
        state = self.library.module.concatenate([side.encoded for side in sides], axis=1)
        mask = self.library.module.concatenate([plan.mask, sub.mask], axis=1)
        states = []
        for layer in range(self.config.layers):
            ours, theirs = (side.relations[:, layer] for side in sides)
            bias = JointBias(ours, theirs, self.parameters['across'][layer], mask)
            state = self._layer(f'layers.{layer}', state, bias)
            states.append(state)
        return states

    def _layer(self, name: str, state: Array, bias: JointBias) -> Array:
        """Apply attention among the nodes of both graphs and a residual two-layer update."""
        linear = self.library.linear
        nodes = self.library.layer_norm(state, *self._of(f'{name}.normalise'))
        count, size, width = state.shape
        qkv = linear(nodes, *self._of(f'{name}.qkv'))
        qkv = qkv.reshape(count, size, 3, self.config.heads, -1)
        query, key, value = (qkv[:, :, part].swapaxes(1, 2) for part in range(3))
        message = self.library.attention(query, key, value, bias)
        message = message.swapaxes(1, 2).reshape(count, size, width)
        both = self.library.module.concatenate([nodes, message], axis=-1)
        hidden = self.library.gelu(linear(both, *self._of(f'{name}.update')))
        return state + linear(hidden, *self._of(f'{name}.out'))

    def _assignment(self, state: Array, plan_mask: Array, sub_mask: Array) -> Array:
        projected = self.library.layer_norm(state, *self._of('normalise'))
        projected = self.library.linear(projected, *self._of('project'))
        descriptor, matchable = projected[..., :-1], projected[..., -1]
        size = plan_mask.shape[1]
        scores = self.library.product(
            descriptor[:, :size], descriptor[:, size:].swapaxes(-1, -2)
        ) / math.sqrt(self.config.width)
        sides = (matchable[:, :size], matchable[:, size:], plan_mask, sub_mask)
        return double_softmax(self.library, scores, *sides)

    @staticmethod
    def shapes(config: InvariantConfig) -> dict[str, tuple[int, ...]]:
        """Return the shape of every parameter."""
        width, logits = config.width, config.layers * config.heads
        found: dict[str, tuple[int, ...]] = {'across': (config.layers, config.heads)}
        linear = {
            'encoder.0': (2 * width, NODE_FEATURES),
            'encoder.2': (width, 2 * width),
            'relation_bias.hidden': (RELATION_WIDTH, RELATIONS),
            'relation_bias.out': (logits, RELATION_WIDTH + RELATIONS),
            'project': (width + 1, width),
        }
        normalised = ['normalise']
        for layer in (f'layers.{index}' for index in range(config.layers)):
            linear[f'{layer}.qkv'] = (3 * width, width)
            linear[f'{layer}.update'] = (2 * width, 2 * width)
            linear[f'{layer}.out'] = (width, 2 * width)
            normalised.append(f'{layer}.normalise')
        for name, shape in linear.items():
            found |= {f'{name}.weight': shape, f'{name}.bias': shape[:1]}
        for name in normalised:
            found |= {f'{name}.weight': (width,), f'{name}.bias': (width,)}
        return found


def relations(library: Library, batch: GraphBatch, rows: slice = slice(None)) -> Array:
    """
    Return the relations of all pairs of nodes a, b within each graph, ``(B, 12, R, R)``.

    ``rows`` selects the nodes a.

    Directions are doubled angles, because an axis has no sign; mirror images stay distinguishable.
    A square room has an arbitrary axis but elongation zero, so its axis has no effect.
    """
    xp = library.module
    position = batch.node_feat[..., POSITION] * POSITION_UNITS
    offset = position[..., None, :, :] - position[..., rows, None, :]
    x, y = offset[..., 0], offset[..., 1]
    squared = x * x + y * y
    log_distance = 0.5 * xp.log(squared + _NEAR_UNITS**2)
    # The doubled direction as a unit vector: (x + iy)^2 / |x + iy|^2, zero for the node itself.
    inverse = 1.0 / (squared + _TINY)
    cos, sin = (x * x - y * y) * inverse, 2.0 * x * y * inverse
    axis_cos, axis_sin = batch.node_feat[..., AXIS.start], batch.node_feat[..., AXIS.start + 1]
    a_cos, a_sin = axis_cos[..., rows, None], axis_sin[..., rows, None]
    b_cos, b_sin = axis_cos[..., None, :], axis_sin[..., None, :]
    linked = batch.adjacency[..., rows, :]
    own = library.identity_like(batch.adjacency)[rows]
    return xp.stack(
        [
            log_distance - 1.5,
            xp.exp(-0.5 * xp.clip(squared, None, 50.0)),
            xp.clip(0.05 * xp.sqrt(squared + 1e-12), None, 2.0),
            linked,
            xp.clip(library.product(linked, batch.adjacency), None, 1.0) * (1.0 - own),
            xp.broadcast_to(own, linked.shape),
            cos * a_cos + sin * a_sin,
            sin * a_cos - cos * a_sin,
            cos * b_cos + sin * b_sin,
            sin * b_cos - cos * b_sin,
            a_cos * b_cos + a_sin * b_sin,
            b_sin * a_cos - b_cos * a_sin,
        ],
        axis=1,
    )


def double_softmax(
    library: Library,
    scores: Array,
    plan_matchable: Array,
    sub_matchable: Array,
    plan_mask: Array,
    sub_mask: Array,
) -> Array:
    """
    Return log-probabilities ``(B, M+1, N+1)`` of pairs; the last are of unmatchable nodes.

    A pair's probability is the product of both softmaxes of ``scores (B, M, N)`` and of both
    nodes' matchabilities, given as logits ``(B, M)`` and ``(B, N)``. Sums over rows and columns
    without the dustbins are below 1. Padding gets ``MASKED``.
    """
    xp, log_sigmoid = library.module, library.log_sigmoid
    plan_real, sub_real = plan_mask[:, :, None], sub_mask[:, None, :]
    rows = library.log_softmax(xp.where(sub_real, scores, MASKED), 2)
    columns = library.log_softmax(xp.where(plan_real, scores, MASKED), 1)
    pairs = rows + columns + log_sigmoid(plan_matchable)[:, :, None]
    pairs = pairs + log_sigmoid(sub_matchable)[:, None, :]
    pairs = xp.where(plan_real & sub_real, pairs, MASKED)
    plan_dust = xp.where(plan_mask, log_sigmoid(-plan_matchable), MASKED)
    sub_dust = xp.where(sub_mask, log_sigmoid(-sub_matchable), MASKED)
    corner = xp.full_like(sub_dust[:, :1], MASKED)
    top = xp.concatenate([pairs, plan_dust[:, :, None]], axis=2)
    bottom = xp.concatenate([sub_dust, corner], axis=1)[:, None, :]
    return xp.concatenate([top, bottom], axis=1)
