# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train-walls``: train the network that reads walls from pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet_core.cli import common
from fpnet_core.cli.progress import progress
from fpnet_lab.cli import options
from fpnet_lab.provenance import Provenance

if TYPE_CHECKING:
    from fpnet_lab.training.walls import WallTrainer


def command(
    out: options.RunOption,
    data: options.MaybeTuneDataOption = None,
    sheets: Annotated[
        int, typer.Option('--sheets', min=1, help='Drawings to generate and learn from.')
    ] = 1000,
    steps: Annotated[int, typer.Option('--steps', min=1, help='Batches of patches.')] = 7200,
    workers: Annotated[int, typer.Option('--workers', min=1, help='Processes and threads.')] = 2,
    seed: common.SeedOption = 0,
) -> None:
    """
    Draw sheets with their truth, and train what tells walls from everything else on them.

    Writes walls.safetensors with its manifest every few hundred steps. Called again, it goes on
    where it was; a changed number of steps changes how the learning rate falls.

    Example: fpnet train-walls --data ../shared/data --out runs/walls
    """
    if data is not None:
        common.check_input(data)
    from fpnet_core.models.walls import WallNetworkConfig
    from fpnet_lab.training import use_threads
    from fpnet_lab.training.wall_samples import gather_samples
    from fpnet_lab.training.walls import HELD_SHEETS, WEIGHTS_FILE, WallTrainer, WallTraining

    parts = {'held': HELD_SHEETS, 'train': sheets}
    with progress('sheets', total=sum(parts.values())) as advance:
        gather_samples(out / 'samples', parts, data, workers, advance)
    use_threads(workers)
    settings = WallTraining(steps=steps, seed=seed or 0)
    trainer = WallTrainer(out, WallNetworkConfig(), settings)
    _train(trainer, {'sheets': parts, 'real': data is not None})
    typer.echo(f'wrote {out / WEIGHTS_FILE}')


def _train(trainer: WallTrainer, drawn: dict[str, Any]) -> None:
    """Train to the end and say what comes out now and then."""
    facts = {'data': drawn | {'command': Provenance.now().command}}

    def on_saved(figures: dict[str, Any]) -> None:
        typer.echo(f'step {figures["step"]}: loss {figures["loss"]}, {figures["iou"]["all"]}')

    with progress('steps', total=trainer.config.steps) as advance:
        advance(float(trainer.step))
        trainer.run(facts, advance, on_saved)
