# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench open``: a benchmark that runs any program, and scores what it claims."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError
from fpnet_lab.cli import options
from fpnet_lab.cli.reports import finish

if TYPE_CHECKING:
    from fpnet_lab.evaluation.open_benchmark.programs import Program

app = typer.Typer(
    help='Run any program on cases with hidden truth, and score its answers.',
    no_args_is_help=True,
)

_Track = Literal['exact', 'sketch', 'rough', 'sheets', 'real']
_CasesOption = Annotated[
    Path, typer.Option('--cases', metavar='DIR', help='Folder that make has written.')
]


@app.command('make')
def make(
    out: Annotated[Path, typer.Option('--out', metavar='DIR', help='Folder to write.')],
    track: Annotated[_Track, common.choice('--track', _Track, 'How plans are drawn.')] = 'exact',
    count: Annotated[int, typer.Option('--count', min=1, help='Generated buildings.')] = 6,
    seed: common.SeedOption = None,
    sensor: Annotated[
        str,
        typer.Option(
            '--sensor',
            metavar='NAME',
            help='Lidar of generated drives, as of fpnet simulate recording.',
            autocompletion=options.complete_sensor,
        ),
    ] = 'planar',
    data: Annotated[
        Path, typer.Option('--data', metavar='DIR', help='Files of the track real.')
    ] = Path('out/open_data'),
    manifest: Annotated[
        Path | None,
        typer.Option('--manifest', metavar='JSON', help="The track real's; default: packaged."),
    ] = None,
) -> None:
    """
    Write cases: plans, scans with odometry, and the truth in a folder of its own.

    Each building gives a drive, its finished map, parts of 30 and 15 m and a single scan on its
    plan, and the drive on another building's plan, on the mirrored plan and on another floor's.
    The track real reads the public files that the manifest names from --data and downloads
    nothing: run python benchmarks/fetch_open_data.py first.

    Example: fpnet bench open make --track exact --count 6 --seed 1 --out out/cases
    """
    from fpnet_lab.evaluation.open_benchmark.writing import write_cases

    made: dict[str, Any] = {'track': track, 'seed': seed or 0}
    if track == 'real':
        from fpnet_lab.evaluation.open_benchmark.real import Manifest, real_buildings

        entries, faults = Manifest.read(manifest).usable(data)
        for fault in faults:
            typer.echo(fault)
        if not entries:
            raise ConfigError(
                f'no building of the track real is complete in {data}; '
                'run: python benchmarks/fetch_open_data.py'
            )
        with progress('buildings', len(entries)) as advance:
            buildings = real_buildings(entries, data, lambda: advance(1.0))
            written = write_cases(out, buildings, made, seed or 0)
    else:
        from fpnet_lab.evaluation.open_benchmark.generated import (
            GeneratedTrack,
            generated_buildings,
        )
        from fpnet_lab.sim.lidars.sensors import SENSORS

        options.named('sensor', sensor, SENSORS)
        made |= {'count': count, 'sensor': sensor}
        with progress('buildings', count) as advance:
            buildings = generated_buildings(
                GeneratedTrack(track), count, seed or 0, sensor, lambda: advance(1.0)
            )
            written = write_cases(out, buildings, made, seed or 0)
    typer.echo(f'{len(written.cases)} cases written to {out}')


@app.command('run')
def run(
    cases: _CasesOption,
    out: Annotated[
        Path, typer.Option('--out', metavar='DIR', help='Results, a folder for each program.')
    ],
    programs: Annotated[
        list[str] | None,
        typer.Option(
            '--program',
            metavar='[NAME=]COMMAND',
            help='Command with {plan}, {scans} and {out}, or fpnet, matcher_ransac, '
            'branch_and_bound, correlative, monte_carlo, all; repeatable. Default: fpnet.',
        ),
    ] = None,
    timeout_s: Annotated[
        float, typer.Option('--timeout', min=1.0, help='Seconds for a case, of a command.')
    ] = 600.0,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
) -> None:
    """
    Run programs on cases and write their answers.

    A command gets the paths of a plan, of a folder of scans, and of the answer to write; append
    them as {plan} {scans} {out} or leave them out. It never gets the truth. A failed command
    counts as "cannot say" and is named.

    Example: fpnet bench open run --cases out/cases --program 'python mine.py' --out out/results

    Example: fpnet bench open run --cases out/cases --program all --out out/results
    """
    tree = common.load(config, settings, seed)
    from fpnet_lab.evaluation.open_benchmark.programs import own_programs, program_named
    from fpnet_lab.evaluation.open_benchmark.protocol import CaseSet
    from fpnet_lab.evaluation.open_benchmark.running import run_programs

    known = own_programs(tree)
    chosen: dict[str, Program] = {}
    for said in programs or ['fpnet']:
        chosen |= program_named(said, known, timeout_s)
    read = CaseSet.read(cases)
    with progress('cases', len(read.cases) * len(chosen)) as advance:
        failures = run_programs(read, chosen, out, lambda: advance(1.0))
    for name, reasons in failures.items():
        for case, reason in reasons.items():
            typer.echo(f'{name} failed on case {case}: {reason}')
    typer.echo(f'{len(read.cases)} answers of {", ".join(chosen)} written to {out}')


@app.command('score')
def score(
    cases: _CasesOption,
    results: Annotated[
        list[Path],
        typer.Option('--results', metavar='DIR', help='Folder that run has written; repeatable.'),
    ],
    markdown: Annotated[
        Path | None, typer.Option('--markdown', metavar='FILE', help='Write the tables.')
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Score the answers of programs: first pose, right, wrong, claims on wrong plans, calibration.

    Example: fpnet bench open score --cases out/cases --results out/results --json out/open.json
    """
    from fpnet_lab.evaluation.open_benchmark.protocol import CaseSet
    from fpnet_lab.evaluation.open_benchmark.running import read_runs
    from fpnet_lab.evaluation.open_benchmark.scoring import open_figures, open_report

    read = CaseSet.read(cases)
    runs = {run.name: run for folder in results for run in read_runs(folder, read)}
    report = open_report(read, list(runs.values()))
    if markdown is not None:
        tables = open_figures(report)[0].values()
        markdown.parent.mkdir(parents=True, exist_ok=True)
        text = '\n\n'.join(table.markdown() for table in tables)
        markdown.write_text(f'{text}\n', encoding='utf-8')
    finish('open', json_path, report)
