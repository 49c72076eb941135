# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate``: generated floorplans, matching pairs and recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fpnet.cli import common
from fpnet_lab.cli import (
    simulate_gallery,
    simulate_pairs,
    simulate_recording,
    simulate_sheet,
    simulate_stats,
)
from fpnet_lab.cli.options import complete_family, complete_style, named

app = typer.Typer(
    help='Generate floorplans, matching pairs and lidar recordings.',
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.command('recording')(simulate_recording.command)
app.command('pairs')(simulate_pairs.command)
app.command('features')(simulate_pairs.features_command)
app.command('gallery')(simulate_gallery.command)
app.command('sheet')(simulate_sheet.command)
app.command('stats')(simulate_stats.command)

DEFAULT_ROOMS = (8, 90)  # chosen


@app.command('plan')
def plan(
    out: Annotated[Path, typer.Option('--out', metavar='FILE', help='Image to write.')],
    seed: common.SeedOption = 0,
    family: Annotated[
        str | None,
        typer.Option(
            '--family',
            metavar='NAME',
            help='Layout family; default: any.',
            autocompletion=complete_family,
        ),
    ] = None,
    style: Annotated[
        str,
        typer.Option(
            '--style',
            metavar='NAME',
            help='Drawing style, for example sketch.',
            autocompletion=complete_style,
        ),
    ] = 'clean',
    resolution_m: Annotated[
        float, typer.Option('--resolution', min=0.01, max=0.5, help='Metres per pixel.')
    ] = 0.05,
    min_rooms: Annotated[
        int, typer.Option('--min-rooms', min=1, help='Fewest rooms.')
    ] = DEFAULT_ROOMS[0],
    max_rooms: Annotated[
        int, typer.Option('--max-rooms', min=1, help='Most rooms.')
    ] = DEFAULT_ROOMS[1],
    max_area_m2: Annotated[
        float | None, typer.Option('--max-area', min=1.0, help='Largest total floor area [m²].')
    ] = None,
) -> None:
    """
    Draw one generated floorplan as a map_server image with its YAML file.

    Example: fpnet simulate plan --out plan.png --seed 3 --family racetrack --style sketch
    """
    import numpy as np

    from fpnet_core.io.maps import write_map
    from fpnet_lab.sim.drawn.render import render_plan
    from fpnet_lab.sim.drawn.styles import STYLES
    from fpnet_lab.sim.plans import generate_plan

    look = named('style', style, STYLES)
    storey = generate_plan(
        np.random.default_rng(seed or 0), family, min_rooms, max_rooms, max_area_m2
    )
    out.parent.mkdir(parents=True, exist_ok=True)
    write_map(render_plan(storey, resolution_m, style=look), out.with_suffix('.yaml'))
    width, height = storey.extent[1] - storey.extent[0]
    typer.echo(
        f'{storey.family}: {len(storey.rooms)} rooms, {len(storey.doors)} doors, '
        f'{width:.0f} x {height:.0f} m, {storey.floor_area_m2:.0f} m² of floor'
    )
