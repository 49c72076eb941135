# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train doors``: fit the model that separates doors from lines inside rooms."""

from __future__ import annotations

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli import options
from fpnet_lab.cli.reports import say_figures


def command(
    data: options.TuneDataOption,
    out: options.RunOption,
    share: options.ShareOption = 1.0,
    workers: options.WorkersOption = 2,
    seed: common.SeedOption = 0,
) -> None:
    """
    Generate training maps with known rooms, real and simulated, and fit the door model.

    Prints the accuracy on left-out buildings, and writes doors.safetensors with its manifest. A
    second run resumes the first.

    Example: fpnet train doors --data ../shared/data --out runs/doors
    """
    common.check_input(data)
    from fpnet_lab.training import use_threads
    from fpnet_lab.training.door_samples import DoorAmounts, door_tasks, gather_samples
    from fpnet_lab.training.doors import DoorTraining, fit_doors, held_back_figures, write_doors

    settings, path = DoorTraining(seed=seed or 0), out / 'doors.safetensors'
    tasks = list(door_tasks(data, settings.seed, DoorAmounts().scaled(share)))
    with progress('maps', total=len(tasks)) as advance:
        samples = gather_samples(out / 'samples', tasks, workers, advance)
    use_threads(1)  # the matrices are small: more threads only wait for each other
    with progress('leaving out', total=settings.folds) as advance:
        figures = held_back_figures(samples, settings, advance)
    facts = say_figures(figures, samples=len(samples), share=share)
    write_doors(path, fit_doors(samples, settings), settings, facts)
    typer.echo(f'wrote {path}')
