# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fit of the scale model: maximum likelihood of the true length of each map's reference length.

Architects have equal weight whatever their number of buildings and maps; real ones weigh more than
generated buildings, whose doors and rooms have the generator's statistics. Interval coverage is
measured by leaving out each real architect in turn, and generated buildings in folds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import torch
from torch import nn

from fpnet_core.segmentation.scale_figures import COUNTS, FIGURES, LENGTHS, ScaleFigures
from fpnet_core.segmentation.scale_model import (
    CLIP,
    COMPONENTS,
    LOG_SIGMA_RANGE,
    LOG_SIGMA_SHIFT,
    SCALE_SCHEMA,
    ScaleModel,
    Side,
    quantiles,
)
from fpnet_core.small_networks import standardised
from fpnet_lab.evaluation.robots.robot_pairs import architect_of
from fpnet_lab.metrics.intervals import interval_figures
from fpnet_lab.sim.population.floors import TUNE_FLOORS
from fpnet_lab.training.members import MemberTraining, fit_member, stacked_layers, write_members
from fpnet_lab.training.scale_samples import HOME, HOUSE, PRACTICE, SHEET, ScaleSamples

Array = NDArray[np.float64]

SIDES: tuple[Side, Side] = ('plan', 'map')

_NO_ROOMS = np.array(
    [name.startswith(('door_', 'wall_')) for name in LENGTHS] + [False] * len(COUNTS)
)
_LEAST_SPREAD = 0.01  # numerical: of an almost constant feature


@dataclass(frozen=True)
class ScaleTraining(MemberTraining):
    """Settings of a fit; the defaults were chosen by cross-validation on the development split."""

    width: int = 24
    batch_size: int = 128
    learning_rate: float = 8e-3
    weight_decay: float = 3e-2
    noise: float = 0.25
    """Standard deviation of the noise on standardised features."""
    other_rooms: float = 0.12
    """Standard deviation of the log scale of rooms relative to doors and walls: a dozen architects
    show too little of the variation of rooms between buildings."""
    copies: int = 2
    """Of each sample; all except the first have scaled rooms."""
    real_weight: float = 32.0
    """Weight of a real architect relative to a generated building."""
    tail_share: tuple[float, float] = (0.25, 0.25)
    """Weight of a wide component in the density, for drawings and for robot maps: for outliers."""
    tail_sigma: tuple[float, float] = (0.25, 0.3)
    folds: int = 4
    """Number of groups of generated buildings to leave out together."""


class ScaleNetwork(nn.Module):
    """One member for one kind of map; the same function as :class:`ScaleModel`."""

    def __init__(self, width: int, dropout: float) -> None:
        super().__init__()
        self.first = nn.Linear(len(FIGURES), width)
        self.second = nn.Linear(width, width)
        self.mixture = nn.Linear(width, 3 * COMPONENTS)
        self.direct = nn.Linear(len(FIGURES), 1)
        self.drop = nn.Dropout(dropout)

    def forward(self, x: torch.Tensor, target: torch.Tensor) -> torch.Tensor:
        """Return the log density ``(B,)`` of standardised targets, given features ``x (B, D)``."""
        hidden = self.drop(nn.functional.silu(self.first(x)))
        hidden = self.drop(nn.functional.silu(self.second(hidden)))
        weight, mean, log_sigma = self.mixture(hidden).unflatten(1, (3, COMPONENTS)).unbind(1)
        log_sigma = (log_sigma + LOG_SIGMA_SHIFT).clamp(*LOG_SIGMA_RANGE)
        z = (target[:, None] - mean - self.direct(x)) / log_sigma.exp()
        parts = torch.log_softmax(weight, dim=1) - log_sigma - 0.5 * z**2
        return torch.logsumexp(parts, dim=1)


def sample_weights(samples: ScaleSamples, real_weight: float) -> Array:
    """Return weights ``(N,)``: one per generated building, ``real_weight`` per real architect."""
    authors = np.array([architect_of(name) for name in samples.building.tolist()])
    _, number, count = np.unique(authors, return_inverse=True, return_counts=True)
    return np.where(samples.real, real_weight, 1.0) / count[number]


def fit_scale(samples: ScaleSamples, config: ScaleTraining) -> ScaleModel:
    """Fit drawings and maps; the same samples and settings give the same model."""
    tensors: dict[str, NDArray[np.float32]] = {}
    for side in SIDES:
        tensors |= fit_scale_side(samples.where(samples.side == side), side, config).tensors
    return ScaleModel(tensors)


def fit_scale_side(samples: ScaleSamples, side: Side, config: ScaleTraining) -> ScaleModel:
    """Fit the model for either drawings or maps."""
    number = SIDES.index(side)
    tail = config.tail_share[number], config.tail_sigma[number]
    samples = _with_other_rooms(samples, config)
    weight = sample_weights(samples, config.real_weight)
    mean, spread = _moments(samples.values, weight)
    answer = (samples.truth + samples.reference)[:, None]
    target = np.concatenate(_moments(answer, weight))
    x = standardised(samples.values, mean, spread, CLIP)
    y = (answer[:, 0] - target[0]) / target[1]
    data = tuple(torch.from_numpy(v.astype(np.float32)) for v in (x, y, weight / weight.mean()))
    networks = [_fit_member(data, config, member) for member in range(config.members)]
    moments = {'mean': mean, 'spread': spread, 'target': target, 'tail': np.array(tail)}
    found = moments | stacked_layers(networks)
    return ScaleModel(
        {f'{side}.{name}': np.asarray(value, np.float32) for name, value in found.items()}
    )


