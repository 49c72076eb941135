# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fit of the door model: whether the pieces on both sides of a dividing line are in one true room.

Training shows lines in their initial state, during random growth of true rooms, with all rooms
complete, and after merges by the previous round's model, which include errors. The weight of a
line is the cost of an error there; real buildings weigh more than generated ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import torch
from torch import nn

from fpnet_core.segmentation.agreement import SAME_ROOM_IOU
from fpnet_core.segmentation.door_model import DOOR_SCHEMA, FIGURES, DoorModel
from fpnet_core.segmentation.joining import figures_now, join_pieces, joining_stages
from fpnet_core.segmentation.rooms import MIN_ROOM_AREA_M2
from fpnet_core.small_networks import standardised
from fpnet_lab.training.door_samples import DoorSample
from fpnet_lab.training.members import MemberTraining, fit_member, stacked_layers, write_members

Array = NDArray[np.float64]
Target = NDArray[np.int64]

# Chosen, not measured:
_LEAST_SHARE = 0.5  # least share of a piece in one true room; other pieces are not used
_LEAST_M2 = 0.1  # least area of a piece in one true room
_COST_M2 = (0.15, 8.0)  # range of the smaller piece's area in which the cost of an error grows
_NOISE_M2 = 0.25  # smaller true rooms are label noise
_LEAST_SPREAD = 0.01  # numerical: of an almost constant feature


@dataclass(frozen=True)
class DoorTraining(MemberTraining):
    """Settings of a fit, chosen by cross-validation on the development split."""

    members: int = 4
    width: int = 48
    epochs: int = 12
    batch_size: int = 512
    learning_rate: float = 4e-3
    weight_decay: float = 2e-2
    noise: float = 0.1
    """Standard deviation of the noise on standardised features."""
    real_weight: float = 960.0
    """Total weight of the lines of a real building over all its maps; relative to error costs."""
    orders: int = 2
    """Number of random orders in which true rooms grow, each stopped at a random time."""
    rounds: int = 2
    """Number of fits; all except the first see the merges of the previous model."""
    folds: int = 4
    """Number of groups of real buildings to leave out together."""


class DoorNetwork(nn.Module):
    """One ensemble member; see :class:`DoorModel`."""

    def __init__(self, width: int, dropout: float) -> None:
        super().__init__()
        self.first = nn.Linear(len(FIGURES), width)
        self.second = nn.Linear(width, width)
        self.out = nn.Linear(width, 1)
        self._dropout = nn.Dropout(dropout)

    def forward(self, figures: torch.Tensor) -> torch.Tensor:
        """Return log odds (L,) of one room, for standardised features (L, D)."""
        hidden = self._dropout(nn.functional.silu(self.first(figures)))
        hidden = self._dropout(nn.functional.silu(self.second(hidden)))
        return torch.as_tensor(self.out(hidden)[:, 0])


@dataclass(frozen=True, eq=False)
class Shown:
    """Lines: features (L, D), whether they are inside one room (L,), cost of an error (L,)."""

    figures: Array
    is_one: NDArray[np.bool_]
    cost: Array


def lines_shown(sample: DoorSample, target: Target) -> Shown:
    """Return the lines that remain after pieces are merged into ``target (P,)``."""
    pair = target[sample.lines.pieces]
    live = np.flatnonzero(pair[:, 0] != pair[:, 1])
    pair, now = pair[live], sample.pieces.joined(target)
    overlap = np.zeros_like(sample.overlap)
    np.add.at(overlap, target, sample.overlap)
    room, inside = _true_room(overlap)
    share = inside / np.maximum(overlap.sum(axis=1), _LEAST_M2)
    is_known = (inside[pair] > _LEAST_M2).all(axis=1) & (share[pair] > _LEAST_SHARE).all(axis=1)
    smaller = np.clip(now.moments[pair, 0].min(axis=1), *_COST_M2)
    cost = np.sqrt(smaller) * share[pair].min(axis=1)
    figures = figures_now(now, pair, sample.lines, live)
    is_one = room[pair[:, 0]] == room[pair[:, 1]]
    return Shown(figures[is_known], is_one[is_known], cost[is_known])


def _true_room(overlap: Array) -> tuple[NDArray[np.int64], Array]:
    """Return the true room (P,) with the largest overlap of each piece, and the overlap [m2]."""
    rooms = np.pad(overlap[:, 1:], ((0, 0), (0, 1)))
    return rooms.argmax(axis=1), rooms.max(axis=1)


def _states(
    sample: DoorSample, model: DoorModel | None, config: DoorTraining, rng: np.random.Generator
) -> Iterator[Target]:
    """Yield merge states: no merges, part of or all true rooms, and merges by the model."""
    count = len(sample.pieces.peak)
    yield np.arange(count)
    room, inside = _true_room(sample.overlap)
    pair = sample.lines.pieces
    is_same = (room[pair[:, 0]] == room[pair[:, 1]]) & (inside[pair] > _LEAST_M2).all(axis=1)
    same = np.flatnonzero(is_same)
    for order in range(config.orders + 1):
        share = rng.random() if order < config.orders else 1.0
        yield _joined(pair[rng.permutation(same)[: int(share * len(same))]], count)
    if model is not None:
        is_one = model.probability_of_one_room
        stages = list(joining_stages(sample.pieces, sample.lines, is_one))
        if stages:
            yield stages[-1]
            yield stages[int(rng.integers(len(stages)))]


