# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train doubts``: fit the parse quality model."""

from __future__ import annotations

from typing import Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli import options
from fpnet_lab.cli.reports import say_figures


def command(
    out: options.RunOption,
    buildings: Annotated[
        int,
        typer.Option('--buildings', min=6, help='Buildings, each on six kinds of sheets.'),
    ] = 60,
    workers: options.WorkersOption = 2,
    seed: common.SeedOption = 0,
    config: common.ConfigOption = None,
) -> None:
    """
    Parse generated sheets, compare with the truth, and fit the parse quality model.

    Prints how well the model detects wrong parses of left-out buildings and images that are no
    floorplans, and writes doubts.json with both thresholds. Run it into a new folder after every
    change of the parser. A second run resumes the first.

    Example: fpnet train doubts --out runs/doubts
    """
    tree = common.load(config)
    from fpnet_lab.training import use_threads
    from fpnet_lab.training.doubts import (
        FIRST_SEED,
        DoubtTraining,
        fit_doubts,
        gather_trials,
        held_out_figures,
        write_doubts,
    )

    settings = DoubtTraining(seed=seed or 0)
    seeds = range(FIRST_SEED, FIRST_SEED + buildings)
    with progress('sheets', total=14.0 * buildings) as advance:
        trials = gather_trials(out / 'trials', seeds, tree.segmentation, workers, advance)
    use_threads(1)  # the matrices are small: more threads only wait for each other
    with progress('leaving out', total=2.0 * settings.folds) as advance:
        model, held_out = fit_doubts(trials, settings, advance)
    figures = held_out_figures(trials, held_out, model)
    facts = say_figures(figures, sheets=6 * buildings, first_seed=FIRST_SEED, readings=len(trials))
    path = out / 'doubts.json'
    write_doubts(path, model, settings, facts)
    typer.echo(f'wrote {path}')
