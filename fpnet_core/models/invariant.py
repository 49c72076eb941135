# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The network of the ``fpnet`` preset: joint attention with invariant relations.

Against the paper's network: the nodes of both graphs are one sequence, so one attention layer
does the work of a self and a cross layer at a quarter of the calls; what two nodes of a graph
have to do with each other (distance, direction relative to either's axis, connection) is added
to their attention logit by a small network, where the paper multiplies weights by a function of
normalised positions; no absolute position enters; every layer predicts an assignment of its own
and is trained on it; a double softmax with a matchability per node replaces dustbins and the
forty sweeps of Sinkhorn's iteration.
"""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray
import torch
from torch import Tensor, nn
from torch.nn import functional

from fpnet_core.graphs.invariant import AXIS, INVARIANT_LAYOUT, POSITION_UNITS, invariant_rows
from fpnet_core.graphs.layout import POSITION
from fpnet_core.models.attention import MASKED
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.config import InvariantConfig
from fpnet_core.models.network import RegionNetwork
from fpnet_core.types import RegionGraph

_NODE_FEATURES = INVARIANT_LAYOUT.size - AXIS.stop
_RELATIONS = 12  # given
# Chosen, not measured:
_RELATION_WIDTH = 16
_FOCUS = ((3, 4.0), (4, 4.0), (0, -1.5))  # relation and first weight of successive heads
_ACROSS = 3.0  # first logit of the other graph's nodes, for heads that look there
_NEAR_UNITS = 1.0  # distances enter by their logarithm from about here on


def relations(batch: GraphBatch) -> Tensor:
    """
    Return what node a sees of node b, ``(B, 12, R, R)``, for all pairs within each graph.

    Directions are doubled angles, because an axis has no sign; they stay apart from their mirror
    images. A square room, whose axis is arbitrary, contributes nothing by its elongation of zero.
    """
    position = batch.node_feat[..., POSITION] * POSITION_UNITS
    offset = position.unsqueeze(-3) - position.unsqueeze(-2)
    x, y = offset[..., 0], offset[..., 1]
    squared = x.square() + y.square()
    log_distance = 0.5 * (squared + _NEAR_UNITS**2).log()
    # The doubled direction as a unit vector: (x + iy)^2 / |x + iy|^2, zero for a node itself.
    inverse = (squared + torch.finfo(squared.dtype).tiny).reciprocal()
    cos, sin = (x.square() - y.square()) * inverse, 2.0 * x * y * inverse
    axis_cos, axis_sin = batch.node_feat[..., AXIS].unbind(-1)
    a_cos, a_sin = axis_cos.unsqueeze(-1), axis_sin.unsqueeze(-1)
    b_cos, b_sin = axis_cos.unsqueeze(-2), axis_sin.unsqueeze(-2)
    linked = batch.adjacency
    own = torch.eye(linked.shape[-1], device=linked.device, dtype=linked.dtype)
    return torch.stack(
        [
            log_distance - 1.5,
            torch.exp(-0.5 * squared.clamp_max(50.0)),
            (0.05 * (squared + 1e-12).sqrt()).clamp_max(2.0),
            linked,
            (linked @ linked).clamp_max(1.0) * (1.0 - own),
            own.expand_as(linked),
            cos * a_cos + sin * a_sin,
            sin * a_cos - cos * a_sin,
            cos * b_cos + sin * b_sin,
            sin * b_cos - cos * b_sin,
            a_cos * b_cos + a_sin * b_sin,
            b_sin * a_cos - b_cos * a_sin,
        ],
        dim=1,
    )


class RelationBias(nn.Module):
    """Attention logits of all layers and heads from the relations within a graph."""

    def __init__(self, layers: int, heads: int) -> None:
        super().__init__()
        self.layers, self.heads = layers, heads
        self.hidden = nn.Linear(_RELATIONS, _RELATION_WIDTH)
        self.out = nn.Linear(_RELATION_WIDTH + _RELATIONS, layers * heads)
        with torch.no_grad():
            self.out.weight[:, _RELATION_WIDTH:] = _first_focus(layers, heads)

    def forward(self, batch: GraphBatch) -> Tensor:
        """Return ``(B, layers, heads, R, R)``."""
        count, size = batch.mask.shape
        pairs = relations(batch).flatten(2)
        hidden = functional.relu(_per_pair(self.hidden, pairs))
        logits = _per_pair(self.out, torch.cat([hidden, pairs], dim=1))
        return logits.view(count, self.layers, self.heads, size, size)


def _per_pair(layer: nn.Linear, pairs: Tensor) -> Tensor:
    """Apply ``layer`` to ``pairs (B, features, K)``; a batched product spares two transposes."""
    count = len(pairs)
    weight = layer.weight.expand(count, -1, -1)
    return torch.baddbmm(layer.bias[:, None].expand(count, -1, 1), weight, pairs)


class JointLayer(nn.Module):
    """Attention among the nodes of both graphs, then a residual two-layer update."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.normalise = nn.LayerNorm(width)
        self.qkv = nn.Linear(width, 3 * width)
        self.update = nn.Linear(2 * width, 2 * width)
        self.out = nn.Linear(2 * width, width)
        nn.init.zeros_(self.out.weight)
        nn.init.zeros_(self.out.bias)

    def forward(self, state: Tensor, bias: Tensor) -> Tensor:
        """Return new nodes ``(B, M+N, width)``; ``bias (B, heads, M+N, M+N)``."""
        nodes = self.normalise(state)
        qkv = self.qkv(nodes).unflatten(-1, (3, self.heads, -1)).permute(2, 0, 3, 1, 4)
        query, key, value = qkv.unbind(0)
        message = functional.scaled_dot_product_attention(query, key, value, attn_mask=bias)
        message = message.transpose(1, 2).flatten(-2)
        hidden = functional.gelu(self.update(torch.cat([nodes, message], dim=-1)))
        updated: Tensor = state + self.out(hidden)
        return updated


class InvariantNetwork(RegionNetwork):
    """Joint attention over both graphs; see the module's text."""

    layout = INVARIANT_LAYOUT

    @staticmethod
    def rows(graph: RegionGraph) -> NDArray[np.float32]:
        """Return the invariant rows of ``graph``."""
        return invariant_rows(graph)

    def __init__(self, config: InvariantConfig) -> None:
        super().__init__()
        self.config = config
        width = config.width
        self.encoder = nn.Sequential(
            nn.Linear(_NODE_FEATURES, 2 * width), nn.GELU(), nn.Linear(2 * width, width)
        )
        self.relation_bias = RelationBias(config.layers, config.heads)
        self.layers = nn.ModuleList(JointLayer(width, config.heads) for _ in range(config.layers))
        self.across = nn.Parameter(_first_across(config.layers, config.heads))
        self.normalise = nn.LayerNorm(width)
        self.project = nn.Linear(width, width + 1)

    def forward(self, plan: GraphBatch, sub: GraphBatch) -> Tensor:
        """
        Return the log-assignment ``(B, M+1, N+1)`` of the last layer, dustbins last.

        Equivariant to permutations of the nodes of either side.
        """
        *_, last = self._states(plan, sub)
        return self._assignment(last, plan.mask, sub.mask)

    def assignments(self, plan: GraphBatch, sub: GraphBatch) -> list[Tensor]:
        """Return the log-assignment of every layer, the last one as :meth:`forward`."""
        return [self._assignment(s, plan.mask, sub.mask) for s in self._states(plan, sub)]

    def prepared(self, batch: GraphBatch) -> GraphBatch:
        """Return the batch with the logits of its relations: a plan is matched many times."""
        return replace(batch, relations=self.relation_bias(batch))

    def _states(self, plan: GraphBatch, sub: GraphBatch) -> list[Tensor]:
        state = self.encoder(
            torch.cat([plan.node_feat[..., AXIS.stop :], sub.node_feat[..., AXIS.stop :]], dim=1)
        )
        states = []
        for layer, bias in zip(self.layers, self._bias(plan, sub).unbind(1), strict=True):
            state = layer(state, bias)
            states.append(state)
        return states

    def _bias(self, plan: GraphBatch, sub: GraphBatch) -> Tensor:
        """Return ``(B, layers, heads, M+N, M+N)``: relations at home, constants across."""
        ours, theirs = (
            side.relations if side.relations is not None else self.relation_bias(side)
            for side in (plan, sub)
        )
        across = self.across[None, :, :, None, None]
        away = across.expand(*ours.shape[:-1], theirs.shape[-1])
        back = across.expand(*theirs.shape[:-1], ours.shape[-1])
        joint = torch.cat([torch.cat([ours, away], -1), torch.cat([back, theirs], -1)], -2)
        mask = torch.cat([plan.mask, sub.mask], dim=1)
        if not bool(mask.all()):
            joint = joint + (~mask * MASKED)[:, None, None, None, :]
        return joint

    def _assignment(self, state: Tensor, plan_mask: Tensor, sub_mask: Tensor) -> Tensor:
        projected = self.project(self.normalise(state))
        descriptor, matchable = projected[..., :-1], projected[..., -1]
        size = plan_mask.shape[1]
        scores = descriptor[:, :size] @ descriptor[:, size:].transpose(-1, -2)
        return double_softmax(
            scores / math.sqrt(self.config.width),
            matchable[:, :size],
            matchable[:, size:],
            plan_mask,
            sub_mask,
        )


def double_softmax(
    scores: Tensor,
    plan_matchable: Tensor,
    sub_matchable: Tensor,
    plan_mask: Tensor,
    sub_mask: Tensor,
) -> Tensor:
    """
    Return ``(B, M+1, N+1)``: log-probabilities of pairs, and of being unmatchable in the last.

    A pair's probability is the product of both softmaxes of ``scores (B, M, N)`` and of both
    nodes' matchabilities, given as logits ``(B, M)`` and ``(B, N)``; sums over rows and columns
    without the dustbins are below 1. Padding gets ``MASKED``.
    """
    rows = scores.masked_fill(~sub_mask[:, None, :], MASKED).log_softmax(dim=2)
    columns = scores.masked_fill(~plan_mask[:, :, None], MASKED).log_softmax(dim=1)
    pairs = rows + columns + functional.logsigmoid(plan_matchable)[:, :, None]
    pairs = pairs + functional.logsigmoid(sub_matchable)[:, None, :]
    real = plan_mask[:, :, None] & sub_mask[:, None, :]
    pairs = pairs.masked_fill(~real, MASKED)
    plan_dust = functional.logsigmoid(-plan_matchable).masked_fill(~plan_mask, MASKED)
    sub_dust = functional.logsigmoid(-sub_matchable).masked_fill(~sub_mask, MASKED)
    corner = scores.new_full((len(scores), 1), MASKED)
    top = torch.cat([pairs, plan_dust[:, :, None]], dim=2)
    bottom = torch.cat([sub_dust, corner], dim=1)[:, None, :]
    return torch.cat([top, bottom], dim=1)


def _first_focus(layers: int, heads: int) -> Tensor:
    """
    Return first weights ``(layers * heads, 12)`` of the relations: heads begin as graph filters.

    In turn, heads look at regions that are connected, at those one door away, and at near ones.
    From uniform attention over a hundred regions, all of this would have to be learned first.
    """
    focus = torch.zeros(layers, heads, _RELATIONS)
    for head in range(heads):
        turn = head % (len(_FOCUS) + 1)
        if turn < len(_FOCUS):
            relation, weight = _FOCUS[turn]
            focus[:, head, relation] = weight
    return focus.flatten(0, 1)


def _first_across(layers: int, heads: int) -> Tensor:
    """Return first logits across the graphs: every fourth head looks there, the others do not."""
    away = torch.arange(heads) % (len(_FOCUS) + 1) == len(_FOCUS)
    return torch.where(away, _ACROSS, -_ACROSS).expand(layers, -1).clone()
