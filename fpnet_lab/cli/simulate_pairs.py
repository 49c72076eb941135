# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate pairs`` and ``fpnet simulate features``: data sets of matching pairs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError
from fpnet_lab.cli import options

if TYPE_CHECKING:
    from fpnet_lab.sim.pairs.presets import Preset
    from fpnet_lab.sim.plans.sources import GivenPlans

PlansOption = Annotated[
    list[Path] | None,
    typer.Option(
        '--plans',
        '--floorplan',
        metavar='PATH',
        help='Floorplan image, its YAML, or a folder of them, instead of generated storeys; '
        'repeatable.',
    ),
]
SplitOption = Annotated[
    str | None,
    typer.Option(
        '--split',
        metavar='tune|report',
        help='Use only this split of the labelled real storeys, by file name.',
    ),
]


def command(
    out: Annotated[Path, typer.Option('--out', metavar='DIR', help='Folder for the pairs.')],
    count: Annotated[
        int | None,
        typer.Option('--count', min=1, help="Pairs of all shards; default: the preset's."),
    ] = None,
    preset: Annotated[
        str,
        typer.Option(
            '--preset',
            metavar='NAME',
            help='default, paper-synthetic, paper-real or paper-challenging.',
        ),
    ] = 'default',
    plans: PlansOption = None,
    resolution_m: Annotated[
        float | None,
        typer.Option(
            '--resolution',
            min=0.005,
            max=1.0,
            help='Metres per pixel of the drawings; default: estimated.',
        ),
    ] = None,
    split: SplitOption = None,
    seed: common.SeedOption = 0,
    shard: Annotated[
        str, typer.Option('--shard', metavar='I/N', help='Write only every N-th block, from I on.')
    ] = '0/1',
    workers: options.WorkersOption = 1,
    cluster: Annotated[
        str | None,
        typer.Option(
            '--cluster', metavar='ADDRESS', help='Generate on the workers of a Dask scheduler.'
        ),
    ] = None,
) -> None:
    """
    Write pairs of region graphs of a floorplan and a partial robot map, with true matches.

    Existing blocks are kept: a second run resumes the first, or adds pairs with a larger count.

    Example: fpnet simulate pairs --out runs/pairs --count 10000 --seed 1 --workers 2

    Example: fpnet simulate pairs --out runs/mine --count 2000 --floorplan my_plan.png
    """
    part, parts = parse_shard(shard)
    from fpnet_lab.sim.pairs import presets
    from fpnet_lab.sim.pairs.writing import shard_blocks, write_pairs

    chosen = presets.preset(preset)
    source = _given_plans(plans, resolution_m, split, chosen)
    if chosen.needs_plans and source is None:
        raise ConfigError(f'--preset {preset} needs real floorplans; give --plans PATH')
    total = count or chosen.pair_count(len(source) if source is not None else 0)
    if total is None:
        raise ConfigError(f'--preset {preset} has no default number of pairs; give --count')
    pairs = sum(shard_blocks(total, part, parts).values())
    with progress('pairs', total=pairs) as advance:
        written = write_pairs(
            out,
            seed or 0,
            total,
            part,
            parts,
            workers,
            chosen.config,
            on_pairs=advance,
            source=source,
            cluster=cluster,
        )
    typer.echo(f'{written} pairs written to {out}')


def _given_plans(
    paths: list[Path] | None, resolution_m: float | None, split: str | None, preset: Preset
) -> GivenPlans | None:
    if not paths:
        if split is not None:
            raise ConfigError('--split selects real floorplans; give --plans PATH')
        return None
    from fpnet_lab.sim.pairs.presets import in_split
    from fpnet_lab.sim.plans.sources import GivenPlans, read_plans

    plans = read_plans([common.check_input(path) for path in paths], resolution_m)
    if split is not None:
        plans = in_split(plans, split)
    return GivenPlans(plans, preset.config.segmentation)


def parse_shard(text: str) -> tuple[int, int]:
    """Parse ``I/N`` with 0 <= I < N."""
    first, _, second = text.partition('/')
    if first.isdecimal() and second.isdecimal() and int(first) < int(second):
        return int(first), int(second)
    raise ConfigError(f'--shard {text}: expected I/N with 0 <= I < N, for example 0/4')


def features_command(
    data: Annotated[Path, typer.Argument(metavar='DIR', help='Folder of pairs.')],
) -> None:
    """
    Recompute the features of stored pairs, after an update that changed their layout.

    The pairs are not changed: nothing is simulated or segmented again.

    Example: fpnet simulate features runs/pairs
    """
    common.check_input(data)
    from fpnet_lab.sim.pairs.dataset import block_size, present_blocks
    from fpnet_lab.sim.pairs.writing import refresh_features

    total = sum(map(block_size, present_blocks(data).values()))
    with progress('features', total=total) as advance:
        rewritten = refresh_features(data, advance)
    typer.echo(f'{rewritten} of {total} pairs rewritten in {data}')
