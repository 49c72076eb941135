# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The Python interface: a dozen names, which ``import fpnet`` offers.

    plan = fpnet.read_plan('plan.pdf')
    fpnet.segment(plan).plot()
    fpnet.match(plan, 'robot_map.yaml')
    for output in fpnet.localize(plan, 'drive.bag'):
        print(output)

What these functions return are the values of the core with a short ``repr`` and a picture; they
go wherever the core takes theirs. The ``fpnet`` command does its work through the same functions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from fpnet.api.values import Check, Match, Placed, Plan, RobotMap, Rooms, shown_as
from fpnet.plan_check import check_plan as _check_plan
from fpnet_core.arguments import checked
from fpnet_core.config import FpnetConfig, OdometryChoice
from fpnet_core.differences import find_differences
from fpnet_core.drawings.read import read_plan as _read_plan
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.errors import CloudFormatError, ConfigError, FpnetError, NotPlacedError
from fpnet_core.io.clouds import CLOUD_SUFFIXES, read_cloud
from fpnet_core.io.maps import read_map, states_scale
from fpnet_core.io.recordings import is_recording
from fpnet_core.localizer import create_global_localizer, match_maps
from fpnet_core.localizer.maps import MapMatchStatus, cut_of, match_storeys, segment_robot_map
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.segmentation import segment_submap, segment_unknown_scale
from fpnet_core.sites import Site, Storey
from fpnet_core.sites.site_files import read_site as _read_site
from fpnet_core.submaps import SubmapBuilder, submap_from_cloud, submap_from_grid
from fpnet_core.types import Submap

if TYPE_CHECKING:
    from fpnet.api.run import Run


@checked
def read_plan(
    path: str | Path,
    *,
    resolution: float | None = None,
    length: tuple[float, float, float, float, float] | None = None,
    crop: tuple[int, int, int, int] | None = None,
    storey: int | None = None,
    page: int | None = None,
    layers: Sequence[str] = (),
    mirrored: bool = False,
    config: FpnetConfig | None = None,
) -> Plan:
    """
    Read a drawing of a building, in any format that ``fpnet plan`` reads.

    Parameters
    ----------
    path : image, PDF, SVG, DXF, IFC, or the YAML of a map_server map
    resolution : metres per pixel, where the drawing does not say it
    length : (x1, y1, x2, y2, metres): two places in pixels and the metres between them
    crop : (left, top, right, bottom) in pixels: read this part only
    storey : which of several on one sheet, from 1
    page : of a PDF or TIFF, or storey of an IFC, from 1
    layers : of a DXF that hold walls; none to guess
    mirrored : the drawing is a mirror image: flip it
    config : the defaults if None

    Raises
    ------
    MapFormatError
        If the file cannot be read, an option does not fit it, or it shows no building.
    """
    options = ReadOptions(resolution, length, crop, storey, page, tuple(layers))
    reading = _read_plan(path, options, config)
    return shown_as(Plan, reading.flipped() if mirrored else reading)


@checked
def read_robot_map(
    path: str | Path, config: FpnetConfig | None = None, *, storey: int | None = None
) -> RobotMap:
    """
    Read what a robot has seen: a map image or YAML, a point cloud, or a whole recording.

    Parameters
    ----------
    path : the file or folder
    config : the defaults if None
    storey : of a cloud of several, from 1 at the bottom

    Raises
    ------
    FpnetError
        If the file cannot be read, nothing usable is in it, or it is no cloud and has no storeys.
    """
    path, config = Path(path), config or FpnetConfig()
    if not path.exists():
        raise FpnetError(f'{path} does not exist; give an existing file or folder')
    if path.suffix.lower() in CLOUD_SUFFIXES:
        return RobotMap(submap_from_cloud(read_cloud(path), config.submap, storey), True)
    if storey is not None:
        raise ConfigError(f'{path} is a map of one storey; only clouds have several')
    if is_recording(path):
        return RobotMap(submap_of(path, config), True)
    return RobotMap(submap_from_grid(read_map(path)), states_scale(path))


def submap_of(
    recording: str | Path, config: FpnetConfig, advance: Callable[[], None] = lambda: None
) -> Submap:
    """
    Return the submap of a whole recording; ``advance`` is called after each scan.

    Raises
    ------
    CloudFormatError
        If it holds no usable scan.
    """
    from fpnet_core.io.recordings import (
        open_scans,  # with odometry, slower to load than all maps need
    )
    from fpnet_core.odometry import KissOdometry

    builder, odometry = SubmapBuilder(config.submap), KissOdometry(config.odometry)
    scans = open_scans(Path(recording))
    for scan in scans:
        sweep = scan if scans.has_poses else odometry.register_scan(scan)
        assert sweep.T_odom_sensor is not None  # a source with poses gives one for each scan
        builder.add_scan(sweep.points, sweep.T_odom_sensor, scan.stamp_ns, sweep.viewpoints)
        advance()
    submap = builder.take()
    if submap is None:
        raise CloudFormatError(f'{recording} holds no usable scan; check the range limits')
    return submap


@checked
def segment(subject: Reading | RobotMap | str | Path, config: FpnetConfig | None = None) -> Rooms:
    """
    Cut a floorplan, or what a robot has seen, into rooms and doors.

    Parameters
    ----------
    subject : of :func:`read_plan`, :func:`read_robot_map`, or a file that is read as a plan, or as
        a recording or point cloud where it is one

    Returns
    -------
    Its rooms and doors, in the metres that the plan or map states or is estimated to have; none
    with a reason where there are none.
    """
    config = config or FpnetConfig()
    if isinstance(subject, str | Path):
        is_seen = is_recording(Path(subject)) or Path(subject).suffix.lower() in CLOUD_SUFFIXES
        subject = read_robot_map(subject, config) if is_seen else read_plan(subject, config=config)
    if isinstance(subject, Reading):
        return shown_as(Rooms, subject.segmented(config.segmentation))
    if subject.is_metric:
        return shown_as(Rooms, segment_submap(subject.submap))
    found, _ = segment_unknown_scale(subject.submap, config.segmentation)
    return shown_as(Rooms, found)


