# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Training of the parser on drawings generated during training; resumable.

The running mean of the weights computes the first pass's output, which is the context of the
second pass. Both passes form one batch, so that batch normalization has the statistics of use.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
import time
from typing import Any

import torch
from torch import Tensor, nn
from torch.utils.data import DataLoader

from fpnet_core.drawings.parsing.network import (
    CHANNELS,
    CONTEXT,
    PARSER_NAME,
    PARSER_SCHEMA,
    network_from,
)
from fpnet_core.io.pixel_classes import CLASSES
from fpnet_core.io.weights import read_onnx, write_onnx
from fpnet_lab.pool import START_METHOD
from fpnet_lab.training.checkpoint import load_state, save_state
from fpnet_lab.training.optimizer import rate_at
from fpnet_lab.training.parser_held import held_figures
from fpnet_lab.training.parser_network import (
    ParserNetwork,
    ParserNetworkConfig,
    onnx_bytes,
    pooled_scale,
    restored,
    settle,
    unweighted,
)
from fpnet_lab.training.parser_stream import Chunk, ViewStream
from fpnet_lab.training.parser_tones import varied

STATE_FILE = 'last.safetensors'

_MIDDLE, _SPREAD = 0.75, 0.25  # given: as in fpnet_core.drawings.parsing.network
_SETTLING = 10.0  # time constant in steps of the running mean's warm-up; chosen
_SETTLED_ON = 24  # numerical: batches for the statistics of a packaged network's normalizations
_KEPT_CONTEXT = 0.9  # share of second passes that get a context; chosen
_OVERLAY_WEIGHT, _SCALE_WEIGHT = 0.25, 0.08  # weights of losses, that of the classes is 1; chosen


@dataclass(frozen=True)
class ParserTraining:
    """
    Settings of a run.

    ``minutes`` is a time limit to which the learning rate schedule adapts; 0: no limit.
    """

    steps: int = 12_000
    batch_size: int = 8
    chunk: int = 4
    side_px: int = 448
    workers: int = 1
    minutes: float = 0.0
    learning_rate: float = 1e-3
    weight_decay: float = 1e-3
    warmup: float = 0.03
    """Share of the steps with a rising learning rate."""
    class_weights: tuple[float, ...] = (0.8, 1.0, 2.5, 4.0, 3.0)
    """Walls, doors and windows have few but important pixels."""
    averaged: float = 0.997
    """Decay of the running mean of weights per step."""
    is_half: bool = False
    """Compute in half precision on CPUs, too."""
    save_every: int = 250
    seed: int = 0


