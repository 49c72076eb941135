# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Training loop: warm-up and cosine schedule, early stopping on held-back plans, resumable.

Under ``torchrun``, processes share every epoch's batches and average their gradients; all of them
validate, and the first one writes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
import csv
from dataclasses import asdict, dataclass, fields
import json
import logging
import math
import os
from pathlib import Path
from typing import Any

from lightning_fabric import Fabric
from lightning_fabric.loggers.tensorboard import TensorBoardLogger
import numpy as np
import torch
from torch import Tensor, nn

from fpnet_core.errors import ConfigError
from fpnet_core.io.weights import Weights, write_weights
from fpnet_core.matching import mutual_pairs
from fpnet_core.models.config import PaperConfig
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.metrics import MatchCounts, count_matches
from fpnet_lab.training.checkpoint import load_state, save_state
from fpnet_lab.training.config import TrainingConfig
from fpnet_lab.training.data import PairArrays, PairBatch, Share, collate, training_batches
from fpnet_lab.training.losses import LossTerms, matching_loss, supervised_loss
from fpnet_lab.training.networks.invariant import InvariantModule
from fpnet_lab.training.networks.modules import RegionModule, load_tensors
from fpnet_lab.training.networks.paper import PaperModule
from fpnet_lab.training.optimizer import make_optimizer, rate_at

logger = logging.getLogger(__name__)

WEIGHTS_FILE, STATE_FILE = 'matcher.safetensors', 'last.safetensors'
CURVES_FILE, CURVES_FOLDER = 'curves.csv', 'tensorboard'
CONFIG_FILE = 'training.json'


@dataclass(frozen=True)
class EpochRecord:
    """One row of the curves: mean losses, and validation figures at the match threshold."""

    epoch: int
    learning_rate: float
    loss: float
    match: float
    topology: float
    spatial: float
    val_loss: float
    val_precision: float
    val_recall: float
    val_f1: float


@dataclass(frozen=True)
class Hooks:
    """Callbacks: after every step (number of pairs) and after every epoch."""

    on_pairs: Callable[[float], None] = lambda count: None
    on_epoch: Callable[[EpochRecord], None] = lambda record: None