@checked
def read_site(path: str | Path, config: FpnetConfig | None = None) -> Site:
    """
    Read the storeys of a site: ``site.yaml``, a folder of maps, or an Open-RMF building.

    Raises
    ------
    FpnetError
        If the description is malformed or contradicts itself, or a plan cannot be read.
    """
    return _read_site(path, config)


@checked
def match_site(
    site: Site, robot_map: RobotMap | str | Path, config: FpnetConfig | None = None
) -> dict[str, Match]:
    """
    Place what a robot has seen on the storeys of a site, by name, the most probable first.

    Raises
    ------
    FpnetError
        If the map cannot be read, or a plan holds no room.
    """
    config = config or FpnetConfig()
    seen = robot_map if isinstance(robot_map, RobotMap) else read_robot_map(robot_map, config)
    plans = {storey.name: cut_of(storey.plan, config) for storey in site.storeys}
    sub = segment_robot_map(seen.submap, config, seen.is_metric)
    found = match_storeys(plans, sub, create_global_localizer(config), StageTimer())
    return {name: shown_as(Match, each) for name, each in found.items()}


@checked
def diff(
    plan: Reading | Site | str | Path,
    robot_map: RobotMap | str | Path,
    config: FpnetConfig | None = None,
) -> Placed:
    """
    Find where a drawing, or the right one of a site's, and what a robot has seen differ.

    Raises
    ------
    NotPlacedError
        If what was seen cannot be placed surely.
    FpnetError
        If a file cannot be read, or a plan holds no room.
    """
    config = config or FpnetConfig()
    seen = robot_map if isinstance(robot_map, RobotMap) else read_robot_map(robot_map, config)
    if isinstance(plan, str | Path):
        plan = read_plan(plan, config=config)
    site = Site('', (Storey('', plan),)) if isinstance(plan, Reading) else plan
    found = next(iter(match_site(site, seen, config).values()))
    if found.status is not MapMatchStatus.MATCHED:
        raise NotPlacedError(f'lost, so the drawing cannot be judged: {found.reason}')
    name = found.storey or site.storeys[0].name
    A_plan_sub = found.candidates.estimates[0].A_plan_submap
    grid = site.storey(name).plan.grid
    return Placed(found, find_differences(found.plan, found.sub, A_plan_sub, grid), name)


@checked
def match(
    plan: Reading | str | Path, robot_map: RobotMap | str | Path, config: FpnetConfig | None = None
) -> Match:
    """
    Place what a robot has seen on a floorplan.

    Parameters
    ----------
    plan, robot_map : as read, or files
    config : the defaults if None

    Raises
    ------
    FpnetError
        If a file cannot be read, or the plan holds no room.
    """
    config = config or FpnetConfig()
    reading = plan if isinstance(plan, Reading) else read_plan(plan, config=config)
    seen = robot_map if isinstance(robot_map, RobotMap) else read_robot_map(robot_map, config)
    matcher = LearnedMatcher(config.matcher)
    found = match_maps(reading, seen.submap, matcher, config, sub_is_metric=seen.is_metric)
    return shown_as(Match, found)


@checked
def localize(
    plan: Reading | Site | str | Path,
    recording: str | Path,
    *,
    poses: str | Path | None = None,
    odometry: OdometryChoice | None = None,
    topics: str | Sequence[str] = (),
    config: FpnetConfig | None = None,
) -> Run:
    """
    Localise a recording on a floorplan, or on one of a site's; see :class:`Run`.

    Parameters
    ----------
    plan : a floorplan or site as read, or a floorplan's file
    recording : bag, CARMEN log, or folder of scans
    poses : of the scans, used as odometry: TUM, KITTI or .npy
    odometry : kiss (KISS-ICP), robot (a bag's own), or both; None: its own where it has one
    topics : of a bag: a PointCloud2, or LaserScans, one or several; none to choose
    config : the defaults if None

    Raises
    ------
    FpnetError
        If a file cannot be read, or there is no such choice of odometry.
    """
    from fpnet.api.run import Run, scans_of  # as above

    config = config or FpnetConfig()
    if isinstance(plan, str | Path):
        plan = read_plan(plan, config=config)
    source = scans_of(
        recording,
        poses=poses,
        odometry=odometry,
        topics=(topics,) if isinstance(topics, str) else topics,
        scan_stamp=config.scans.stamp,
    )
    return Run(plan, source, config, odometry=odometry)


@checked
def check_plan(plan: Reading | str | Path, config: FpnetConfig | None = None) -> Check:
    """
    Tell whether a floorplan will serve: how it was read, what looks alike, what to do.

    ``fpnet check-plan`` drives simulated robots through it beside that.
    """
    config = config or FpnetConfig()
    reading = plan if isinstance(plan, Reading) else read_plan(plan, config=config)
    invocation = Invocation(('fpnet', 'check-plan'), reading.drawing.name)
    checked = _check_plan(reading, config, range(0), _no_drive, invocation, lambda _: None)
    return shown_as(Check, checked)


def _no_drive(*_: object) -> NoReturn:
    raise AssertionError('no drive was asked for')