class ParserTrainer:
    """Training run in a folder, which gets the state and the packaged network."""

    def __init__(
        self, folder: Path, config: ParserTraining, data: Path | None, device: str = 'cpu'
    ) -> None:
        self.folder, self.config, self.data = folder, config, data
        self.device = torch.device(device)
        self.layout = ParserNetworkConfig()
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            network = ParserNetwork(self.layout)
        self.mean = ParserNetwork(self.layout)
        self.mean.load_state_dict(network.state_dict())
        form: Any = {'device': self.device, 'memory_format': torch.channels_last}
        self.network = network.to(**form)
        self.mean = self.mean.to(**form).eval().requires_grad_(False)
        self.both = nn.ModuleDict({'network': self.network, 'mean': self.mean})
        self.optimizer = torch.optim.AdamW(
            self.network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay
        )
        self.step, self.begun = 0, time.monotonic()
        state = folder / STATE_FILE
        if state.is_file():
            self.step = int(load_state(state, self.both, self.optimizer)['step'])
        self.generator = torch.Generator(self.device).manual_seed(config.seed + self.step)

    def run(self, on_saved: Callable[[dict[str, Any]], None] = lambda _: None) -> None:
        """Train to the end and write the state; ``on_saved`` is called with figures on the way."""
        config = self.config
        self.begun = time.monotonic()
        torch.backends.cudnn.benchmark = True
        losses: list[Tensor] = []
        for batch in islice(self._batches(), max(0, config.steps - self.step)):
            losses.append(self._one_step(batch))
            if self.step % config.save_every == 0:
                on_saved(self._saved(losses))
                losses.clear()
            if self._done() >= 1.0:
                break
        on_saved(self._saved(losses))

    def _done(self) -> float:
        """Return the completed share of the run, by steps or by time."""
        steps = self.step / self.config.steps
        if not self.config.minutes:
            return steps
        return max(steps, (time.monotonic() - self.begun) / (60.0 * self.config.minutes))

    def _batches(self) -> Iterator[Chunk]:
        config = self.config
        stream = ViewStream(config.side_px, config.chunk, config.seed, self.step, self.data)
        loader = DataLoader(
            stream,
            batch_size=None,
            num_workers=config.workers,
            prefetch_factor=4,
            multiprocessing_context=START_METHOD,
        )
        chunks = iter(loader)
        while True:
            parts = list(islice(chunks, max(1, config.batch_size // config.chunk)))
            yield Chunk(*(torch.cat(each) for each in zip(*map(_fields, parts), strict=True)))

    def _one_step(self, batch: Chunk) -> Tensor:
        config, done = self.config, self._done()
        for group in self.optimizer.param_groups:
            group['lr'] = rate_at(
                round(done * config.steps), config.steps, config.learning_rate, config.warmup
            )
        seen, theta = self._seen(batch), self._moved(batch.theta)
        self.network.train()
        is_half = config.is_half or self.device.type == 'cuda'
        with torch.autocast(self.device.type, torch.bfloat16, enabled=is_half):
            logits, places = self.network(self._with_context(seen, theta))
        answers, scale = (self._moved(each) for each in (batch.answers, batch.scale))
        loss = self._loss(logits.float(), pooled_scale(places.float()), answers, scale)
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        self.optimizer.step()
        self.step += 1
        self._average()
        return loss.detach()

    def _moved(self, values: Tensor) -> Tensor:
        return values.to(self.device, non_blocking=True)

    def _seen(self, batch: Chunk) -> Tensor:
        """Return normalized views with random tone augmentation."""
        return (varied(self._moved(batch.pixels), self.generator) - _MIDDLE) / _SPREAD

    def _picture(self, batch: Chunk) -> Tensor:
        """Return the network's input (2 B, CHANNELS, S, S) of ``B`` pairs of views."""
        return self._with_context(self._seen(batch), self._moved(batch.theta))

    def _with_context(self, seen: Tensor, theta: Tensor) -> Tensor:
        """Return the input (2 B, CHANNELS, S, S): first views, then second ones with context."""
        first, second = seen[:, 0], seen[:, 1]
        empty = torch.zeros_like(first[:, :1]).expand(-1, CONTEXT, -1, -1)
        plain = torch.cat([first, empty], dim=1).contiguous(memory_format=torch.channels_last)
        with torch.no_grad():
            answer = self.mean(plain)[0][:, : len(CLASSES)].float().softmax(dim=1)
            known = torch.cat([answer, torch.ones_like(answer[:, :1])], dim=1)
            grid = nn.functional.affine_grid(theta.float(), list(known.shape), align_corners=False)
            context = nn.functional.grid_sample(known, grid, align_corners=False)
            kept = torch.rand((len(seen), 1, 1, 1), generator=self.generator, device=self.device)
            context = context * (kept < _KEPT_CONTEXT)
        finer = torch.cat([second, context], dim=1)
        both = torch.cat([plain, finer])
        assert both.shape[1] == CHANNELS
        return both.contiguous(memory_format=torch.channels_last)

    def _loss(self, logits: Tensor, scale: Tensor, answers: Tensor, true: Tensor) -> Tensor:
        flat = answers.transpose(0, 1).flatten(0, 1)  # all first views, then all second ones
        weight = torch.tensor(self.config.class_weights, device=self.device)
        count = len(CLASSES)
        classes = nn.functional.cross_entropy(
            logits[:, :count], (flat & 0b111).long(), weight=weight
        )
        bits = torch.stack([(flat >> 3) & 1, (flat >> 4) & 1], dim=1).float()
        overlays = nn.functional.binary_cross_entropy_with_logits(logits[:, count:], bits)
        wanted = true.transpose(0, 1).flatten(0, 1)
        known = wanted.sum(dim=1).clamp(max=1.0)
        each = -(wanted * scale.log_softmax(dim=1)).sum(dim=1)
        scales = (each * known).sum() / known.sum().clamp(min=1.0)
        return classes + _OVERLAY_WEIGHT * overlays + _SCALE_WEIGHT * scales

    @torch.no_grad()
    def _average(self) -> None:
        """Update the running mean of weights and of batch normalization statistics."""
        kept = min(self.config.averaged, self.step / (self.step + _SETTLING))
        now = self.network.state_dict()
        for name, value in self.mean.state_dict().items():
            if value.is_floating_point():
                value.lerp_(now[name], 1.0 - kept)
            else:
                value.copy_(now[name])

    def _saved(self, losses: list[Tensor]) -> dict[str, Any]:
        """Write the state and return figures; the loss is None if no step was made."""
        self.folder.mkdir(parents=True, exist_ok=True)
        save_state(self.folder / STATE_FILE, self.both, self.optimizer, {'step': self.step})
        loss = round(float(torch.stack(losses).mean()), 4) if losses else None
        seconds = round(time.monotonic() - self.begun)
        return {'step': self.step, 'loss': loss, 'seconds': seconds}

    def start_from(self, path: Path | None) -> None:
        """
        Start from a packaged network: the one at ``path``, or the default.

        Raises
        ------
        WeightsError
            If the file is unusable.
        """
        data, _ = read_onnx(path, PARSER_SCHEMA, PARSER_NAME)
        restored(data, self.mean, self.config.class_weights)
        settle(self.mean, (self._picture(batch) for batch in islice(self._batches(), _SETTLED_ON)))
        self.network.load_state_dict(self.mean.state_dict())

    def write(self, facts: dict[str, Any], held: int) -> Path:
        """
        Write the running mean as the packaged network, with its manifest.

        The manifest includes ``facts`` and figures on ``held`` sheets of each kind.
        """
        network = ParserNetwork(self.layout)
        state = {name: value.cpu() for name, value in self.mean.state_dict().items()}
        network.load_state_dict(unweighted(state, self.config.class_weights))
        data = onnx_bytes(network)
        made = {
            'network': asdict(self.layout) | {'classes': list(CLASSES)},
            'training': asdict(self.config) | {'steps_made': self.step},
            **facts,
        }
        made['figures'] = {'iou': held_figures(network_from(data, made), held)}
        path = self.folder / PARSER_NAME
        write_onnx(path, data, PARSER_SCHEMA, made)
        return path


def _fields(chunk: Chunk) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    return chunk.pixels, chunk.answers, chunk.theta, chunk.scale
