# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench drawings``: parsing of coloured, scanned and photographed plans."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError
from fpnet_lab.cli.reports import show, write_report
from fpnet_lab.scores import Column, Table, columns, named

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading
    from fpnet_lab.evaluation.drawings import RoomComparison, SheetResult
    from fpnet_lab.sim.sheets import Sheet, SheetKind

_Half = Literal['tune', 'report']
_REAL = 'real'
"""Given: value of ``--set`` that selects the real drawings; others are configuration."""

_Format = Literal['picture', 'pdf', 'svg', 'dxf']


def command(
    count: Annotated[
        int, typer.Option('--count', min=0, help='Total number of generated sheets.')
    ] = 300,
    kinds: Annotated[
        str | None,
        typer.Option(
            '--kinds',
            metavar='NAMES',
            help='Some of clean, office, brochure, scan, phone (default: these) and varied.',
        ),
    ] = None,
    half: Annotated[
        _Half,
        common.choice(
            '--half', _Half, 'tune: development split; report: test split, for published figures.'
        ),
    ] = 'report',
    file_format: Annotated[
        _Format, common.choice('--format', _Format, 'File format of the sheets.')
    ] = 'picture',
    data: Annotated[
        Path | None,
        typer.Option(
            '--data', metavar='DIR', help='Folder of bormann (redrawn in grey) or real drawings.'
        ),
    ] = None,
    truth: Annotated[
        Path, typer.Option('--truth', metavar='DIR', help='Truth files of the real drawings.')
    ] = Path('benchmarks/real_drawings'),
    plot: Annotated[
        Path | None,
        typer.Option('--plot', metavar='DIR', help='Save images of all wrong sheets.'),
    ] = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Parse generated sheets of unknown scale and compare rooms and scale with the truth.

    Prints percentages; the JSON holds fractions. With --data it also parses the hand-labelled real
    plans, with walls in five grey levels and white on black.

    --set real parses drawings from public repositories instead: the development split with --half
    tune, otherwise both splits. It lists the missing ones.

    Example: fpnet bench drawings --json out/drawings.json --data ../shared/data

    Example: fpnet bench drawings --half tune --count 50 --kinds office,scan --plot out/wrong

    Example: fpnet bench drawings --set real --half tune --plot out/real --json out/real.json
    """
    entries = settings or []
    tree = common.load(config, [each for each in entries if each != _REAL])
    if _REAL in entries:
        from fpnet_lab.cli.bench_real_drawings import bench_real, show_real

        folders = [common.check_input(each) for each in (truth, data) if each is not None]
        report = bench_real(_reader(tree), tree.segmentation, folders, half, plot)
        show_real(report, json_path)
        write_report(json_path, report)
        return
    wanted = _kinds(kinds)
    results = _read_sheets(wanted, count, half, file_format, plot, tree)
    report = {'half': half, 'format': file_format, **_figures(wanted, results)}
    if data is not None:
        report['bormann'] = _read_real(common.check_input(data), half, tree)
    _print(report, json_path)
    write_report(json_path, report)


def _kinds(names: str | None) -> list[SheetKind]:
    from fpnet_lab.sim.sheets import STANDARD_KINDS, SheetKind

    known = [kind.value for kind in SheetKind]
    wanted = [kind.value for kind in STANDARD_KINDS] if names is None else names.split(',')
    unknown = sorted(set(wanted) - set(known))
    if unknown:
        raise ConfigError(f'unknown kind {unknown[0]!r}; choose from {",".join(known)}')
    return [SheetKind(name) for name in wanted]


def _reader(tree: FpnetConfig) -> Callable[..., Reading]:
    from fpnet_core.drawings.read import read_plan
    from fpnet_core.drawings.types import ReadOptions

    def read(path: Path, options: ReadOptions | None = None) -> Reading:
        return read_plan(path, options or ReadOptions(), tree)

    return read


def _read_sheets(
    kinds: Sequence[SheetKind],
    count: int,
    half: str,
    file_format: str,
    plot: Path | None,
    tree: FpnetConfig,
) -> list[SheetResult]:
    from fpnet_lab.evaluation.drawings import bench_sheets, seeds_of

    seeds = seeds_of(half, -(-count // len(kinds)))
    with (
        TemporaryDirectory() as folder,
        progress('sheets', len(seeds) * len(kinds)) as advance,
    ):

        def on_read(sheet: Sheet, result: SheetResult, rooms: RoomComparison | None) -> None:
            advance(1.0)
            if plot is not None and not result.is_right:
                from fpnet_lab.viz.drawings import save_comparison

                labels = None if rooms is None else (rooms.found, rooms.true)
                file = plot / f'{result.name}.png'
                save_comparison(file, sheet.pixels, labels, result.caption)

        return bench_sheets(
            _reader(tree), Path(folder), kinds, seeds, tree.segmentation, file_format, on_read
        )


def _read_real(data: Path, half: str, tree: FpnetConfig) -> dict[str, Any]:
    from fpnet_lab.evaluation.drawings_real import TONES, bench_plans, plan_names

    total = len(plan_names(half)) * len(TONES)
    with TemporaryDirectory() as folder, progress('real plans', total) as advance:
        return bench_plans(_reader(tree), data, Path(folder), half, tree.segmentation, advance)


def _figures(kinds: Sequence[SheetKind], results: Sequence[SheetResult]) -> dict[str, Any]:
    from fpnet_lab.evaluation.drawings import kind_figures, scale_figures

    by_kind = {
        kind.value: [result for result in results if result.kind == kind.value] for kind in kinds
    }
    return {
        'kinds': {name: kind_figures(found) for name, found in by_kind.items()},
        'all': kind_figures(results),
        'scale': scale_figures(results)
        | {'kinds': {name: scale_figures(found) for name, found in by_kind.items()}},
    }


def _print(report: dict[str, Any], json_path: Path | None) -> None:
    from fpnet_lab.evaluation.published.makers import READ_SHARE, SHEETS, sheet_rows

    sheets = (*SHEETS, Column('clean plan', 'clean_right', READ_SHARE))
    show(Table.of(sheets, sheet_rows(report)), json_path)
    scales = {**report['scale']['kinds'], 'all': report['scale']}
    if 'bormann' in report:
        scales['real plans'] = report['bormann']['scale']
    titles = {'within_10': 'within 10 %', 'interval_holds': 'interval holds'}
    read = [Column('scales', 'name'), Column('read', 'sheets'), *columns(READ_SHARE, titles)]
    sure = [Column('sure', 'sure'), Column('sure and wrong', 'sure_and_wrong', READ_SHARE)]
    show(Table.of(read + sure, named(scales)), json_path)
    if 'bormann' in report:
        titles = {'as_black': 'rooms as black', 'walls_as_black': 'walls as black'}
        titles |= {'f1_mean': 'F1', 'marked': 'marked'}
        levels = [Column('real walls', 'name'), *columns(READ_SHARE, titles)]
        show(Table.of(levels, named(report['bormann']['tones'])), json_path)
