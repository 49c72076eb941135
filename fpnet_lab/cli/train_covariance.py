# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train covariance``: fit the covariance of published poses."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.io.atomic import replaced
from fpnet_lab.cli.reports import say_figures


def command(
    out: Annotated[
        Path,
        typer.Option('--out', metavar='DIR', help='Folder of the run; its recordings are cached.'),
    ],
    drives: Annotated[
        int, typer.Option('--drives', min=2, help='Recordings for the fit, one per building.')
    ] = 20,
    measured: Annotated[
        int, typer.Option('--measured', min=0, help='Recordings of the next seed for the figures.')
    ] = 14,
    seed: common.SeedOption = 7,
    config: common.ConfigOption = None,
) -> None:
    """
    Simulate recordings on rough drawings and fit the covariance of poses to them.

    Prints the consistency on left-out buildings and on those of the next seed, and writes
    covariance.json. A second run resumes the first.

    Example: fpnet train covariance --out runs/covariance
    """
    tree = common.load(config)
    from fpnet_lab.training.covariance import (
        CovarianceTraining,
        consistency,
        enlarged,
        fit_covariance,
        held_back_errors,
        normalised_errors_of,
        stored,
    )
    from fpnet_lab.training.covariance_drives import gather_samples

    settings, first = CovarianceTraining(), 7 if seed is None else seed
    with progress('drives', total=drives + measured) as advance:
        samples = gather_samples(out / 'drives', first, drives, tree, advance)
        others = None
        if measured:
            others = gather_samples(out / 'drives', first + 1, measured, tree, advance)
    with progress('leaving out', total=settings.folds) as advance:
        held_back = held_back_errors(samples, settings, advance)
    factor = consistency(held_back, samples.run)['nees_mean'] / settings.aim
    model = enlarged(fit_covariance(samples, settings), factor)
    figures = {'left_out': consistency(held_back / factor, samples.run)}
    if others is not None:
        nees = normalised_errors_of(model, others)
        figures['other_seed'] = consistency(nees, others.run)
    said = say_figures(figures, poses=len(samples), drives=drives, seed=first)
    facts = {
        'training': asdict(settings) | {'enlarged': round(factor, 4)},
        'held': said['figures'],
        'data': said['data'],
    }
    path = out / 'covariance.json'
    with replaced(path) as partial:
        common.write_json(partial, stored(model, facts))
    typer.echo(f'wrote {path}')
