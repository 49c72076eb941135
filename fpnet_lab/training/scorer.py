# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fit of the placement scorer to trials by maximum likelihood.

The truth of a trial is its right placements together, "none of these" on the correct plan, or
"another building's plan". Correct and other plans have equal total weight, and so do kinds of
maps; the localizer replaces the even odds by its own prior.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn

from fpnet_core.errors import FpnetError
from fpnet_core.scoring import CONTEXT, FIGURES, SCORER_SCHEMA
from fpnet_core.small_networks import CLIP
from fpnet_lab.training.gathering import Columns
from fpnet_lab.training.members import MemberTraining, fit_member, stacked_layers, write_members
from fpnet_lab.training.scorer_trials import Trial

_NEVER = -1e9  # numerical
_UNSEEN = 1e9  # numerical: standard deviation that disables a feature
_LEAST_SPREAD = 1e-3  # numerical: of an almost constant feature
_LEAST_SHARE = 1e-6  # numerical: of trials on correct plans, or on others


@dataclass(frozen=True)
class ScorerTraining(MemberTraining):
    """Settings of a fit; the defaults were chosen by cross-validation on the development split."""

    thinned: float = 0.3
    """Share of trials to thin, and of their placements to drop, right ones included."""
    without: tuple[str, ...] = ()
    """Substrings of the names of features to disable, for ablations."""


@dataclass(frozen=True, eq=False)
class TrialTensors(Columns):
    """
    ``N`` trials of up to ``K`` placements.

    ``figures (N, K, D)``, ``context (N, G)``, ``there (N, K)`` marks placements, ``right (N, K)``
    right ones, ``own (N,)`` trials on the correct plan, ``weight (N,)``.
    """

    figures: torch.Tensor
    context: torch.Tensor
    there: torch.Tensor
    right: torch.Tensor
    own: torch.Tensor
    weight: torch.Tensor


def stack_trials(trials: Sequence[Trial]) -> TrialTensors:
    """Return trials padded to the largest; raise FpnetError for none."""
    if not trials:
        raise FpnetError('no trials to learn from; gather some first')
    most = max(len(trial.right) for trial in trials)
    figures = np.zeros((len(trials), most, len(FIGURES)), np.float32)
    there, right = (np.zeros((len(trials), most), np.bool_) for _ in range(2))
    for row, trial in enumerate(trials):
        count = len(trial.right)
        figures[row, :count], there[row, :count] = trial.evidence.figures, True
        right[row, :count] = trial.right
    context = np.stack([trial.evidence.context for trial in trials])
    own = np.array([trial.is_own for trial in trials])
    share = float(np.clip(own.mean(), _LEAST_SHARE, 1.0 - _LEAST_SHARE))
    weight = np.where(own, 0.5 / share, 0.5 / (1.0 - share))  # equal totals of both classes
    return TrialTensors(
        figures=torch.from_numpy(np.nan_to_num(figures)),
        context=torch.from_numpy(np.nan_to_num(context)),
        there=torch.from_numpy(there),
        right=torch.from_numpy(right),
        own=torch.from_numpy(own),
        weight=torch.from_numpy(weight.astype(np.float32)),
    )


