# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train matcher``: fit the matching network to generated pairs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import FpnetError
from fpnet_lab.cli import options

if TYPE_CHECKING:
    from fpnet_core.io.weights import Weights
    from fpnet_lab.sim.pairs.dataset import PairDataset
    from fpnet_lab.training import EpochRecord, TrainingConfig


class TrainingPreset(StrEnum):
    """Named configurations of :mod:`fpnet_lab.training.config`."""

    PAPER = 'paper'
    SUPERGLUE = 'superglue'
    FPNET = 'fpnet'


DataOption = Annotated[
    Path, typer.Option('--data', metavar='DIR', help='Pairs from fpnet simulate pairs.')
]
TrainingSetOption = Annotated[
    list[str] | None,
    typer.Option(
        '--set',
        metavar='KEY=VALUE',
        help='Override a training setting, for example network.width=64; repeatable.',
    ),
]
EpochsOption = Annotated[
    int | None, typer.Option('--epochs', min=1, help='Passes over the training pairs.')
]
LimitOption = Annotated[
    int | None, typer.Option('--limit', min=2, help='Use only the first pairs of the folder.')
]
PresetOption = Annotated[
    TrainingPreset,
    typer.Option('--preset', help="Network and losses: ours, the paper's, or its backbone."),
]
InitOption = Annotated[
    Path | None,
    typer.Option('--init', metavar='FILE', help='Start from a checkpoint of equal shape.'),
]
ThreadsOption = Annotated[
    int, typer.Option('--threads', min=1, help='CPU threads; more help on idle cores only.')
]


def command(
    data: DataOption,
    out: options.RunOption,
    preset: PresetOption = TrainingPreset.FPNET,
    epochs: EpochsOption = None,
    limit: LimitOption = None,
    init: InitOption = None,
    settings: TrainingSetOption = None,
    seed: common.SeedOption = None,
    device: common.DeviceOption = 'cpu',
    threads: ThreadsOption = 1,
) -> None:
    """
    Train the matching network and write matcher.safetensors with its manifest.

    Stops early when held-back plans no longer improve; a second run resumes the first.
    Curves: tensorboard --logdir RUN. Several GPUs or machines: torchrun --nproc-per-node 2
    --no-python fpnet train matcher ...

    Example: fpnet train matcher --preset fpnet --data runs/pairs --out runs/train --epochs 20
    """
    common.check_input(data)
    config = _training_config(settings, preset, epochs, seed)
    from fpnet_core.io.weights import read_weights
    from fpnet_core.types import FEATURE_SCHEMA
    from fpnet_lab.sim.pairs.dataset import PairDataset
    from fpnet_lab.training import use_threads

    use_threads(threads)
    initial = read_weights(init, FEATURE_SCHEMA) if init is not None else None
    fit_and_calibrate(PairDataset(data), config, out, device, initial, limit)


def fit_and_calibrate(
    dataset: PairDataset,
    config: TrainingConfig,
    out: Path,
    device: str,
    initial: Weights | None = None,
    limit: int | None = None,
    by_plan: bool = True,
) -> None:
    """Train in ``out``; for an invariant network also fit its evidence model."""
    from fpnet_core.models.config import InvariantConfig
    from fpnet_core.models.inference import network_type
    from fpnet_lab.training import (
        WEIGHTS_FILE,
        Hooks,
        Trainer,
        calibrate,
        load_pairs,
        split_by_pair,
        split_by_plan,
    )

    pairs = load_pairs(dataset, network_type(config.network), limit)
    split = split_by_plan if by_plan else split_by_pair
    training, validation = split(pairs, config.validation_fraction, config.seed)
    if not training:
        raise FpnetError('all pairs share one plan; generate pairs of more plans')
    recipe = {'pairs': len(pairs), **dataset.manifest}
    trainer = Trainer(config, out, device, recipe, initial)
    if trainer.is_first:
        typer.echo(f'{len(training)} pairs to train on, {len(validation)} held back, in {out}')
    remaining = (config.epochs - trainer.next_epoch) * len(training)
    with progress('training', remaining) as advance:
        trainer.fit(training, validation, Hooks(on_pairs=advance, on_epoch=_report))
    if not trainer.is_first:
        return
    if isinstance(config.network, InvariantConfig):
        held_back = (dataset.pair(pair.index) for pair in validation)
        calibrate(out / WEIGHTS_FILE, held_back, out / WEIGHTS_FILE)
    typer.echo(f'lowest validation loss {trainer.best_loss:.3f} in epoch {trainer.best_epoch}')


def _training_config(
    settings: list[str] | None, preset: TrainingPreset, epochs: int | None, seed: int | None
) -> TrainingConfig:
    from fpnet_lab.training.config import parse_training_config

    overrides: dict[str, Any] = common.parse_settings(settings or ())
    if epochs is not None:
        overrides['epochs'] = epochs
    if seed is not None:
        overrides['seed'] = seed
    return parse_training_config(overrides, preset.value)


def _report(record: EpochRecord) -> None:
    typer.echo(
        f'epoch {record.epoch:3d}  loss {record.loss:.3f}  val loss {record.val_loss:.3f}  '
        f'precision {record.val_precision:.3f}  recall {record.val_recall:.3f}  '
        f'F1 {record.val_f1:.3f}'
    )