def _with_other_rooms(samples: ScaleSamples, config: ScaleTraining) -> ScaleSamples:
    """Return copies of the samples with rooms scaled relative to their doors."""
    rng = np.random.default_rng(config.seed)
    copies = samples.where(np.tile(np.arange(len(samples)), config.copies))
    shift = rng.normal(0.0, config.other_rooms, len(copies))
    shift[: len(samples)] = 0.0
    values = copies.values.copy()
    # All lengths are relative to the reference, which is one of the room lengths.
    values[:, _NO_ROOMS] -= shift[:, None]
    return replace(copies, values=values, reference=copies.reference + shift)


def _moments(values: Array, weight: Array) -> tuple[Array, Array]:
    """Return mean and standard deviation of columns that may hold NaN."""
    held = np.where(np.isnan(values), 0.0, weight[:, None])
    total = np.maximum(held.sum(axis=0), _LEAST_SPREAD)
    filled = np.nan_to_num(values)
    mean = (held * filled).sum(axis=0) / total
    spread = np.sqrt((held * (filled - mean) ** 2).sum(axis=0) / total)
    return mean, spread + _LEAST_SPREAD


def _fit_member(
    data: tuple[torch.Tensor, ...], config: ScaleTraining, member: int
) -> ScaleNetwork:
    x, y, weight = data

    def loss_of(network: ScaleNetwork, chosen: torch.Tensor) -> torch.Tensor:
        seen = x[chosen] + config.noise * torch.randn(len(chosen), x.shape[1])
        log_p: torch.Tensor = network(seen, y[chosen])
        return -(weight[chosen] * log_p).mean()

    return fit_member(
        lambda: ScaleNetwork(config.width, config.dropout), loss_of, len(y), config, member
    )


def held_back_estimates(
    samples: ScaleSamples, config: ScaleTraining, on_fold: Callable[[float], None] = lambda _: None
) -> Array:
    """
    Return ``(N, 3)``: log ratios of low, median and high to the true scale.

    Each building's samples are evaluated with a single network that was trained without drawings
    by its architect.
    """
    errors = np.full((len(samples), 3), np.nan)
    single = replace(config, members=1)
    for side in (side for side in SIDES if side in samples.side):
        of_side = samples.side == side
        for fold in folds(samples.where(of_side), config.folds):
            chosen = of_side & np.isin(samples.building, fold)
            model = fit_scale_side(samples.where(of_side & ~chosen), side, single)
            for row in np.flatnonzero(chosen):
                figures = ScaleFigures(samples.values[row], float(samples.reference[row]))
                errors[row] = quantiles(model.posterior(figures, side), (0.05, 0.5, 0.95))
            on_fold(1.0)
    return errors - samples.truth[:, None]


def folds(samples: ScaleSamples, generated: int) -> list[list[str]]:
    """Return buildings to leave out together: real ones by architect, others in folds."""
    real = sorted(set(samples.building[samples.real].tolist()))
    rest = sorted(set(samples.building.tolist()) - set(real))
    alone = [list(group) for _, group in groupby(sorted(real, key=architect_of), architect_of)]
    return [*alone, *(rest[k::generated] for k in range(generated))]


def held_back_figures(samples: ScaleSamples, errors: Array) -> dict[str, dict[str, float]]:
    """Return figures of the samples' last rounds by kind of map, with equal building weights."""
    floors = np.isin(samples.building, TUNE_FLOORS)
    plan = samples.side == 'plan'
    named = {
        name: ~samples.real & np.char.startswith(samples.building, name)
        for name in (SHEET, HOME, PRACTICE, HOUSE)
    }
    others = ~samples.real & ~np.any(list(named.values()), axis=0)
    groups = {
        'bormann': plan & floors,
        'drawings': plan & samples.real,
        'generated': plan & others,
        **{f'{name}s': plan & of_name for name, of_name in named.items()},
        'robot_maps': ~plan & samples.real,
        'generated_maps': ~plan & others,
        'home_maps': ~plan & named[HOME],
    }
    weight = sample_weights(samples, 1.0)
    return {
        name: interval_figures(errors[chosen & samples.final], weight[chosen & samples.final])
        for name, chosen in groups.items()
        if (chosen & samples.final).any()
    }


def write_scale(
    path: Path, model: ScaleModel, config: ScaleTraining, facts: dict[str, Any]
) -> None:
    """Write the model with its manifest; ``facts`` join the manifest."""
    write_members(path, model.tensors, SCALE_SCHEMA, config, facts, figures=FIGURES)