def seeded_network(config: TrainingConfig) -> RegionModule:
    """Return a network initialized from the run's seed; torch's global state is unchanged."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        sizes = config.network
        return PaperModule(sizes) if isinstance(sizes, PaperConfig) else InvariantModule(sizes)


class Trainer:
    """
    One run in the folder ``out``.

    Writes ``training.json`` (configuration), ``curves.csv`` and ``tensorboard/``,
    ``last.safetensors`` (state) and, whenever the validation loss decreases, the matcher's weights
    ``matcher.safetensors`` with their manifest. A folder with a state is resumed.

    Parameters
    ----------
    config : the run's settings
    out : the run's folder
    device : ``cpu``, ``cuda`` or ``cuda:N``
    recipe : description of the data, for the manifest
    initial : weights to start from instead of random ones

    Raises
    ------
    ConfigError
        If ``out`` holds a run with another configuration, or the device does not exist.
    WeightsError
        If ``initial`` or the state in ``out`` do not fit the network.
    """

    def __init__(
        self,
        config: TrainingConfig,
        out: Path,
        device: str = 'cpu',
        recipe: dict[str, Any] | None = None,
        initial: Weights | None = None,
    ) -> None:
        self.config, self.out, self.recipe = config, out, dict(recipe or {})
        self.fabric = make_fabric(device, out)
        network = seeded_network(config)
        if initial is not None:
            load_tensors(network, initial)
            self.recipe['initial_sha256'] = initial.manifest['sha256']
        optimizer = make_optimizer(network, config)
        self.next_epoch, self.best_loss, self.best_epoch = 0, math.inf, -1
        out.mkdir(parents=True, exist_ok=True)
        if self.is_first:
            self._claim_folder()
        self.fabric.barrier()
        if (out / STATE_FILE).exists():
            self._resume(network, optimizer)
        self.bare_network = network
        self.network, self.optimizer = self.fabric.setup(network, optimizer)
        self.network.mark_forward_method('assignments')

    @property
    def is_first(self) -> bool:
        """Return whether this process writes and reports; always True for a single process."""
        return bool(self.fabric.is_global_zero)

    def fit(
        self,
        training: Sequence[PairArrays],
        validation: Sequence[PairArrays],
        hooks: Hooks | None = None,
    ) -> None:
        """Train until the last epoch, or until ``patience`` epochs without improvement."""
        hooks = hooks or Hooks()
        while self.next_epoch < self.config.epochs:
            if self.next_epoch - self.best_epoch > self.config.patience:
                logger.info('no lower validation loss since epoch %d', self.best_epoch)
                return
            record = self._epoch(training, validation, hooks)
            self._keep(record)
            if self.is_first:
                hooks.on_epoch(record)

    def _epoch(
        self, training: Sequence[PairArrays], validation: Sequence[PairArrays], hooks: Hooks
    ) -> EpochRecord:
        epoch, config = self.next_epoch, self.config
        share = Share(self.fabric.global_rank, self.fabric.world_size)
        steps_per_epoch = share.of(math.ceil(len(training) / config.batch_size))
        # One random stream per epoch: a resumed run gets the batches of an uninterrupted one.
        stream = [config.seed, epoch]
        batches = training_batches(
            training,
            self.bare_network.network.layout,
            config.batch_size,
            config.augmentation,
            stream,
            share,
        )
        sums, seen, rate = torch.zeros(4), 0, 0.0
        steps = steps_per_epoch * config.epochs
        self.network.train()
        for index, batch in enumerate(batches):
            step = epoch * steps_per_epoch + index
            rate = rate_at(step, steps, config.learning_rate, config.warmup_fraction)
            terms = self._step(batch.to(self.fabric.device), rate)
            sums += stack_terms(terms) * len(batch.labels)
            seen += len(batch.labels)
            hooks.on_pairs(float(len(batch.labels) * share.count))
        loss, match, topology, spatial = (sums / max(1, seen)).tolist()
        val_loss, counts = validate(self.network, validation, config, self.fabric.device)
        return EpochRecord(
            epoch=epoch,
            learning_rate=rate,
            loss=loss,
            match=match,
            topology=topology,
            spatial=spatial,
            val_loss=val_loss,
            val_precision=counts.precision,
            val_recall=counts.recall,
            val_f1=counts.f1,
        )

    def _step(self, batch: PairBatch, rate: float) -> LossTerms:
        for group in self.optimizer.param_groups:
            group['lr'] = rate
        outputs = self.network.assignments(batch.plan, batch.sub)
        terms = supervised_loss(outputs, batch.labels, batch.plan, self.config.loss)
        self.optimizer.zero_grad(set_to_none=True)
        self.fabric.backward(terms.total)
        self.fabric.clip_gradients(self.network, self.optimizer, max_norm=self.config.clip_norm)
        self.optimizer.step()
        return terms

    def _keep(self, record: EpochRecord) -> None:
        is_best = record.val_loss < self.best_loss
        if is_best:
            self.best_loss, self.best_epoch = record.val_loss, record.epoch
        self.next_epoch = record.epoch + 1
        if self.is_first:
            self._write(record, is_best)
        self.fabric.barrier()

    def _write(self, record: EpochRecord, is_best: bool) -> None:
        if is_best:
            self._write_weights(record)
        scalars = {
            'next_epoch': self.next_epoch,
            'best_loss': self.best_loss,
            'best_epoch': self.best_epoch,
        }
        append_curve(self.out / CURVES_FILE, record)
        self.fabric.log_dict(asdict(record), step=record.epoch)
        save_state(self.out / STATE_FILE, self.bare_network, self.optimizer, scalars)

    def _write_weights(self, record: EpochRecord) -> None:
        state = self.bare_network.state_dict()
        facts = {
            'network': self.config.network.model_dump(mode='json'),
            'training': {
                'config': self.config.model_dump(mode='json', exclude={'network'}),
                'data': self.recipe,
                'versions': {'torch': torch.__version__, 'numpy': np.__version__},
            },
            'figures': {'validation': asdict(record)},
        }
        tensors = {key: value.detach().cpu().numpy() for key, value in state.items()}
        write_weights(self.out / WEIGHTS_FILE, tensors, FEATURE_SCHEMA, facts)

    def _claim_folder(self) -> None:
        path = self.out / CONFIG_FILE
        text = json.dumps(self.config.model_dump(mode='json'), indent=1) + '\n'
        if path.exists() and path.read_text(encoding='utf-8') != text:
            raise ConfigError(
                f'{self.out} holds a run with other settings ({CONFIG_FILE} differs); '
                'choose another --out, or the same settings to continue it'
            )
        path.write_text(text, encoding='utf-8')

    def _resume(self, network: nn.Module, optimizer: torch.optim.Optimizer) -> None:
        scalars = load_state(self.out / STATE_FILE, network, optimizer)
        self.next_epoch = int(scalars['next_epoch'])
        self.best_loss = float(scalars['best_loss'])
        self.best_epoch = int(scalars['best_epoch'])
        logger.info('continuing %s at epoch %d', self.out, self.next_epoch)


def use_threads(count: int) -> None:
    """Set the number of CPU threads for tensor operations of this process."""
    torch.set_num_threads(count)


def make_fabric(device: str, out: Path) -> Fabric:
    """
    Return an engine for ``cpu``, ``cuda`` or ``cuda:N`` that logs TensorBoard curves to ``out``.

    Under ``torchrun`` it spans all processes, one GPU each.

    Raises
    ------
    ConfigError
        If the device is unknown or missing.
    """
    kind, _, index = device.partition(':')
    if kind not in ('cpu', 'cuda') or (index and not (kind == 'cuda' and index.isdigit())):
        raise ConfigError(f'device {device!r}: expected cpu, cuda or cuda:N')
    if kind == 'cuda' and int(index or 0) >= torch.cuda.device_count():
        raise ConfigError(f'device {device!r} does not exist; use --device cpu')
    curves = TensorBoardLogger(out, name=CURVES_FOLDER, version='')
    local, total = (int(os.environ.get(f'{name}WORLD_SIZE', '1')) for name in ('LOCAL_', ''))
    if total > 1:
        fabric = Fabric(
            accelerator=kind,
            devices=local,
            num_nodes=total // local,
            strategy='ddp',
            loggers=curves,
        )
    else:
        devices: list[int] | int = [int(index)] if index else 1
        fabric = Fabric(accelerator=kind, devices=devices, loggers=curves)
    fabric.launch()
    return fabric


@torch.inference_mode()
def validate(
    network: nn.Module,
    pairs: Sequence[PairArrays],
    config: TrainingConfig,
    device: torch.device,
) -> tuple[float, MatchCounts]:
    """Return the mean loss and pooled match counts over unaugmented pairs."""
    network.eval()
    loss, counts = 0.0, MatchCounts(0, 0, 0)
    for start in range(0, len(pairs), config.batch_size):
        chunk = pairs[start : start + config.batch_size]
        batch = collate(chunk).to(device)
        log_assignment: Tensor = network(batch.plan, batch.sub)
        terms = matching_loss(log_assignment, batch.labels, batch.plan, config.loss)
        loss += float(terms.total) * len(chunk)
        assignment = log_assignment[:, :-1, :-1].exp().cpu().numpy()
        for pair, scores in zip(chunk, assignment, strict=True):
            real = scores[: len(pair.plan_feat), : len(pair.sub_feat)]
            matches = mutual_pairs(real, config.match_threshold)
            counts = counts + count_matches(matches, pair.labels)
    return loss / max(1, len(pairs)), counts


def stack_terms(terms: LossTerms) -> Tensor:
    """Return total, match, topology and spatial loss ``(4,)`` without gradients."""
    parts = (terms.total, terms.match, terms.topology, terms.spatial)
    return torch.stack([part.detach().cpu() for part in parts])


def append_curve(path: Path, record: EpochRecord) -> None:
    """Append one row to the CSV, with a header if the file is new."""
    new = not path.exists()
    with path.open('a', newline='', encoding='utf-8') as file:
        writer = csv.DictWriter(file, [field.name for field in fields(EpochRecord)])
        if new:
            writer.writeheader()
        writer.writerow(asdict(record))
