# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench figures``: write benchmark figures into the documentation pages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet_core.errors import ConfigError

if TYPE_CHECKING:
    from fpnet_lab.provenance import Provenance


def command(
    reports: Annotated[
        list[str],
        typer.Argument(
            metavar='NAME=FILE...',
            help='NAME: for example localization, drawings or robot; repeat it to merge runs.',
        ),
    ],
    pages: Annotated[
        Path, typer.Option('--pages', metavar='DIR', help='Folder of README.md and docs.')
    ] = Path(),
    made_by: Annotated[
        str | None, typer.Option('--command', help='Command of reports without provenance.')
    ] = None,
    commit: Annotated[str, typer.Option('--commit', help='Commit of such reports.')] = '',
    day: Annotated[str, typer.Option('--date', metavar='DAY', help='Date of such reports.')] = '',
) -> None:
    """
    Write tables and figures of benchmark reports between the markers in README and docs.

    Manifests of the packaged weights also hold figures, on data left out in training.

    Example: fpnet bench figures localization=out/bench.json drawings=out/drawings.json

    Example: fpnet bench figures weights_doors=fpnet_core/weights/doors.json
    """
    from fpnet.recordings.truth import read_json
    from fpnet_lab.evaluation.published.figures import pages as pages_of
    from fpnet_lab.evaluation.published.figures import write_figures
    from fpnet_lab.evaluation.published.makers import joined, published
    from fpnet_lab.provenance import Provenance, machine

    given = None if made_by is None else Provenance(made_by, commit, day, machine())
    figures: dict[str, str] = {}
    files: dict[str, list[Path]] = {}
    for each in reports:
        name, _, file = each.partition('=')
        files.setdefault(name, []).append(Path(file))
    for name, paths in files.items():
        read = [read_json(path, 'give a file written by --json') for path in paths]
        made = [_made(report, given, path) for report, path in zip(read, paths, strict=True)]
        figures |= published(name, joined(name, read), *made)
    changed = write_figures(pages_of(pages), figures)
    for page in changed:
        typer.echo(f'wrote {page}')
    if not changed:
        typer.echo('all pages are up to date')


def _made(report: dict[str, Any], given: Provenance | None, file: Path) -> Provenance:
    from fpnet_lab.provenance import Provenance

    made = given or Provenance.of(report) or Provenance.of_weights(report, file)
    if made is None:
        raise ConfigError(f'{file} has no provenance; add --command, --commit and --date')
    return made
