# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train-readings``: fit what weighs the readings of a drawing."""

from __future__ import annotations

from itertools import chain
from pathlib import Path
from typing import Annotated

import typer

from fpnet_core.cli import common
from fpnet_core.io.atomic import replaced
from fpnet_lab.cli import options


def command(
    sheets: Annotated[
        Path,
        typer.Argument(metavar='SHEETS', help='Folder of folders from fpnet simulate sheet.'),
    ],
    out: Annotated[Path, typer.Option('--out', metavar='FILE', help='The weights, as JSON.')],
    data: options.MaybeTuneDataOption = None,
    seed: common.SeedOption = 0,
    config: common.ConfigOption = None,
) -> None:
    """
    Read labelled drawings in all ways and fit how plausible the right ones look.

    Example: fpnet train-readings out/sheets --data ../shared/data --out readings.json
    """
    tree = common.load(config)
    common.check_input(sheets)
    from fpnet_lab.training.readings import (
        fit_readings,
        gather_readings,
        labelled_plans,
        labelled_sheets,
    )

    drawings = chain(labelled_sheets(sheets), labelled_plans(data) if data else ())
    figures, is_right, numbers = gather_readings(drawings, tree.segmentation, typer.echo)
    stored, held_out = fit_readings(figures, is_right, numbers, seed or 0)
    agree = (held_out.round() == is_right).mean()
    typer.echo(f'{len(figures)} readings, {100.0 * agree:.1f} % told right or wrong, held out')
    with replaced(out) as partial:
        common.write_json(partial, stored)
    typer.echo(f'wrote {out}')
