# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train scale``: fit the scale model of drawings and maps."""

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
    config: common.ConfigOption = None,
) -> None:
    """
    Generate training maps of known scale, real and simulated, and fit the scale model.

    Prints interval coverage with architects left out in turn, and writes scale.safetensors with
    its manifest. A second run resumes the first.

    Example: fpnet train scale --data ../shared/data --out runs/scale
    """
    tree = common.load(config)
    common.check_input(data)
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
    from fpnet_lab.training.scale_samples import ScaleAmounts, gather_samples, scale_tasks

    settings, path = ScaleTraining(seed=seed or 0), out / 'scale.safetensors'
    tasks = list(scale_tasks(data, settings.seed, ScaleAmounts().scaled(share), tree.segmentation))
    with progress('maps', total=len(tasks)) as advance:
        samples = gather_samples(out / 'samples', tasks, tree.segmentation, workers, advance)
    use_threads(1)  # the matrices are small: more threads only wait for each other
    count = sum(len(folds(samples.where(samples.side == s), settings.folds)) for s in SIDES)
    with progress('leaving out', total=count) as advance:
        figures = held_back_figures(samples, held_back_estimates(samples, settings, advance))
    facts = say_figures(figures, samples=len(samples), share=share)
    write_scale(path, fit_scale(samples, settings), settings, facts)
    typer.echo(f'wrote {path}')
