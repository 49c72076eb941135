# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train-scale``: fit what tells the scale of a drawing or a map."""

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
    config: common.ConfigOption = None,
) -> None:
    """
    Gather maps of known scale, real and generated, and fit the scale model to them.

    Prints what its intervals hold with architects left out in turn, and writes scale.safetensors
    with its manifest. Called again, it fits to the samples that it has gathered.

    Example: fpnet train-scale --data ../shared/data --out runs/scale
    """
    tree = common.load(config)
    common.check_input(data)
    from fpnet_lab.provenance import Provenance
    from fpnet_lab.training import use_threads
    from fpnet_lab.training.scale import (
        SIDES,
        ScaleTraining,
        fit_scale,
        folds,
        held_back_estimates,
        held_back_figures,
        write_scale,
    )
    from fpnet_lab.training.scale_samples import (
        Amounts,
        count_maps,
        gather_samples,
        read_samples,
        write_samples,
    )

    settings, amounts = ScaleTraining(seed=seed or 0), Amounts().scaled(share)
    kept = out / 'samples.npz'
    if not kept.is_file():
        with progress('maps', total=count_maps(data, amounts)) as advance:
            gathered = gather_samples(
                data, settings.seed, amounts, tree.segmentation, workers, advance
            )
        write_samples(kept, gathered)
    samples = read_samples(kept)
    use_threads(1)  # small products: more threads wait for each other
    count = sum(len(folds(samples.where(samples.side == s), settings.folds)) for s in SIDES)
    with progress('leaving out', total=count) as advance:
        figures = held_back_figures(samples, held_back_estimates(samples, settings, advance))
    for name, values in figures.items():
        typer.echo(f'{name}: {values}')
    drawn = {'samples': len(samples), 'share': share}
    facts = {'figures': figures, 'data': drawn | {'command': Provenance.now().command}}
    write_scale(out / 'scale.safetensors', fit_scale(samples, settings), settings, facts)
    typer.echo(f'wrote {out / "scale.safetensors"}')
