# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate gallery``: generated storeys and matching pairs on one sheet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import track

if TYPE_CHECKING:
    from fpnet_core.types import GridMap
    from fpnet_lab.sim.pairs.pair import MappedPair

PAIRS = 9
SHEETS = 4
"""Number of pairs, and of sheets of a kind. Chosen."""
CELL_M, FINE_CELL_M = 0.08, 0.04
"""Cell size of drawings of many storeys, and of one storey in every style. Chosen."""
MAX_ROOMS = 45
"""Most rooms of a storey; larger ones are illegible on the sheet. Chosen."""


def command(
    out: Annotated[Path, typer.Option('--out', metavar='FILE', help='Image to write.')],
    seed: common.SeedOption = 0,
    family: Annotated[
        str | None,
        typer.Option(
            '--family', metavar='NAME', help='One storey of a layout family in every style.'
        ),
    ] = None,
    sheets: Annotated[
        bool, typer.Option('--sheets', help='Draw realistic sheets of every kind.')
    ] = False,
) -> None:
    """
    Draw generated floorplans in several styles and matching pairs on one sheet.

    Example: fpnet simulate gallery --out sheet.png --seed 1

    Example: fpnet simulate gallery --out sheets.png --sheets
    """
    if sheets:
        _draw_sheets(out, seed or 0)
        return
    from fpnet_lab.sim.drawn.styles import STYLES
    from fpnet_lab.sim.plans import FAMILIES
    from fpnet_lab.viz.simulated import save_gallery

    styles = list(STYLES)
    names = list(FAMILIES) if family is None else [family] * len(styles)
    looks = [styles[i % len(styles)] for i in range(len(names))]
    shown = track(list(zip(names, looks, strict=True)), 'storeys')
    seeds = [[seed or 0, i if family is None else 0] for i in range(len(names))]
    cell_m = CELL_M if family is None else FINE_CELL_M
    drawings = [_draw(name, look, cell_m, seeds[i]) for i, (name, look) in enumerate(shown)]
    pairs = _mapped_pairs(seed or 0) if family is None else []
    save_gallery(drawings, pairs, out, columns=6 if family is None else 4)
    typer.echo(f'written: {out}')


def _draw_sheets(out: Path, seed: int) -> None:
    """Draw sheets of every kind, one row per kind."""
    from fpnet_lab.sim.sheets import STANDARD_KINDS, draw_sheet
    from fpnet_lab.viz.drawings import save_contact_sheet

    wanted = [(kind, seed * SHEETS + i) for kind in STANDARD_KINDS for i in range(SHEETS)]
    pictures = [
        (f'{kind.value}, seed {number}', draw_sheet(number, kind).pixels)
        for kind, number in track(wanted, 'sheets')
    ]
    save_contact_sheet(out, pictures, SHEETS)
    typer.echo(f'written: {out}')


def _draw(family: str, look: str, cell_m: float, seeds: list[int]) -> tuple[str, GridMap]:
    import numpy as np

    from fpnet_lab.sim.drawn.render import render_plan
    from fpnet_lab.sim.drawn.styles import STYLES
    from fpnet_lab.sim.plans import generate_plan

    storey = generate_plan(np.random.default_rng(seeds), family, max_rooms=MAX_ROOMS)
    title = f'{family} ({look}), {len(storey.rooms)} rooms'
    return title.replace('_', ' '), render_plan(storey, cell_m, style=STYLES[look])


def _mapped_pairs(seed: int) -> list[MappedPair]:
    from fpnet_lab.sim.config import SimConfig
    from fpnet_lab.sim.pairs.pair import generate_mapped_pair

    config = SimConfig(max_rooms=MAX_ROOMS)
    indices = range(0, PAIRS * config.pairs_per_plan, config.pairs_per_plan)
    return [generate_mapped_pair(seed, i, config) for i in track(indices, 'pairs')]
