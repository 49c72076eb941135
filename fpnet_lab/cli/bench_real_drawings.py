# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench drawings --set real``: real drawings with labelled rooms, doors and scale."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError
from fpnet_lab.cli.reports import show
from fpnet_lab.scores import Column, Table, Units, columns, named

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fpnet_core.config import SegmentationConfig
    from fpnet_lab.evaluation.real_drawings import OptionsReader, TrueDrawing

_HOLDS = {True: 'yes', False: 'no', None: '-'}


def bench_real(
    read: OptionsReader,
    config: SegmentationConfig,
    folders: Sequence[Path],
    half: str,
    plot: Path | None,
) -> dict[str, Any]:
    """
    Parse the drawings of the truth files in the first folder and return the report.

    The drawings are in any of the folders or in ``$FPNET_DATA/drawings``; ``half`` is ``tune`` for
    the development split, else both are used; ``plot`` gets images of the development split.
    """
    from fpnet_lab.evaluation.real_drawings import SPLITS, bench_drawing, real_figures
    from fpnet_lab.viz.drawings import save_comparison

    splits = SPLITS[:1] if half == SPLITS[0] else SPLITS
    present = _present(folders, splits)
    rows = []
    with progress('real drawings', len(present)) as advance:
        for truth, path in present:
            row, sheet, rooms, pixels = bench_drawing(read, truth, path, config)
            rows.append(row)
            advance(1.0)
            if plot and rooms is not None and pixels is not None and truth.split == SPLITS[0]:
                labels = rooms.found[::-1], rooms.true[::-1]  # most files have row 0 at the top
                save_comparison(plot / f'{truth.name}.png', pixels, labels, sheet.caption)
    of_split = {split: [row for row in rows if row['split'] == split] for split in splits}
    figures = {split: real_figures(found) for split, found in of_split.items() if found}
    return {'splits': figures, 'cases': rows}


def _present(folders: Sequence[Path], splits: Sequence[str]) -> list[tuple[TrueDrawing, Path]]:
    """Return the truths with existing drawings, and their files; print the missing ones."""
    from fpnet_lab.evaluation.real_drawings import find_drawing, read_truth

    said = os.environ.get('FPNET_DATA')
    places = [*folders, *([Path(said)] if said else [])]
    truths = [read_truth(path) for path in sorted(folders[0].glob('*.json'))]
    wanted = [truth for truth in truths if truth.split in splits]
    files = {truth.name: find_drawing(truth, places) for truth in wanted}
    absent = sorted({truth.file for truth in wanted if files[truth.name] is None})
    if absent:
        where = f'{folders[0]} lists their sources; give the folder that holds them with --data'
        typer.echo(f'missing: {", ".join(absent)}; {where}', err=True)
    present = [(truth, path) for truth in wanted if (path := files[truth.name]) is not None]
    if not present:
        raise ConfigError(f'no drawing described in {folders[0]} was found; give --data')
    return present


def show_real(report: dict[str, Any], json_path: Path | None) -> None:
    """Print the result of each drawing, and the figures of each split."""
    share, number = Units.SHARE.to(0, '-'), Units.NUMBER.to(2, '-')
    shares = {'precision': 'prec.', 'recall': 'rec.', 'f1': 'F1'}
    shares |= {'door_precision': 'doors prec.', 'door_recall': 'rec.'}
    cases = [
        *(Column(key, key) for key in ('name', 'split')),
        Column('rooms', lambda row: f'{row["rooms_found"]}/{row["rooms"]}'),
        *columns(share, shares),
        Column('scale', 'scale_ratio', number),
        Column('holds', lambda row: _HOLDS[row['interval_holds']]),
        Column('verdict', lambda row: row['verdict'] + (', silent' if row['silent'] else '')),
    ]
    show(Table.of(cases, report['cases']), json_path, width=140)
    summary = [
        *(Column(each, each) for each in ('name', 'drawings')),
        *columns(share, shares | {'f1_half': 'F1 >= 0.5', 'interval_holds': 'scale holds'}),
        *(Column(each, each) for each in ('fit', 'doubtful', 'no_floorplan', 'silent')),
    ]
    show(Table.of(summary, named(report['splits'])), json_path, width=140)
