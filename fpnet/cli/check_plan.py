# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet check-plan``: check whether a floorplan is usable before a robot drives."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from fpnet.cli import common, verdicts
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError

if TYPE_CHECKING:
    from fpnet.plan_check import DriveTour, PlanCheck


@common.reads_drawing
def command(
    plan: Annotated[Path, typer.Argument(metavar='PLAN', help=common.DRAWING_HELP)],
    said: common.DrawingOptions,
    tours: Annotated[
        int, typer.Option('--tours', min=0, help='Simulated drives, up to a minute each.')
    ] = 2,
    plot: Annotated[
        Path | None, typer.Option('--plot', metavar='PNG', help='Plot rooms and look-alikes.')
    ] = None,
    out: common.OutOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    accept: verdicts.AcceptOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Check whether a floorplan is usable before a robot drives.

    Exits with 1 if the drawing was misread or its scale is uncertain, with the cause and the next
    command, unless you accept it (--accept, here or in fpnet plan). Otherwise it matches the plan
    against itself to find rooms that look alike, drives simulated robots through it until they
    are localized, and gives advice. --out writes report.html and check.json.

    Example: fpnet check-plan my_plan.png --tours 3 --out out/check

    Example: fpnet check-plan plan.yaml --tours 0 --json -
    """
    tree = common.load(config, settings, seed)
    from fpnet.plan_check import check_plan

    invocation = said.invocation(('fpnet', 'check-plan'), plan)
    with verdicts.refusal_as_json(invocation, json_path):
        reading = verdicts.accepting(said.read(plan, tree), accept)
    with progress('checking', total=tours + 1.0) as advance:
        seeds = range(tree.seed, tree.seed + tours)
        check = check_plan(reading, tree, seeds, _simulated_drive(), invocation, advance)
    common.say(f'{plan.name}: {reading.how}', json_path)
    for note in reading.notes:
        common.say(note, json_path)
    for line in _lines(check):
        common.say(line, json_path)
    common.write_json(json_path, check.as_json())
    if plot is not None:
        _draw(plot, check)
    if out is not None:
        from fpnet.report.plan_page import write_plan_report

        write_plan_report(out / common.REPORT_NAME, plan.name, check)
        common.write_json(out / 'check.json', check.as_json())
    if not check.is_readable:
        raise typer.Exit(1)


def _draw(plot: Path, check: PlanCheck) -> None:
    from fpnet.viz.plan_check import save_plan_check

    save_plan_check(plot, check.segmentation, check.similarity)


def _simulated_drive() -> DriveTour:
    """Return the drive simulator of the lab, or a function that names the package to install."""
    try:
        [entry] = entry_points(group='fpnet.plan_tours')
        drive: DriveTour = entry.load()
    except (ImportError, ValueError):
        return _no_drive
    return drive


def _no_drive(*_: object) -> NoReturn:
    raise ConfigError("simulated drives need the lab package: pip install 'fpnet_ros[lab]'")


def _lines(check: PlanCheck) -> Iterator[str]:
    yield from check.verdict.lines()
    from fpnet_core.drawings.wording import said_of_scale

    segmentation, similarity = check.segmentation, check.similarity
    rooms = segmentation.rooms
    area_m2 = sum(room.area_m2 for room in rooms)
    yield (
        f'{len(rooms)} rooms, {area_m2:.0f} m², {len(segmentation.doors)} doors at '
        f'{said_of_scale(check.drawn)}'
    )
    if not check.verdict.is_read:
        return
    yield (
        f'rooms that look like another place: {len(similarity.alone)} from inside, '
        f'{len(similarity.with_neighbours)} also with the adjacent rooms'
    )
    for tour in check.tours:
        found = (
            'not localized'
            if tour.found_after_m is None
            else f'localized after {tour.found_after_m} m'
        )
        error = '' if tour.error_m is None else f', error {tour.error_m} m'
        yield f'drive {tour.seed} of {tour.path_m} m: {found}{error}'
    yield from (f'- {line}' for line in check.advice)
