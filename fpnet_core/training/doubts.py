# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fitting what doubts readings: first which rooms are right, then which readings are wrong.

The second is fitted to what the first says of rooms that it has not learned from. All of it is
measured with buildings left out, and the probability from which on a reading is doubted is chosen
there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import torch
from torch import nn

from fpnet_core.drawings.doubt_model import CLIP, DOUBT_SCHEMA, SIDES, DoubtModel, Side
from fpnet_core.drawings.sheet_figures import room_summary
from fpnet_core.errors import FpnetError
from fpnet_core.io.weights import write_weights
from fpnet_core.training.doubt_trials import ReadingTrial

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

GOOD_F1 = 0.85
"""A reading is right whose rooms agree with the truth as well as this, as the benchmark has it."""

_LEAST_SPREAD = 1e-3  # of a figure that hardly varies


@dataclass(frozen=True)
class DoubtTraining:
    """Settings of a fit; the defaults were chosen by leaving buildings of the tune half out."""

    members: int = 5
    width: int = 16
    epochs: int = 30
    batch_size: int = 128
    learning_rate: float = 3e-3
    room_decay: float = 0.01
    sheet_decay: float = 0.3
    f1_blur: float = 0.03
    """F1 by which readings near the limit are right to some degree."""
    other_weight: float = 0.5
    """Of a reading that was not chosen, against a chosen one."""
    right_doubted: float = 0.05
    """Share of right readings of left-out buildings that are doubted: where the threshold is."""
    folds: int = 6
    seed: int = 0


@dataclass(frozen=True, eq=False)
class HeldOut:
    """
    What models say of buildings they have not seen.

    ``right`` holds (R,) of each trial's rooms, ``wrong (N,)`` is that of each trial.
    """

    right: list[Array]
    wrong: Array


