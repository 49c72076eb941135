# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train scorer``: fit the placement scorer."""

from __future__ import annotations

from typing import Annotated

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
    without: Annotated[
        list[str] | None,
        typer.Option(
            '--without', help='Disable features by part of the name, e.g. rival; repeatable.'
        ),
    ] = None,
    seed: common.SeedOption = 0,
    config: common.ConfigOption = None,
) -> None:
    """
    Generate trials on the development split and on generated buildings, and fit the scorer.

    Writes scorer.safetensors with its manifest; use it with --set
    localizer.scorer_weights=OUT/scorer.safetensors. A second run resumes the first.

    Example: fpnet train scorer --data ../shared/data --out runs/scorer
    """
    tree = common.load(config)
    common.check_input(data)
    from fpnet_lab.training import use_threads
    from fpnet_lab.training.scorer import ScorerTraining, fit_scorer, stack_trials, write_scorer
    from fpnet_lab.training.scorer_figures import held_back_figures
    from fpnet_lab.training.scorer_gathering import TrialAmounts, gather_trials, trial_blocks

    settings = ScorerTraining(seed=seed or 0, without=tuple(without or ()))
    blocks = trial_blocks(settings.seed, data, tree, TrialAmounts().scaled(share))
    with progress('trials', total=len(blocks)) as advance:
        trials = gather_trials(out / 'trials', blocks, workers, advance)
    use_threads(1)  # the matrices are small: more threads only wait for each other
    figures = held_back_figures(trials, settings)
    facts = say_figures(figures, trials=len(trials), share=share)
    with progress('fitting', total=settings.members) as advance:
        networks = fit_scorer(stack_trials(trials), settings, advance)
    words = ['scorer', *(f'without_{word}' for word in settings.without)]
    path = out / f'{"_".join(words)}.safetensors'
    write_scorer(path, networks, settings, facts)
    typer.echo(f'wrote {path}')
