# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Training of the network that reads walls: steps on varied patches, resumable."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
import torch
from torch import Tensor, nn
from torch.utils.data import DataLoader, IterableDataset

from fpnet_core.drawings.pictures.learned import BUILDING_PX, WALL_PX
from fpnet_core.io.pixel_classes import CLASSES
from fpnet_core.io.weights import write_weights
from fpnet_core.models.walls import (
    PIXELS_PER_ANSWER,
    WALLS_SCHEMA,
    WallNetwork,
    WallNetworkConfig,
    classify,
)
from fpnet_lab.pool import START_METHOD
from fpnet_lab.training.checkpoint import load_state, save_state
from fpnet_lab.training.optimizer import rate_at
from fpnet_lab.training.wall_patches import patches
from fpnet_lab.training.wall_samples import WallSample, read_sample, resized, sample_stems

WEIGHTS_FILE, STATE_FILE = 'walls.safetensors', 'last.safetensors'

HELD_SHEETS = 60
"""Generated drawings to measure on, of all kinds together. Chosen."""

_SETTLING = 10.0  # steps after which the running mean forgets slowly; chosen


@dataclass(frozen=True)
class WallTraining:
    """Settings of a run."""

    steps: int = 7200
    batch_size: int = 8
    side_px: int = 448
    learning_rate: float = 3e-3
    weight_decay: float = 1e-4
    warmup: float = 0.04
    """Share of the steps."""
    class_weights: tuple[float, ...] = (0.7, 1.0, 3.0, 6.0, 5.0)
    """Walls, doors and windows are few pixels that decide much."""
    averaged: float = 0.998
    """Of the running mean of weights that is kept is kept by each step."""
    save_every: int = 300
    seed: int = 0


class _Patches(IterableDataset[tuple[Tensor, Tensor]]):
    """Patches from a step on; each step has its own random numbers."""

    def __init__(self, stems: list[Path], config: WallTraining, step: int) -> None:
        self.stems, self.config, self.step = stems, config, step

    def __iter__(self) -> Iterator[tuple[Tensor, Tensor]]:
        cv2.setNumThreads(1)
        rng = np.random.default_rng([self.config.seed, self.step])
        for pixels, classes in patches(self.stems, self.config.side_px, rng):
            picture = torch.from_numpy(pixels).permute(2, 0, 1)
            yield picture, torch.from_numpy(classes)