class DoubtNetwork(nn.Module):
    """One member; the same function as in :class:`fpnet_core.drawings.doubt_model.DoubtModel`."""

    def __init__(self, figures: int, width: int) -> None:
        super().__init__()
        self.first = nn.Linear(figures, width)
        self.second = nn.Linear(width, 1)
        self.direct = nn.Linear(figures, 1, bias=False)
        nn.init.zeros_(self.second.weight)
        nn.init.zeros_(self.direct.weight)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return log odds (N,) of standardised figures (N, D)."""
        hidden = nn.functional.silu(self.first(x))
        return torch.as_tensor((self.second(hidden) + self.direct(x)).squeeze(-1))


def fit_doubts(
    trials: Sequence[ReadingTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> tuple[DoubtModel, HeldOut]:
    """
    Fit the model to all trials, its threshold to what was held out, and return both.

    Raises
    ------
    FpnetError
        If there are fewer buildings than folds, or all readings are right or wrong.
    """
    seeds = np.array([trial.seed for trial in trials])
    wrong = np.array([trial.f1 < GOOD_F1 for trial in trials])
    if len(np.unique(seeds)) < config.folds or wrong.all() or not wrong.any():
        raise FpnetError('too few sheets to learn from: it takes right and wrong ones')
    held_out = left_out(trials, config, on_fold)
    tensors = fit_side('room', *_rooms(trials), config)
    tensors |= fit_side('sheet', *_sheets(trials, held_out.right, config), config)
    chosen = np.array([trial.is_chosen for trial in trials])
    level = threshold(held_out.wrong[chosen], wrong[chosen], config.right_doubted)
    return DoubtModel(tensors, level), held_out


def left_out(
    trials: Sequence[ReadingTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> HeldOut:
    """Return what is said of each trial by models that have not seen its building."""
    single = replace(config, members=2)
    fold = _folds(trials, config)
    right = [np.zeros(len(trial.right)) for trial in trials]
    for k in range(config.folds):
        seen = [trials[row] for row in np.flatnonzero(fold != k)]
        model = fit_side('room', *_rooms(seen), single)
        for row in np.flatnonzero(fold == k):
            right[row] = DoubtModel(model, 1.0).right_rooms(trials[row].rooms)
        on_fold(1.0)
    wrong = np.zeros(len(trials))
    figures, target, weight = _sheets(trials, right, config)
    for k in range(config.folds):
        kept = fold != k
        model = fit_side('sheet', figures[kept], target[kept], weight[kept], config)
        wrong[~kept] = DoubtModel(model, 1.0).of_sheets(figures[~kept])
        on_fold(1.0)
    return HeldOut(right, wrong)


def _folds(trials: Sequence[ReadingTrial], config: DoubtTraining) -> NDArray[np.int64]:
    """Return the fold (N,) of each trial; a building is in one of them."""
    _, number = np.unique([trial.seed for trial in trials], return_inverse=True)
    order = np.random.default_rng(config.seed).permutation(int(number.max()) + 1)
    return np.asarray(order[number] % config.folds, dtype=np.int64)


def _rooms(trials: Sequence[ReadingTrial]) -> tuple[Array, Array, Array]:
    """Return figures, truth and weight of all rooms; readings weigh the same."""
    weight = [np.full(len(t.right), 1.0 / max(len(t.right), 1)) for t in trials]
    right = np.concatenate([trial.right for trial in trials]).astype(np.float64)
    return np.concatenate([trial.rooms for trial in trials]), right, np.concatenate(weight)


def _sheets(
    trials: Sequence[ReadingTrial], right: Sequence[Array], config: DoubtTraining
) -> tuple[Array, Array, Array]:
    """Return figures, how wrong and weight of all readings."""
    figures = [
        np.concatenate([trial.whole, room_summary(trial.rooms, each)])
        for trial, each in zip(trials, right, strict=True)
    ]
    f1 = np.array([trial.f1 for trial in trials])
    target = 1.0 / (1.0 + np.exp((f1 - GOOD_F1) / config.f1_blur))
    weight = np.where([trial.is_chosen for trial in trials], 1.0, config.other_weight)
    return np.array(figures), target, weight


def fit_side(
    side: Side, figures: Array, target: Array, weight: Array, config: DoubtTraining
) -> dict[str, NDArray[np.float32]]:
    """
    Fit the networks of one side.

    Parameters
    ----------
    side : rooms or readings
    figures : (N, D), NaN where there is nothing to measure
    target : (N,) probabilities
    weight : (N,)
    config : settings
    """
    if figures.shape[1] != len(SIDES[side]):
        raise FpnetError(f'{side}: {figures.shape[1]} figures, expected {len(SIDES[side])}')
    mean = np.nan_to_num(np.nanmean(figures, axis=0))
    spread = np.nan_to_num(np.nanstd(figures, axis=0)) + _LEAST_SPREAD
    x = np.clip(np.nan_to_num((figures - mean) / spread), -CLIP, CLIP)
    data = tuple(
        torch.from_numpy(v.astype(np.float32)) for v in (x, target, weight / weight.mean())
    )
    decay = config.room_decay if side == 'room' else config.sheet_decay
    states = [_fit_member(data, config, decay, member) for member in range(config.members)]
    found = {'mean': mean, 'spread': spread}
    found |= {name: np.stack([state[name] for state in states]) for name in states[0]}
    return {f'{side}.{name}': np.asarray(v, np.float32) for name, v in found.items()}


def _fit_member(
    data: tuple[torch.Tensor, ...], config: DoubtTraining, decay: float, member: int
) -> dict[str, NDArray[np.float32]]:
    """Return the layers of one network."""
    x, y, weight = data
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed * 1009 + member)
        network = DoubtNetwork(x.shape[1], config.width)
        optimizer = torch.optim.AdamW(
            network.parameters(), lr=config.learning_rate, weight_decay=decay
        )
        batches = -(-len(y) // config.batch_size)
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimizer, config.learning_rate, total_steps=config.epochs * batches
        )
        for _ in range(config.epochs):
            for chosen in torch.split(torch.randperm(len(y)), config.batch_size):
                loss = nn.functional.binary_cross_entropy_with_logits(
                    network(x[chosen]), y[chosen], weight[chosen]
                )
                optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                optimizer.step()
                schedule.step()
    state = {name: value.numpy() for name, value in network.state_dict().items()}
    return {
        'first': state['first.weight'],
        'first_bias': state['first.bias'],
        'second': state['second.weight'][0],
        'second_bias': state['second.bias'][0],
        'direct': state['direct.weight'][0],
    }


def threshold(probability: Array, wrong: Bools, right_doubted: float) -> float:
    """Return the probability (of N,) above which so large a share of the right ones lies."""
    return float(np.quantile(probability[~wrong], 1.0 - right_doubted))


def held_out_figures(
    trials: Sequence[ReadingTrial], held_out: HeldOut, doubted_from: float
) -> dict[str, float]:
    """Return how well chosen readings of left-out buildings are told right or wrong."""
    chosen = np.array([trial.is_chosen for trial in trials])
    wrong = np.array([trial.f1 < GOOD_F1 for trial in trials])[chosen]
    p = held_out.wrong[chosen]
    figures = {
        'readings': float(len(p)),
        'wrong': float(wrong.mean()),
        'auc': area_under(p, wrong),
    }
    for share in (0.03, 0.05, 0.1):
        level = threshold(p, wrong, share)
        figures[f'wrong_doubted_at_{share:g}'] = float(np.mean(p[wrong] > level))
    figures['wrong_doubted'] = float(np.mean(p[wrong] > doubted_from))
    figures['right_doubted'] = float(np.mean(p[~wrong] > doubted_from))
    rooms = np.concatenate([trial.right for trial in trials])
    figures['rooms_auc'] = area_under(1.0 - np.concatenate(held_out.right), ~rooms)
    return figures


def area_under(score: Array, is_so: Bools) -> float:
    """Return how often one that is so scores higher (N,) than one that is not; ties count half."""
    order = np.sort(score[~is_so])
    below = np.searchsorted(order, score[is_so], 'left')
    upto = np.searchsorted(order, score[is_so], 'right')
    return float(np.mean(0.5 * (below + upto)) / max(len(order), 1))


def write_doubts(
    path: Path, model: DoubtModel, config: DoubtTraining, facts: dict[str, Any]
) -> None:
    """Write the model with its manifest; ``facts`` join the manifest."""
    network: dict[str, Any] = {
        'members': config.members,
        'width': config.width,
        'doubted_from': model.doubted_from,
        **{f'{side}_figures': list(figures) for side, figures in SIDES.items()},
    }
    write_weights(
        path,
        model.tensors,
        DOUBT_SCHEMA,
        {'network': network, 'training': asdict(config), **facts},
    )
