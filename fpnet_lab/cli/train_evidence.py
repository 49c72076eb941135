# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train evidence``: fit the evidence model of the matcher's placements."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress

if TYPE_CHECKING:
    from fpnet_lab.sim.pairs.dataset import PairDataset
    from fpnet_lab.sim.pairs.pair import MatchingPair


def command(
    data: Annotated[
        list[Path],
        typer.Option('--data', metavar='DIR', help='Pairs of other storeys; repeatable.'),
    ],
    out: Annotated[
        Path, typer.Option('--out', metavar='DIR', help='Folder of matcher.safetensors.')
    ],
    weights: Annotated[
        Path | None,
        typer.Option('--weights', metavar='FILE', help='Network; default: packaged.'),
    ] = None,
) -> None:
    """
    Fit the evidence model of consensus to pairs that the network was not trained on.

    Writes matcher.safetensors, the same network with the new model in its manifest. fpnet train
    matcher fits the model to its held-back pairs; this command uses pairs of several kinds.

    Example: fpnet train evidence --data runs/tours --data runs/clips --out runs/evidence
    """
    folders = [common.check_input(folder) for folder in data]
    from fpnet_lab.sim.pairs.dataset import PairDataset
    from fpnet_lab.training import WEIGHTS_FILE, calibrate

    sets = [PairDataset(folder) for folder in folders]
    facts = {folder.name: each.manifest for folder, each in zip(folders, sets, strict=True)}
    out.mkdir(parents=True, exist_ok=True)
    with progress('pairs', total=sum(map(len, sets))) as advance:
        calibrate(weights, _pairs(sets, advance), out / WEIGHTS_FILE, facts)
    typer.echo(f'wrote {out / WEIGHTS_FILE}')


def _pairs(sets: list[PairDataset], advance: Callable[[float], None]) -> Iterator[MatchingPair]:
    for each in sets:
        for index in range(len(each)):
            yield each.pair(index)
            advance(1.0)
