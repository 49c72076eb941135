# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train-doors``: fit what tells doors from lines inside of rooms."""

from __future__ import annotations

import typer

from fpnet_core.cli import common
from fpnet_core.cli.progress import progress
from fpnet_lab.cli import options


def command(
    data: options.TuneDataOption,
    out: options.RunOption,
    share: options.ShareOption = 1.0,
    workers: options.WorkersOption = 2,
    seed: common.SeedOption = 0,
) -> None:
    """
    Gather maps with known rooms, real and generated, and fit the model of doors to them.

    Prints what it finds on buildings that were left out, and writes doors.safetensors with its
    manifest. Called again, it fits to the samples that it has gathered.

    Example: fpnet train-doors --data ../shared/data --out runs/doors
    """
    common.check_input(data)
    from fpnet_lab.provenance import Provenance
    from fpnet_lab.training import use_threads
    from fpnet_lab.training.door_samples import (
        Amounts,
        count_maps,
        gather_samples,
        read_samples,
        write_samples,
    )
    from fpnet_lab.training.doors import DoorTraining, fit_doors, held_back_figures, write_doors

    settings, amounts = DoorTraining(seed=seed or 0), Amounts().scaled(share)
    kept = out / 'samples.npz'
    if not kept.is_file():
        with progress('maps', total=count_maps(data, amounts)) as advance:
            gathered = gather_samples(data, settings.seed, amounts, workers, advance)
        write_samples(kept, gathered)
    samples = read_samples(kept)
    use_threads(1)  # small products: more threads wait for each other
    with progress('leaving out', total=settings.folds) as advance:
        figures = held_back_figures(samples, settings, advance)
    for name, values in figures.items():
        typer.echo(f'{name}: {values}')
    drawn = {'samples': len(samples), 'share': share}
    facts = {'figures': figures, 'data': drawn | {'command': Provenance.now().command}}
    write_doors(out / 'doors.safetensors', fit_doors(samples, settings), settings, facts)
    typer.echo(f'wrote {out / "doors.safetensors"}')