def _joined(pairs: NDArray[np.int64], count: int) -> Target:
    """Return the targets of pieces (count,) after merging ``pairs (K, 2)``."""
    target = np.arange(count)
    for a, b in pairs.tolist():
        target[target == target[b]] = target[a]
    return target


def fit_doors(samples: Sequence[DoorSample], config: DoorTraining) -> DoorModel:
    """Fit the model; the same samples and settings give the same model."""
    model: DoorModel | None = None
    for number in range(config.rounds):
        shown = _shown(samples, model, config, np.random.default_rng([config.seed, number]))
        model = _fitted(shown, config)
    assert model is not None, 'rounds is at least one'
    return model


def _shown(
    samples: Sequence[DoorSample],
    model: DoorModel | None,
    config: DoorTraining,
    rng: np.random.Generator,
) -> Shown:
    """Return the weighted lines of all states of all samples."""
    maps = Counter(sample.building for sample in samples)
    found: list[Shown] = []
    for sample in samples:
        states = [lines_shown(sample, state) for state in _states(sample, model, config, rng)]
        total = sum(float(state.cost.sum()) for state in states)
        if total == 0.0:
            continue
        # Maps of a real building have equal weight whatever their size.
        real = config.real_weight / maps[sample.building] / total
        weight = real if sample.is_real else 1.0
        found += [replace(state, cost=weight * state.cost) for state in states]
    return Shown(*(np.concatenate([getattr(s, name) for s in found]) for name in vars(found[0])))


def _fitted(shown: Shown, config: DoorTraining) -> DoorModel:
    mean = np.average(shown.figures, axis=0, weights=shown.cost)
    variance = np.average((shown.figures - mean) ** 2, axis=0, weights=shown.cost)
    spread = np.sqrt(variance) + _LEAST_SPREAD
    x = standardised(shown.figures, mean, spread)
    y, weight = shown.is_one.astype(np.float64), shown.cost / shown.cost.mean()
    data = tuple(torch.from_numpy(np.asarray(v, np.float32)) for v in (x, y, weight))
    networks = [_fit_member(data, config, member) for member in range(config.members)]
    found = {'mean': mean, 'spread': spread, **stacked_layers(networks)}
    return DoorModel({name: np.asarray(value, np.float32) for name, value in found.items()})


def _fit_member(data: tuple[torch.Tensor, ...], config: DoorTraining, member: int) -> DoorNetwork:
    x, y, weight = data

    def loss_of(network: DoorNetwork, chosen: torch.Tensor) -> torch.Tensor:
        seen = x[chosen] + config.noise * torch.randn(len(chosen), x.shape[1])
        loss = nn.functional.binary_cross_entropy_with_logits(
            network(seen), y[chosen], reduction='none'
        )
        return (weight[chosen] * loss).mean()

    return fit_member(
        lambda: DoorNetwork(config.width, config.dropout), loss_of, len(y), config, member
    )


def room_f1(sample: DoorSample, model: DoorModel) -> float:
    """
    Return the F1 of rooms with intersection over union above one half, by areas of pieces.

    True rooms are restricted to their parts within pieces.
    """
    target = join_pieces(sample.pieces, sample.lines, model.probability_of_one_room)
    overlap = np.zeros_like(sample.overlap)
    np.add.at(overlap, target, sample.overlap)
    found = overlap[overlap.sum(axis=1) >= MIN_ROOM_AREA_M2]
    whole = sample.overlap.sum(axis=0)
    is_room = whole > _NOISE_M2
    is_room[0] = False
    if not is_room.any() or not len(found):
        return 0.0
    both = found[:, is_room]
    iou = both / (whole[is_room] + found.sum(axis=1)[:, None] - both)
    return float(2.0 * (iou > SAME_ROOM_IOU).sum() / (is_room.sum() + len(found)))


def held_back_figures(
    samples: Sequence[DoorSample],
    config: DoorTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> dict[str, dict[str, float]]:
    """Return the mean F1 by kind of map, by models fitted without the map's building."""
    scores: dict[str, list[float]] = {}
    for fold in folds(samples, config.folds):
        rest = [sample for sample in samples if sample.building not in fold]
        model = fit_doors(rest, replace(config, members=1))
        for sample in samples:
            if sample.building in fold:
                scores.setdefault(sample.kind, []).append(room_f1(sample, model))
        on_fold(1.0)
    return {
        kind: {'maps': float(len(values)), 'f1': float(np.mean(values))}
        for kind, values in sorted(scores.items())
    }


def folds(samples: Sequence[DoorSample], count: int) -> list[set[str]]:
    """Return buildings to leave out together: real and generated ones, in equally many folds."""
    real = sorted({sample.building for sample in samples if sample.is_real})
    rest = sorted({sample.building for sample in samples} - set(real))
    return [{*real[k::count], *rest[k::count]} for k in range(count)]


def write_doors(path: Path, model: DoorModel, config: DoorTraining, facts: dict[str, Any]) -> None:
    """Write the model with its manifest; ``facts`` join the manifest."""
    write_members(path, model.tensors, DOOR_SCHEMA, config, facts, figures=FIGURES)
