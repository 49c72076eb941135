# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet diff``: find differences between a drawing and a recording or robot map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.exits import NO_ANSWER
from fpnet.cli.plans import read_plans, write_differences

if TYPE_CHECKING:
    from fpnet_core.differences import Differences


@common.reads_drawing
def command(
    seen: Annotated[
        Path,
        typer.Argument(metavar='SEEN', help='Recording, map image or YAML, or point cloud.'),
    ],
    said: common.DrawingOptions,
    plan: common.FloorplanOption = None,
    site: common.SiteOption = None,
    out: common.OutOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Find where a drawing is out of date: walls that it lacks, and drawn walls that are gone.

    The recording or robot map is first placed on the drawing, or on a storey of the site. Exits
    with 3 if that fails: the drawing cannot be checked then. Furniture and closed doors are not
    reported as walls. Each difference has a confidence. --out writes differences.geojson, in
    metres of the drawing's frame, and differences.png.

    Example: fpnet diff drive/ --floorplan plan.yaml --out out/diff

    Example: fpnet diff robot_map.yaml --site site.yaml --json -
    """
    tree = common.load(config, settings, seed)
    from fpnet.api import diff, read_robot_map
    from fpnet_core.errors import NotPlacedError

    common.check_input(seen)
    plans = read_plans(plan, site, said, tree, json_path)
    robot_map = read_robot_map(seen, tree)
    try:
        placed = diff(plans, robot_map, tree)
    except NotPlacedError as error:
        common.say(str(error), json_path)
        common.write_json(json_path, {'status': 'lost', 'reason': str(error)})
        raise typer.Exit(NO_ANSWER) from None
    found = placed.differences
    _say(found, json_path)
    common.write_json(json_path, _report(found, placed.storey))
    if out is not None:
        write_differences(out, found)


def _say(found: Differences, json_path: Path | None) -> None:
    likely = found.likely
    if not likely:
        common.say('no differences from the drawing', json_path)
    for each in likely:
        x, y = each.ends.mean(axis=0)
        common.say(
            f'{each.kind.value}: {each.length_m:.1f} m at x {x:.1f} y {y:.1f} '
            f'(p {each.confidence:.2f})',
            json_path,
        )


def _report(found: Differences, storey: str) -> dict[str, Any]:
    from fpnet.geojson import as_geojson

    named = {'storey': storey} if storey else {}
    return {'status': 'placed', **named, 'differences': as_geojson(found)}
