# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The matching network of the paper (section IV), written from the paper's equations.

A graph encoder (eq. 2), blocks of self- and cross-attention with an edge function (eqs. 3 to 7),
and log-domain Sinkhorn iterations with dustbins (section IV-4 and 5).

The paper leaves the edge function phi open ("defined by connectivity between nodes and relative
spatial positions jointly", two variants). This module has both, and a third that matches the
paper's ablation:

- ``connectivity``: 1 for adjacent nodes and the node itself, 0.7 otherwise.
- ``distance``: the inverse distance for adjacent nodes, 0.5 for others, 20 for the node itself.
  Distances are divided by the node's mean distance to its neighbours, so that phi does not
  depend on the scale of the map, and bounded, so that no neighbour outweighs the node itself.
- ``proximity``: as ``distance``, but treats all nodes as adjacent: no connectivity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import itertools
import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnet_core.graphs.features import CONFIDENCE, NODE_FEATURES, PAPER_LAYOUT
from fpnet_core.graphs.layout import POSITION, FeatureLayout
from fpnet_core.models.arrays import MASKED, Array, Library
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.config import EdgeMapping, PaperConfig
from fpnet_core.types import RegionGraph

POSE_FEATURES = CONFIDENCE.stop
"""Given: columns of the position encoder: x, y, confidence."""

DESCRIPTOR_FEATURES = NODE_FEATURES - POSITION.stop
"""Given: columns of a node that are not its position."""

CONNECTED, UNCONNECTED = 1.0, 0.7
"""Values of the connectivity variant. Chosen."""

SELF_WEIGHT, FAR_WEIGHT, LARGEST_INVERSE_DISTANCE = 20.0, 0.5, 10.0
"""
Values of the distance variant: the node itself, non-adjacent nodes, bound of the rest. Chosen.
"""

_TINY = float(np.finfo(np.float32).tiny)  # numerical: no square root and no logarithm of zero
_LEAST_DISTANCE = 1e-6  # numerical: no division by zero


@dataclass(frozen=True, eq=False)
class PaperNetwork:
    """
    The paper's network on arrays of ``library``; ``parameters`` by name, see :meth:`shapes`.

    Without an edge function it is the backbone that the paper extends. Letters: ``B`` pairs of
    graphs, ``M`` and ``N`` nodes of plan and submap, ``R`` either.
    """

    config: PaperConfig
    library: Library
    parameters: Mapping[str, Array]

    layout: ClassVar[FeatureLayout] = PAPER_LAYOUT

    @staticmethod
    def rows(graph: RegionGraph) -> NDArray[np.float32]:
        """Return the graph's own 28 features."""
        return graph.node_feat

    @staticmethod
    def prepared(batch: GraphBatch) -> GraphBatch:
        """Return the batch: attention to the other graph leaves nothing to compute before."""
        return batch

    def log_assignment(self, plan: GraphBatch, sub: GraphBatch) -> Array:
        """
        Return the log-assignment ``(B, M+1, N+1)`` (see :func:`sinkhorn`).

        Equivariant to permutations of the nodes of either side.
        """
        plan_state, sub_state = self.describe(plan, sub)
        # Scaled so that scores start at about unit variance for any width.
        scores = self.library.product(plan_state, sub_state.swapaxes(-1, -2))
        return sinkhorn(
            self.library,
            scores / math.sqrt(self.config.width),
            self.parameters['dustbin'],
            plan.mask,
            sub.mask,
            self.config.sinkhorn_iterations,
        )

    def assignments(self, plan: GraphBatch, sub: GraphBatch) -> list[Array]:
        """Return every log-assignment that training supervises: the final one."""
        return [self.log_assignment(plan, sub)]

    def describe(self, plan: GraphBatch, sub: GraphBatch) -> tuple[Array, Array]:
        """Return matching descriptors ``(B, M, width)`` and ``(B, N, width)`` (paper, eq. 8)."""
        plan_state, sub_state = self.encoded(plan.node_feat), self.encoded(sub.node_feat)
        plan_phi, sub_phi = (
            edge_weights(self.library, self.config.edge_mapping, each) for each in (plan, sub)
        )
        for block in range(self.config.blocks):
            within, across = f'self_layers.{block}', f'cross_layers.{block}'
            plan_state = self._propagated(within, plan_state, plan_state, plan.mask, plan_phi)
            sub_state = self._propagated(within, sub_state, sub_state, sub.mask, sub_phi)
            plan_state, sub_state = (
                self._propagated(across, plan_state, sub_state, sub.mask),
                self._propagated(across, sub_state, plan_state, plan.mask),
            )
        return self._linear('project', plan_state), self._linear('project', sub_state)

    def encoded(self, node_feat: Array) -> Array:
        """
        Encode ``(B, R, 28)`` to initial node states ``h = MLP(p) + d``, ``(B, R, width)`` (eq. 2).

        ``p`` is (x, y, confidence), ``d`` the 26 features that are not position. Confidence is in
        both, which makes the paper's 28 features consistent with its width of 26. Another width
        needs a linear map of ``d``; the paper's own width does not.
        """
        state, descriptor = node_feat[..., :POSE_FEATURES], node_feat[..., POSITION.stop :]
        last = 3 * len(self.config.position_widths)
        for index in range(0, last, 3):
            state = self._linear(f'encoder.position.{index}', state)
            state = self._normalised(f'encoder.position.{index + 1}', state)
        state = self._linear(f'encoder.position.{last}', state)
        if self.config.width != DESCRIPTOR_FEATURES:
            descriptor = self._linear('encoder.descriptor', descriptor)
        return state + descriptor

    def _propagated(
        self, name: str, target: Array, source: Array, source_mask: Array, phi: Array | None = None
    ) -> Array:
        """
        Return ``target + MLP([target, message])``, ``(B, T, width)`` (paper, eq. 3).

        The MLP normalises with LayerNorm: batch statistics would mix padding and unrelated
        buildings into a node, and a robot matches one pair at a time.
        """
        message = self.message(f'{name}.attention', target, source, source_mask, phi)
        both = self.library.module.concatenate([target, message], axis=-1)
        hidden = self._normalised(f'{name}.update.1', self._linear(f'{name}.update.0', both))
        return target + self._linear(f'{name}.update.3', hidden)

    def message(
        self, name: str, target: Array, source: Array, source_mask: Array, phi: Array | None = None
    ) -> Array:
        """
        Return messages ``sum_j (alpha_ij * phi_ij) V_j``, ``(B, T, width)`` (paper, eqs. 4 to 7).

        Parameters
        ----------
        name : of the attention's parameters
        target : (B, T, width)
        source : (B, S, width)
        source_mask : (B, S) bool; a graph without a True sends zeros
        phi : (B, heads or 1, T, S) factors of the softmaxed weights, or None for ones
        """
        xp, product, width = self.library.module, self.library.product, self.config.width
        key_value = self._linear(f'{name}.key_value', source)
        query, key, value = (
            each.reshape(*each.shape[:2], self.config.heads, -1).swapaxes(1, 2)
            for each in (
                self._linear(f'{name}.query', target),
                key_value[..., :width],
                key_value[..., width:],
            )
        )
        logits = product(query / math.sqrt(query.shape[-1]), key.swapaxes(-1, -2))
        logits = xp.where(source_mask[:, None, None, :], logits, MASKED)
        weights = xp.exp(self.library.log_softmax(logits, -1))
        weights = weights if phi is None else weights * phi
        merged = product(weights, value).swapaxes(1, 2).reshape(*target.shape[:2], width)
        return self._linear(f'{name}.merge', merged) * source_mask.any(-1)[:, None, None]

    def _linear(self, name: str, x: Array) -> Array:
        weight, bias = self.parameters[f'{name}.weight'], self.parameters[f'{name}.bias']
        return self.library.linear(x, weight, bias)

    def _normalised(self, name: str, x: Array) -> Array:
        """Return layer normalisation and ReLU."""
        weight, bias = self.parameters[f'{name}.weight'], self.parameters[f'{name}.bias']
        return self.library.module.clip(self.library.layer_norm(x, weight, bias), 0.0, None)

    @staticmethod
    def shapes(config: PaperConfig) -> dict[str, tuple[int, ...]]:
        """Return the shape of every parameter."""
        width = config.width
        linear, normalised = {'project': (width, width)}, {}
        widths = [POSE_FEATURES, *config.position_widths]
        for index, (before, after) in enumerate(itertools.pairwise(widths)):
            linear[f'encoder.position.{3 * index}'] = (after, before)
            normalised[f'encoder.position.{3 * index + 1}'] = after
        linear[f'encoder.position.{3 * len(config.position_widths)}'] = (width, widths[-1])
        if width != DESCRIPTOR_FEATURES:
            linear['encoder.descriptor'] = (width, DESCRIPTOR_FEATURES)
        for kind, block in itertools.product(('self', 'cross'), range(config.blocks)):
            layer = f'{kind}_layers.{block}'
            linear[f'{layer}.attention.query'] = (width, width)
            linear[f'{layer}.attention.key_value'] = (2 * width, width)
            linear[f'{layer}.attention.merge'] = (width, width)
            linear[f'{layer}.update.0'] = (2 * width, 2 * width)
            normalised[f'{layer}.update.1'] = 2 * width
            linear[f'{layer}.update.3'] = (width, 2 * width)
        found: dict[str, tuple[int, ...]] = {'dustbin': ()}
        for name, shape in linear.items():
            found |= {f'{name}.weight': shape, f'{name}.bias': shape[:1]}
        for name, size in normalised.items():
            found |= {f'{name}.weight': (size,), f'{name}.bias': (size,)}
        return found


def edge_weights(library: Library, mapping: EdgeMapping, batch: GraphBatch) -> Array | None:
    """
    Return phi ``(B, 1, R, R)`` of every self-attention layer and head, None for ``none``.

    Row i weights the inputs of node i.
    """
    xp, linked = library.module, batch.adjacency
    own = library.identity_like(linked) > 0
    match mapping:
        case EdgeMapping.NONE:
            return None
        case EdgeMapping.CONNECTIVITY:
            return (UNCONNECTED + (CONNECTED - UNCONNECTED) * xp.where(own, 1.0, linked))[:, None]
        case EdgeMapping.DISTANCE:
            phi = xp.where(linked > 0, _inverse_distances(library, batch, linked), FAR_WEIGHT)
        case EdgeMapping.PROXIMITY:
            both = batch.mask[:, :, None] & batch.mask[:, None, :]
            others = xp.where(both, xp.ones_like(linked), 0.0)
            phi = _inverse_distances(library, batch, others)
    return xp.where(own, SELF_WEIGHT, phi)[:, None]


def pair_distances(library: Library, batch: GraphBatch) -> Array:
    """Return distances ``(B, R, R)`` between node positions, in ``POSITION_UNIT_M``."""
    position = batch.node_feat[..., POSITION]
    offset = position[..., None, :] - position[..., None, :, :]
    return library.module.sqrt((offset * offset).sum(-1) + _TINY)


def _inverse_distances(library: Library, batch: GraphBatch, counted: Array) -> Array:
    """Return each node's mean distance to ``counted (B, R, R)`` nodes over the pair's distance."""
    clip, distance = library.module.clip, pair_distances(library, batch)
    total = clip(counted.sum(-1), 1.0, None)
    mean = (distance * counted).sum(-1) / total
    relative = mean[..., None] / clip(distance, _LEAST_DISTANCE, None)
    return clip(relative, None, LARGEST_INVERSE_DISTANCE)


def sinkhorn(
    library: Library,
    scores: Array,
    dustbin: Array,
    plan_mask: Array,
    sub_mask: Array,
    iterations: int,
) -> Array:
    """
    Return the logarithm of the soft assignment, ``(B, M+1, N+1)``; dustbins come last.

    Every real node has mass 1. The plan's dustbin has as much mass as the submap has nodes, and
    vice versa. After the last sweep the columns sum to these masses exactly and the rows
    approximately. Padding has no mass: its entries are below ``MASKED / 2``.

    Parameters
    ----------
    library : of the arrays
    scores : (B, M, N) inner products of descriptors
    dustbin : () learned score of unmatched nodes
    plan_mask, sub_mask : (B, M), (B, N) bool
    iterations : number of row and column sweeps
    """
    xp, lse = library.module, library.log_sum_exp
    rows, columns = xp.zeros_like(scores[:, :, 0]), xp.zeros_like(scores[:, 0])
    corner = xp.zeros_like(rows[:, :1]) + dustbin
    pairs = xp.where(plan_mask[:, :, None] & sub_mask[:, None, :], scores, MASKED)
    plan_dust = xp.where(plan_mask, rows + dustbin, MASKED)
    sub_dust = xp.concatenate([xp.where(sub_mask, columns + dustbin, MASKED), corner], axis=1)
    couplings = xp.concatenate([pairs, plan_dust[:, :, None]], axis=2)
    couplings = xp.concatenate([couplings, sub_dust[:, None, :]], axis=1)
    # The lower bound replaces log(0) if the other graph is empty.
    plan_count, sub_count = (
        xp.log(xp.clip(xp.where(mask, zeros + 1.0, 0.0).sum(-1), _TINY, None))[:, None]
        for mask, zeros in ((plan_mask, rows), (sub_mask, columns))
    )
    log_rows = xp.concatenate([xp.where(plan_mask, rows, MASKED), sub_count], axis=1)
    log_columns = xp.concatenate([xp.where(sub_mask, columns, MASKED), plan_count], axis=1)
    u, v = xp.zeros_like(log_rows), xp.zeros_like(log_columns)
    for _ in range(iterations):
        u = log_rows - lse(couplings + v[:, None, :], 2)
        v = log_columns - lse(couplings + u[:, :, None], 1)
    return couplings + u[:, :, None] + v[:, None, :]
