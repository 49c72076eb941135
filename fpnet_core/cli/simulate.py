# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate``: generated floorplans, matching pairs and recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet_core.cli import common, simulate_pairs, simulate_recording, simulate_stats
from fpnet_core.errors import ConfigError

if TYPE_CHECKING:
    from fpnet_core.types import GridMap

app = typer.Typer(
    help='Generate floorplans, matching pairs and lidar recordings.',
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.command('recording')(simulate_recording.command)
app.command('pairs')(simulate_pairs.command)
app.command('features')(simulate_pairs.features_command)
app.command('stats')(simulate_stats.command)

OutFile = Annotated[Path, typer.Option('--out', metavar='FILE', help='Image to write.')]
FamilyOption = Annotated[
    str | None, typer.Option('--family', metavar='NAME', help='Layout family; default: any.')
]


@app.command('plan')
def plan(
    out: OutFile,
    seed: common.SeedOption = 0,
    family: FamilyOption = None,
    resolution_m: Annotated[
        float, typer.Option('--resolution', min=0.01, max=0.5, help='Metres per pixel.')
    ] = 0.05,
) -> None:
    """
    Draw one generated floorplan as a map_server image with its YAML file.

    Example: fpnet simulate plan --out plan.png --seed 3 --family racetrack
    """
    import numpy as np

    from fpnet_core.io import write_map
    from fpnet_core.sim.plans import generate_plan
    from fpnet_core.sim.render import render_plan

    storey = generate_plan(np.random.default_rng(seed or 0), family)
    out.parent.mkdir(parents=True, exist_ok=True)
    write_map(render_plan(storey, resolution_m), out.with_suffix('.yaml'))
    width, height = storey.extent[1] - storey.extent[0]
    typer.echo(
        f'{storey.family}: {len(storey.rooms)} rooms, {len(storey.doors)} doors, '
        f'{width:.0f} x {height:.0f} m'
    )


@app.command('gallery')
def gallery(
    out: OutFile,
    seed: common.SeedOption = 0,
    family: FamilyOption = None,
    with_pairs: Annotated[
        bool, typer.Option('--pairs', help='Show matching pairs instead of storeys.')
    ] = False,
) -> None:
    """
    Draw a sheet of generated floorplans, or of matching pairs.

    Example: fpnet simulate gallery --out sheet.png --seed 1
    """
    if with_pairs and family is not None:
        raise ConfigError('--family draws storeys only; leave out --pairs')
    if with_pairs:
        _gallery_of_pairs(out, seed or 0)
    else:
        _gallery_of_plans(out, seed or 0, family)
    typer.echo(f'written: {out}')


def _gallery_of_plans(out: Path, seed: int, family: str | None) -> None:
    import numpy as np

    from fpnet_core.sim.plans import FAMILIES, generate_plan
    from fpnet_core.sim.render import render_plan
    from fpnet_core.viz.simulated import save_plans

    names = [family] * 4 if family is not None else list(FAMILIES)
    drawings: list[tuple[str, GridMap]] = []
    for name in common.track(names, 'storeys'):
        for k in range(4):
            storey = generate_plan(np.random.default_rng([seed, len(drawings), k]), name)
            title = f'{name}: {len(storey.rooms)} rooms, {len(storey.doors)} doors'
            drawings.append((title, render_plan(storey, 0.1)))
    save_plans(drawings, 8, out)


def _gallery_of_pairs(out: Path, seed: int) -> None:
    from fpnet_core.sim.config import SimConfig
    from fpnet_core.sim.pairs import generate_scene
    from fpnet_core.viz.simulated import save_pairs

    step = SimConfig().pairs_per_plan
    scenes = [generate_scene(seed, step * i) for i in common.track(range(12), 'pairs')]
    save_pairs(scenes, out)
