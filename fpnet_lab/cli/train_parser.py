# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train parser``: train the network that parses images of floorplans."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from fpnet.cli import common
from fpnet_lab.cli import options
from fpnet_lab.provenance import Provenance


def command(
    out: options.RunOption,
    data: options.MaybeTuneDataOption = None,
    steps: Annotated[int, typer.Option('--steps', min=0, help='Batches.')] = 12_000,
    minutes: Annotated[
        float, typer.Option('--minutes', min=0.0, help='Time limit; 0: none.')
    ] = 0.0,
    batch: Annotated[int, typer.Option('--batch', min=1, help='Drawings per batch.')] = 8,
    side: Annotated[
        int, typer.Option('--side', min=128, help='Side of a view in pixels, a multiple of 64.')
    ] = 448,
    workers: Annotated[
        int, typer.Option('--workers', min=1, help='Processes that generate sheets.')
    ] = 1,
    start: Annotated[
        Path | None,
        typer.Option('--start', metavar='FILE', help='Start from this parser.onnx.xz.'),
    ] = None,
    half: Annotated[
        bool,
        typer.Option('--half', help='Half precision: faster on CPUs with bfloat16 support.'),
    ] = False,
    held: Annotated[
        int, typer.Option('--held', min=1, help='Held-out sheets of each kind for the figures.')
    ] = 10,
    device: common.DeviceOption = 'cpu',
    seed: common.SeedOption = 0,
) -> None:
    """
    Train the parser network on sheets generated during training.

    Writes parser.onnx.xz and parser.json. A second run resumes the first; another number of steps
    changes the learning rate schedule.

    Example: fpnet train parser --data ../shared/data --out runs/parser

    Example: fpnet train parser --out runs/parser --device cuda --workers 15 --minutes 9
    --steps 100000 --batch 24 --side 832
    """
    from fpnet_lab.training.parser import ParserTrainer, ParserTraining

    if data is not None:
        common.check_input(data)
    settings = ParserTraining(
        steps=steps,
        batch_size=batch,
        chunk=min(4, batch),
        side_px=side,
        workers=workers,
        minutes=minutes,
        is_half=half,
        seed=seed or 0,
    )
    trainer = ParserTrainer(out, settings, data, device)

    if start is not None and not trainer.step:
        trainer.start_from(common.check_input(start))

    def on_saved(figures: dict[str, Any]) -> None:
        typer.echo(json.dumps(figures))

    trainer.run(on_saved)
    facts = {'data': {'real': data is not None, 'command': Provenance.now().command}}
    typer.echo(f'wrote {trainer.write(facts, held)}')