class PlacementNetwork(nn.Module):
    """One member; the same function as :class:`fpnet_core.scoring.PlacementModel`."""

    figure_mean: torch.Tensor
    figure_scale: torch.Tensor
    context_mean: torch.Tensor
    context_scale: torch.Tensor

    def __init__(self, width: int, dropout: float) -> None:
        super().__init__()
        figures, context = len(FIGURES), len(CONTEXT)
        for name, size in (('figure', figures), ('context', context)):
            self.register_buffer(f'{name}_mean', torch.zeros(size))
            self.register_buffer(f'{name}_scale', torch.ones(size))
        self.first = nn.Linear(figures + context, width)
        self.second = nn.Linear(width, width)
        self.value = nn.Linear(width, 1)
        self.direct = nn.Linear(figures, 1, bias=False)
        self.none_first = nn.Linear(2 * width + context, width)
        self.none_second = nn.Linear(width, 2)
        self.drop = nn.Dropout(dropout)

    def standardise(self, data: TrialTensors, without: Sequence[str] = ()) -> None:
        """Set means and standard deviations from training data; disable features ``without``."""
        flat = data.figures[data.there]
        for name, values in (('figure', flat), ('context', data.context)):
            getattr(self, f'{name}_mean').copy_(values.mean(dim=0))
            getattr(self, f'{name}_scale').copy_(values.std(dim=0) + _LEAST_SPREAD)
        for scale, names in ((self.figure_scale, FIGURES), (self.context_scale, CONTEXT)):
            blind = [any(word in name for word in without) for name in names]
            scale[torch.tensor(blind)] = _UNSEEN

    def forward(
        self, figures: torch.Tensor, context: torch.Tensor, there: torch.Tensor
    ) -> torch.Tensor:
        """Return log probabilities ``(N, K + 2)``: placements, none of these, other building."""
        x = ((figures - self.figure_mean) / self.figure_scale).clamp(-CLIP, CLIP)
        g = ((context - self.context_mean) / self.context_scale).clamp(-CLIP, CLIP)
        beside = g[:, None].expand(-1, x.shape[1], -1)
        hidden = self.drop(nn.functional.silu(self.first(torch.cat([x, beside], dim=-1))))
        hidden = self.drop(nn.functional.silu(self.second(hidden)))
        scores = (self.value(hidden) + self.direct(x)).squeeze(-1).masked_fill(~there, _NEVER)
        pooled = (torch.softmax(scores, dim=1)[..., None] * hidden).sum(dim=1)
        mean = (hidden * there[..., None]).sum(dim=1) / there.sum(dim=1, keepdim=True).clamp(min=1)
        whole = torch.cat([pooled, mean, g], dim=-1)
        none = self.none_second(self.drop(nn.functional.silu(self.none_first(whole))))
        return torch.log_softmax(torch.cat([scores, none], dim=1), dim=1)


def surprise(
    log_p: torch.Tensor, right: torch.Tensor, own: torch.Tensor, weight: torch.Tensor
) -> torch.Tensor:
    """Return the mean negative log probability of the truth [nats]."""
    placed = torch.logsumexp(log_p[:, :-2].masked_fill(~right, _NEVER), dim=1)
    on_own = torch.where(right.any(dim=1), placed, log_p[:, -2])
    truth = torch.where(own, on_own, log_p[:, -1])
    return -(truth * weight).sum() / weight.sum()


def _fit(data: TrialTensors, config: ScorerTraining, member: int) -> PlacementNetwork:
    generator = torch.Generator().manual_seed(config.seed_of(member))

    def make() -> PlacementNetwork:
        network = PlacementNetwork(config.width, config.dropout)
        network.standardise(data, config.without)
        return network

    def loss_of(network: PlacementNetwork, chosen: torch.Tensor) -> torch.Tensor:
        there = _thinned(data.there[chosen], config.thinned, generator)
        log_p = network(data.figures[chosen], data.context[chosen], there)
        right = data.right[chosen] & there
        return surprise(log_p, right, data.own[chosen], data.weight[chosen])

    return fit_member(make, loss_of, len(data.own), config, member, generator)


def _thinned(there: torch.Tensor, share: float, generator: torch.Generator) -> torch.Tensor:
    """Drop some placements of some trials, never all: at run time candidates may be missing."""
    some = torch.rand((len(there), 1), generator=generator) < share
    gone = (torch.rand(there.shape, generator=generator) < share) & some
    kept = there & ~gone
    return torch.where(kept.any(dim=1, keepdim=True), kept, there)


def fit_scorer(
    data: TrialTensors, config: ScorerTraining, on_member: Callable[[float], None] = lambda _: None
) -> list[PlacementNetwork]:
    """Train all members."""
    networks = []
    for member in range(config.members):
        networks.append(_fit(data, config, member))
        on_member(1.0)
    return networks


def write_scorer(
    path: Path, networks: Sequence[PlacementNetwork], config: ScorerTraining, facts: dict[str, Any]
) -> None:
    """Write the networks as one checkpoint with its manifest; ``facts`` join the manifest."""
    moments = {name: value.numpy() for name, value in networks[0].named_buffers()}
    tensors = moments | stacked_layers(networks)
    write_members(path, tensors, SCORER_SCHEMA, config, facts, figures=FIGURES, context=CONTEXT)
