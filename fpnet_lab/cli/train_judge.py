# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train judge``: fit the judge of placements."""

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
        typer.Option('--without', help='Leave out figures named so, as rival or ben; repeatable.'),
    ] = None,
    seed: common.SeedOption = 0,
    config: common.ConfigOption = None,
) -> None:
    """
    Gather trials on the tune half and on generated buildings, and fit the judge to them.

    Writes judge.safetensors with its manifest; use it with --set
    localizer.judge_weights=OUT/judge.safetensors. Called again, it goes on where it was.

    Example: fpnet train judge --data ../shared/data --out runs/judge
    """
    tree = common.load(config)
    common.check_input(data)
    from fpnet_lab.training import use_threads
    from fpnet_lab.training.judge import JudgeTraining, fit_judge, stack_trials, write_judge
    from fpnet_lab.training.judge_figures import held_back_figures
    from fpnet_lab.training.judge_gathering import TrialAmounts, gather_trials, trial_blocks

    settings = JudgeTraining(seed=seed or 0, without=tuple(without or ()))
    blocks = trial_blocks(settings.seed, data, tree, TrialAmounts().scaled(share))
    with progress('trials', total=len(blocks)) as advance:
        trials = gather_trials(out / 'trials', blocks, workers, advance)
    use_threads(1)  # small products: more threads wait for each other
    figures = held_back_figures(trials, settings)
    facts = say_figures(figures, trials=len(trials), share=share)
    with progress('fitting', total=settings.members) as advance:
        networks = fit_judge(stack_trials(trials), settings, advance)
    words = ['judge', *(f'without_{word}' for word in settings.without)]
    path = out / f'{"_".join(words)}.safetensors'
    write_judge(path, networks, settings, facts)
    typer.echo(f'wrote {path}')
