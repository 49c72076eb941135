# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate recording``: a lidar recording in a generated building, with ground truth."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError
from fpnet_lab.cli.options import complete_building, complete_family, complete_sensor, named

if TYPE_CHECKING:
    from fpnet_core.types import GridMap
    from fpnet_lab.sim.drives.visits import RecordingOptions

_Storage = Literal['sqlite3', 'mcap']


@common.reads_drawing
def command(
    said: common.DrawingOptions,
    out: common.OutOption = None,
    seed: common.SeedOption = None,
    family: Annotated[
        str | None,
        typer.Option(
            '--family',
            metavar='NAME',
            help='Layout family of the building; default: random.',
            autocompletion=complete_family,
        ),
    ] = None,
    wheels: Annotated[
        bool,
        typer.Option('--wheels', help='Add wheel odometry, which then replaces scan matching.'),
    ] = False,
    imu: Annotated[
        bool, typer.Option('--imu', help='Add the angular rates of a gyroscope in the lidar.')
    ] = False,
    pace: Annotated[
        str,
        typer.Option(
            '--pace',
            metavar='NAME',
            help='robot, or walk: 1.5 m/s, turns of up to 430 degrees a second.',
        ),
    ] = 'robot',
    building: Annotated[
        str,
        typer.Option(
            '--building',
            metavar='STYLE',
            help='plain, lived_in (door leaves, shut doors, windows), frameless (doors up to the '
            'ceiling) or glass.',
            autocompletion=complete_building,
        ),
    ] = 'plain',
    plan: Annotated[
        Path | None,
        typer.Option('--floorplan', metavar='F', help='Use the building on this drawing or map.'),
    ] = None,
    mesh: Annotated[
        Path | None,
        typer.Option(
            '--mesh', metavar='FILE', help='Use this PLY, OBJ or STL mesh; metres, z up.'
        ),
    ] = None,
    storage: Annotated[
        _Storage, common.choice('--storage', _Storage, 'Format of the bag.')
    ] = 'sqlite3',
    sensor: Annotated[
        str,
        typer.Option(
            '--sensor',
            metavar='NAME',
            help='beams16, beams32, beams64, dome (360 x 59 degrees, not repetitive), rosette '
            '(70 degrees ahead, not repetitive) or planar.',
            autocompletion=complete_sensor,
        ),
    ] = 'beams32',
    laser_scans: Annotated[
        bool,
        typer.Option('--laser-scan', help='LaserScans on /scan, from a planar sensor.'),
    ] = False,
    json_path: common.JsonOption = None,
) -> None:
    """
    Write a lidar recording in a building, the building's floorplan, and the truth.

    By default the building is generated, with an inexact floorplan. --floorplan uses the building
    on your drawing; with --mesh, --floorplan is the mesh's plan in the same x and y.

    Writes bag/ (PointCloud2 or LaserScan at 10 Hz), floorplan.yaml with its image, truth.tum (true
    sensor poses in the building) and truth.json (distortion of the floorplan).

    Example: fpnet simulate recording --out out/recording --seed 3 --sensor beams16
    """
    if family is not None and (plan or mesh):
        raise ConfigError('--family is for generated buildings; omit --floorplan and --mesh')
    from fpnet_lab.sim.drives.mesh_worlds import read_mesh
    from fpnet_lab.sim.drives.recording import make_recording, write_recording

    folder = out if out is not None else Path('out') / 'recording'
    recording = make_recording(
        seed or 0,
        _options(family, sensor, laser_scans, building, pace),
        floorplan=_read(plan, said, json_path) if plan else None,
        mesh=read_mesh(mesh) if mesh else None,
    )
    with progress('casting scans', total=len(recording)) as advance:
        write_recording(
            recording,
            folder,
            storage=storage,
            with_wheels=wheels,
            with_imu=imu,
            laser_scans=laser_scans,
            progress=lambda _done, _total: advance(1.0),
        )
    common.write_json(json_path, summary := recording.summary())
    common.say(
        f'{summary["family"]}: {summary["rooms"]} rooms, {summary["path_m"]:.0f} m through '
        f'{len(summary["tour_rooms"])} of them; {summary["scans"]} scans written to {folder}',
        json_path,
    )


def _options(
    family: str | None, sensor: str, laser_scans: bool, building: str, pace: str
) -> RecordingOptions:
    from fpnet_lab.sim.buildings.fittings import BUILDING_STYLES
    from fpnet_lab.sim.drives.driving import PACES
    from fpnet_lab.sim.drives.laser_scans import check_planar
    from fpnet_lab.sim.drives.tours import TourLimits
    from fpnet_lab.sim.drives.visits import RecordingOptions
    from fpnet_lab.sim.lidars.sensors import SENSORS

    lidar = named('sensor', sensor, SENSORS)
    if laser_scans:
        check_planar(lidar)
    style = named('building style', building, BUILDING_STYLES)
    limits = TourLimits(motion=named('pace', pace, PACES))
    return RecordingOptions(family=family, lidar=lidar, style=style, limits=limits)


def _read(plan: Path, said: common.DrawingOptions, json_path: Path | None) -> GridMap:
    reading = said.read(plan, common.load(None))
    common.say_reading(reading, json_path)
    return reading.grid
