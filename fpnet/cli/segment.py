# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet segment``: segment a floorplan, robot map or recording into rooms and doors."""

from __future__ import annotations

from pathlib import Path
import time
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common, verdicts
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError

if TYPE_CHECKING:
    from fpnet.plan_check.verdict import PlanVerdict
    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading
    from fpnet_core.segmentation import ScaleEstimate
    from fpnet_core.types import Segmentation, Submap


@common.reads_drawing
def command(
    source: Annotated[
        Path,
        typer.Argument(
            metavar='INPUT',
            help='Drawing, map_server YAML, point cloud, bag, CARMEN log or folder of scans.',
        ),
    ],
    said: common.DrawingOptions,
    as_submap: Annotated[
        bool,
        typer.Option('--submap', help='Robot map: unknown space is not a wall.'),
    ] = False,
    plot: Annotated[
        Path | None, typer.Option('--plot', metavar='PNG', help='Plot rooms and doors.')
    ] = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Segment a floorplan, robot map or recording into rooms and doors.

    Lengths are in metres as stated by the input or, for a drawing without a scale, as estimated
    from its rooms and doors; --json has the interval. Lengths of a robot map without a scale
    (--submap) are nominal: multiply them by the printed factor. Exits with 1 without a room.

    Example: fpnet segment plan.png --plot rooms.png --json rooms.json
    """
    tree = common.load(config, settings)
    common.check_input(source)
    reading = None
    subject: Reading | Submap
    if as_submap and _is_drawing(source):
        said.refuse(f'applies to drawings, but {source} is read as a robot map', '--resolution')
        subject, scale_is_known = _read_robot_map(source, said.resolution)
    elif _is_drawing(source):
        subject = reading = said.read(source, tree)
        scale_is_known = True
        common.say_reading(reading, json_path)
    else:
        said.refuse(f'applies to drawings, which {source} is not', '--storey')
        subject, scale_is_known = _read_submap(source, tree, said.storey), True
    segmentation, scale, elapsed_ms = _segment(subject, tree, scale_is_known)
    _print_summary(segmentation, scale, elapsed_ms, json_path)
    report = _report(segmentation, scale, elapsed_ms, reading)
    if reading is not None:
        invocation = said.invocation(('fpnet', 'segment'), source)
        verdict = verdicts.verdict_on(reading, tree, invocation)
        _say_scale_doubts(reading, verdict, json_path)
        report['verdict'] = verdict.as_json()
    common.write_json(json_path, report)
    if plot is not None:
        _draw(segmentation, plot)
    if not segmentation.rooms:
        raise typer.Exit(1)


def _say_scale_doubts(reading: Reading, verdict: PlanVerdict, json_path: Path | None) -> None:
    """Print contradictions to a stated scale; other warnings were printed with the drawing."""
    for reason in verdict.reasons:
        if reason.is_scale and reading.scale.is_known and not verdict.accepted:
            common.say(f'warning: {reason.what}', json_path)


def _read_robot_map(source: Path, resolution_m: float | None) -> tuple[Submap, bool]:
    """Return the submap of a robot map, and whether its scale is known."""
    from fpnet_core.io.maps import read_map, states_scale
    from fpnet_core.submaps import submap_from_grid

    is_stated = resolution_m is not None or states_scale(source)
    return submap_from_grid(read_map(source, resolution_m)), is_stated


def _is_drawing(source: Path) -> bool:
    """Return whether the input, by its name, is a drawing or map, not a cloud or recording."""
    from fpnet.recordings.opening import is_recording
    from fpnet_core.io.clouds import CLOUD_SUFFIXES

    return not is_recording(source) and source.suffix.lower() not in CLOUD_SUFFIXES


def _read_submap(path: Path, tree: FpnetConfig, storey: int | None) -> Submap:
    """Return the submap of a point cloud or of a whole recording."""
    from fpnet.api import submap_of
    from fpnet.recordings.opening import open_scans
    from fpnet_core.io.clouds import CLOUD_SUFFIXES, read_cloud
    from fpnet_core.submaps import submap_from_cloud

    if path.suffix.lower() in CLOUD_SUFFIXES:
        return submap_from_cloud(read_cloud(path), tree.submap, storey)
    if storey is not None:
        raise ConfigError(f'{path} is a recording of one storey; only clouds have several')
    scans = len(open_scans(path))
    with progress('accumulating scans', total=scans) as advance:
        return submap_of(path, tree, lambda: advance(1.0))


def _segment(
    subject: Reading | Submap, tree: FpnetConfig, scale_is_known: bool
) -> tuple[Segmentation, ScaleEstimate, float]:
    """Return the segmentation, its scale in true per nominal metres, and the duration [ms]."""
    from fpnet_core.segmentation import (
        estimate_metres_per_unit,
        segment_submap,
        segment_unknown_scale,
    )
    from fpnet_core.types import Submap

    started = time.perf_counter()
    if not isinstance(subject, Submap):
        segmentation = subject.segmentation
        scale = estimate_metres_per_unit(segmentation)
    elif scale_is_known:
        segmentation = segment_submap(subject)
        scale = estimate_metres_per_unit(segmentation, is_partial=True)
    else:
        segmentation, scale = segment_unknown_scale(subject, tree.segmentation)
    return segmentation, scale, 1e3 * (time.perf_counter() - started)


def _print_summary(
    segmentation: Segmentation, scale: ScaleEstimate, elapsed_ms: float, json_path: Path | None
) -> None:
    rooms, doors = segmentation.rooms, segmentation.doors
    if not rooms:
        common.say(segmentation.reason or 'no room was found', json_path)
        return
    rows = []
    for room in rooms:
        count = sum(room.id in portal.rooms for portal in segmentation.portals)
        x, y = room.centroid
        rows.append((str(room.id), f'{room.area_m2:.1f}', f'{x:.1f}', f'{y:.1f}', str(count)))
    common.show_table(('room', 'area [m²]', 'x [m]', 'y [m]', 'doors'), rows, json_path)
    area_m2 = sum(room.area_m2 for room in rooms)
    common.say(
        f'{len(rooms)} rooms, {area_m2:.0f} m², {len(doors)} doors in {elapsed_ms:.0f} ms; '
        f'doors, rooms and walls suggest a scale factor of {scale.factor:.2f} '
        f'({scale.low:.2f} to {scale.high:.2f} with 90 %)',
        json_path,
    )


def _report(
    segmentation: Segmentation, scale: ScaleEstimate, elapsed_ms: float, reading: Reading | None
) -> dict[str, Any]:
    from fpnet_core.drawings.plan_files import as_json, is_affine
    from fpnet_core.raster.pixels import pixel_to_xy

    grid = segmentation.grid
    affine = pixel_to_xy(grid).matrix
    if reading is not None:
        affine = reading.H_plan_image / reading.H_plan_image[2, 2]
    return {
        'frame': grid.frame,
        'resolution_m': grid.resolution,
        'affine_xy_from_px': affine[:2].tolist() if is_affine(affine) else None,
        'drawing': None if reading is None else as_json(reading),
        'scale': {'factor': scale.factor, 'low': scale.low, 'high': scale.high},
        'rooms': [
            {
                'id': room.id,
                'area_m2': room.area_m2,
                'centroid_xy_m': room.centroid.tolist(),
                'polygon_xy_m': room.polygon.tolist(),
                'observed_fraction': room.observed_fraction,
            }
            for room in segmentation.rooms
        ],
        'doors': [
            {
                'id': portal.door,
                'rooms': list(portal.rooms),
                'width_m': portal.width_m,
                'ends_xy_m': portal.ends.tolist(),
            }
            for portal in segmentation.portals
        ],
        'reason': segmentation.reason,
        'timings_ms': {'segment': round(elapsed_ms, 2)},
    }


def _draw(segmentation: Segmentation, path: Path) -> None:
    from fpnet.viz.pictures import saved_figure
    from fpnet.viz.segmentation import draw_grid, draw_segmentation

    with saved_figure(path, (10.0, 10.0), 120) as figure:
        ax = figure.add_subplot()
        draw_grid(ax, segmentation.grid)
        draw_segmentation(ax, segmentation, with_ids=True)
