# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train finetune``: adapt the packaged network to one building."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli.train_matcher import fit_and_calibrate


@common.reads_drawing
def command(
    plan: Annotated[Path, typer.Option('--floorplan', metavar='FILE', help=common.DRAWING_HELP)],
    out: Annotated[Path, typer.Option('--out', metavar='DIR', help='Folder of pairs and run.')],
    said: common.DrawingOptions,
    count: Annotated[
        int, typer.Option('--count', min=20, help='Robot maps to simulate in the building.')
    ] = 800,
    epochs: Annotated[int, typer.Option('--epochs', min=1, help='Passes over the pairs.')] = 4,
    seed: common.SeedOption = 0,
    device: common.DeviceOption = 'cpu',
) -> None:
    """
    Simulate robot maps in one building and train the packaged network on them.

    Use the result with --set matcher.weights=OUT/run/matcher.safetensors.

    Example: fpnet train finetune --floorplan my_plan.png --out runs/mine
    """
    reading = said.read(plan, common.load(None))
    common.say_reading(reading, None)
    from fpnet_core.io.weights import read_weights
    from fpnet_core.types import FEATURE_SCHEMA
    from fpnet_lab.sim.pairs.dataset import PairDataset
    from fpnet_lab.sim.pairs.presets import preset
    from fpnet_lab.sim.pairs.writing import write_pairs
    from fpnet_lab.sim.plans.sources import GivenPlans
    from fpnet_lab.training import parse_training_config

    config = preset('default').config
    source = GivenPlans([(plan.stem, reading.grid)], config.segmentation)
    with progress('pairs', total=count) as advance:
        write_pairs(
            out / 'pairs', seed or 0, count, config=config, on_pairs=advance, source=source
        )
    settings = {'epochs': epochs, 'seed': seed or 0, 'learning_rate': _LEARNING_RATE}
    training = parse_training_config(settings | {'batch_size': _BATCH_SIZE})
    initial = read_weights(None, FEATURE_SCHEMA)
    dataset = PairDataset(out / 'pairs')
    fit_and_calibrate(dataset, training, out / 'run', device, initial=initial, by_plan=False)


_LEARNING_RATE, _BATCH_SIZE = 5e-4, 8  # a third of the packaged weights' learning rate; chosen