class WallTrainer:
    """
    A run in a folder.

    ``folder`` holds ``samples`` as :func:`gather_samples` writes them, and gets the state and
    the weights, which are a running mean over the steps.
    """

    def __init__(self, folder: Path, network: WallNetworkConfig, config: WallTraining) -> None:
        self.folder, self.network_config, self.config = folder, network, config
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            self.network = WallNetwork(network).to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.mean = WallNetwork(network)
        self.mean.load_state_dict(self.network.state_dict())
        self.both = nn.ModuleDict({'network': self.network, 'mean': self.mean})
        self.optimizer = torch.optim.AdamW(
            self.network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay
        )
        self.step = 0
        state = folder / STATE_FILE
        if state.is_file():
            self.step = int(load_state(state, self.both, self.optimizer)['step'])

    def run(
        self,
        facts: dict[str, Any],
        on_step: Callable[[float], None] = lambda _: None,
        on_saved: Callable[[dict[str, Any]], None] = lambda _: None,
    ) -> None:
        """
        Train to the end and write the weights.

        ``facts`` join the manifest; ``on_saved`` is told figures whenever weights are written.
        """
        config = self.config
        left = max(0, config.steps - self.step)
        stems = sample_stems(self.folder / 'samples', 'train')
        data = _Patches(stems, config, self.step)
        loader = DataLoader(
            data,
            config.batch_size,
            num_workers=1,
            prefetch_factor=4,
            multiprocessing_context=START_METHOD,
        )
        weight = torch.tensor(config.class_weights)
        losses: list[float] = []
        for picture, classes in islice(loader, left):
            losses.append(self._one_step(picture, classes.long(), weight))
            on_step(1.0)
            if self.step % config.save_every == 0 and self.step < config.steps:
                on_saved(self._saved(losses, facts))
                losses.clear()
        on_saved(self._saved(losses, facts))

    def _one_step(self, picture: Tensor, classes: Tensor, weight: Tensor) -> float:
        self.network.train()
        config = self.config
        for group in self.optimizer.param_groups:
            group['lr'] = rate_at(self.step, config.steps, config.learning_rate, config.warmup)
        seen = picture.float().div_(255.0).contiguous(memory_format=torch.channels_last)
        loss = nn.functional.cross_entropy(self.network(seen), classes, weight=weight)
        self.optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        self.optimizer.step()
        self.step += 1
        self._average()
        return float(loss.detach())

    def _average(self) -> None:
        """Move the mean towards the weights, and towards what the batch norms have counted."""
        kept = min(self.config.averaged, self.step / (self.step + _SETTLING))
        now = self.network.state_dict()
        for name, value in self.mean.state_dict().items():
            if value.is_floating_point():
                value.lerp_(now[name], 1.0 - kept)
            else:
                value.copy_(now[name])

    def _saved(self, losses: list[float], facts: dict[str, Any]) -> dict[str, Any]:
        """Write state and weights and return figures; there is no loss where no step was made."""
        save_state(self.folder / STATE_FILE, self.both, self.optimizer, {'step': self.step})
        stems = sample_stems(self.folder / 'samples', 'held')
        found = held_figures(unweighted(self.mean, self.config.class_weights), stems)
        loss = round(float(np.mean(losses)), 4) if losses else None
        figures = {'step': self.step, 'loss': loss} | found
        self.write(facts | {'figures': figures})
        return figures

    def write(self, facts: dict[str, Any]) -> None:
        """Write the mean's weights, at half precision, with ``facts`` in the manifest."""
        state = unweighted(self.mean, self.config.class_weights).state_dict()
        tensors = {name: _stored(value) for name, value in state.items()}
        network = asdict(self.network_config) | {'classes': list(CLASSES)}
        write_weights(
            self.folder / WEIGHTS_FILE,
            tensors,
            WALLS_SCHEMA,
            {'network': network, 'training': asdict(self.config), **facts},
        )


def unweighted(network: WallNetwork, class_weights: tuple[float, ...]) -> WallNetwork:
    """Return a copy whose probabilities are those of pixels that weigh the same."""
    copy = deepcopy(network)
    each = torch.tensor(class_weights).log().repeat_interleave(PIXELS_PER_ANSWER)
    bias = copy.head.bias
    assert bias is not None
    with torch.no_grad():
        bias -= each
    return copy


def _stored(value: Tensor) -> NDArray[Any]:
    """Return a tensor as it is stored: floating point numbers at half precision."""
    return np.asarray((value.half() if value.is_floating_point() else value).numpy())


def held_figures(network: WallNetwork, stems: list[Path]) -> dict[str, Any]:
    """Return the intersection over union of each class on held-back drawings, by kind and all."""
    network.eval()
    counts: dict[str, NDArray[np.int64]] = {}
    for stem in stems:
        sample = _at_size(read_sample(stem))
        found = classify(network, sample.pixels).argmax(axis=0)
        pairs = len(CLASSES) * sample.classes.ravel().astype(np.int64) + found.ravel()
        table = np.bincount(pairs, minlength=len(CLASSES) ** 2).reshape(2 * [len(CLASSES)])
        for name in (stem.name.partition('-')[0], 'all'):
            counts[name] = counts.get(name, np.zeros_like(table)) + table
    return {'iou': {name: _overlaps(table) for name, table in sorted(counts.items())}}


def _overlaps(table: NDArray[np.int64]) -> dict[str, float]:
    both = np.diag(table)
    either = table.sum(axis=0) + table.sum(axis=1) - both
    shares = both / np.maximum(either, 1)
    return {name: round(float(share), 4) for name, share in zip(CLASSES, shares, strict=True)}


def _at_size(sample: WallSample) -> WallSample:
    """Return a sample as large as the reader's finer look would be."""
    wanted = sample.building_px * WALL_PX / max(sample.wall_px, 1.0)
    factor = min(1.0, float(np.clip(wanted, *BUILDING_PX)) / sample.building_px)
    height, width = sample.classes.shape
    return resized(sample, (max(1, round(factor * width)), max(1, round(factor * height))))
