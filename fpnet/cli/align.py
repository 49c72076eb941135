# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet align``: align a robot map with a floorplan, and export each in the other's frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from fpnet.cli import common
from fpnet.cli.exits import NO_ANSWER
from fpnet.cli.match import matched, report_match
from fpnet.cli.plans import read_plans

_COLUMNS = (
    'room', 'm²', 'wall [m]', 'furniture [m]', 'median [m]', '90 % [m]', 'deformed [m]',
    'explained [%]',
)  # fmt: skip


@common.reads_drawing
def command(
    submap: common.SubmapOption,
    said: common.DrawingOptions,
    plan: common.FloorplanOption = None,
    site: common.SiteOption = None,
    submap_storey: common.SubmapStoreyOption = None,
    out: common.OutOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Align a robot map with a floorplan, or a storey of a site, and export both ways.

    The map is placed as by fpnet match. Prints the transform, the local deformation of the
    drawing and, by room, the distances of observed walls to drawn ones. --out writes the
    transform (alignment.json), a picture, the robot map in the drawing's frame, an Open-RMF
    building with the robot map as a layer, and the drawing corrected by the robot map with its
    confidence (map_server, DXF). Exits with 3 if no match is accepted, or if the mirror image of
    the drawing fits as well.

    Example: fpnet align --floorplan plan.pdf --submap robot_map.yaml --out out/align
    """
    tree = common.load(config, settings, seed)
    from fpnet.api import align_found, read_robot_map
    from fpnet_core.errors import NotPlacedError
    from fpnet_core.localizer.maps import MapMatchStatus

    common.check_input(submap)
    plans = read_plans(plan, site, said, tree, json_path)
    seen = read_robot_map(submap, tree, storey=submap_storey)
    found = matched(plans, seen, tree)
    given = common.typed_settings(config, settings)
    given += [] if submap_storey is None else ['--submap-storey', str(submap_storey)]
    typed = said.typed(('align', '--submap', str(submap), *given), plan, site)
    if found.best.status is not MapMatchStatus.MATCHED:
        common.write_json(json_path, report_match(found, seen, tree, typed, said, json_path))
        raise typer.Exit(NO_ANSWER)
    try:
        aligned = align_found(found.best, found.plan, seen, tree)
    except NotPlacedError as error:
        common.say(f'ambiguous: {error}', json_path)
        common.write_json(json_path, {'status': 'ambiguous', 'reason': str(error)})
        raise typer.Exit(NO_ANSWER) from None
    report = aligned.as_json()
    _say(report, json_path)
    try:
        if out is not None:
            report['files'] = aligned.write(out)
            common.say(f'wrote {len(report["files"])} files to {out}', json_path)
    finally:  # a library that only files need may be missing
        common.write_json(json_path, report)


def _say(report: dict[str, Any], json_path: Path | None) -> None:
    """Print the result of an alignment."""
    (_, _, x), (_, _, y), _ = report['T_plan_map']
    cov, bent, walls = report['covariance'], report['deformation'], report['walls']
    true_m = report['true_metres_per_plan_metre']
    lines = (
        f'{report["status"]} (p {report["probability"]:.2f}): {report["reason"]}',
        f'map in plan: x {x:.2f} m, y {y:.2f} m, yaw {report["yaw_deg"]:.2f} deg, '
        f'scale {report["scale"]:.4f}',
        f'standard deviation at the middle of the map: {true_m * cov["sigma_x_m"]:.2f} m, '
        f'{true_m * cov["sigma_y_m"]:.2f} m, {cov["sigma_yaw_deg"]:.2f} deg',
        f'local deformation of the drawing: {bent["rms_m"]:.2f} m RMS, at most '
        f'{bent["max_m"]:.2f} m',
    )
    for line in lines:
        common.say(line, json_path)
    rows = [_row(each) for each in report['rooms']]
    whole = {'room': None, 'name': 'all', 'area_m2': None}
    common.show_table(_COLUMNS, [*rows, _row(whole | walls)], json_path)


def _row(values: dict[str, Any]) -> tuple[str, ...]:
    digits = {'area_m2': 1, 'walls_m': 1, 'furniture_m': 1}
    digits |= {'median_m': 2, 'p90_m': 2, 'deformed_m': 2}
    share = values['explained']
    return (
        values['name'] or str(values['room']),
        *('' if values[key] is None else f'{values[key]:.{n}f}' for key, n in digits.items()),
        '' if share is None else f'{100.0 * share:.0f}',
    )
