# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The Python interface, which ``import fpnet`` offers.

    plan = fpnet.read_plan('plan.pdf')
    fpnet.segment(plan).plot()
    fpnet.match(plan, 'robot_map.yaml')
    for output in fpnet.localize(plan, 'drive.bag'):
        print(output)

The functions return values of the core with a short ``repr`` and a plot, which the core accepts
like its own. The ``fpnet`` command uses the same functions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from fpnet.alignment import align_match
from fpnet.api.values import Aligned, Check, Match, Placed, Plan, RobotMap, Rooms, shown_as
from fpnet.plan_check import check_plan as _check_plan
from fpnet.recordings.opening import is_recording
from fpnet_core.arguments import checked
from fpnet_core.config import FpnetConfig, OdometryChoice
from fpnet_core.differences import find_differences
from fpnet_core.drawings.read import read_plan as _read_plan
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.errors import CloudFormatError, ConfigError, FpnetError, NotPlacedError
from fpnet_core.io.clouds import CLOUD_SUFFIXES, read_cloud
from fpnet_core.io.maps import read_map, states_scale
from fpnet_core.localizer import MapMatch, create_global_localizer, match_maps
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
    Parse a drawing of a building, in any format that ``fpnet plan`` supports.

    Parameters
    ----------
    path : image, PDF, SVG, DXF, IFC, or the YAML of a map_server map
    resolution : metres per pixel, if the drawing does not state it
    length : (x1, y1, x2, y2, metres): two points in pixels and their distance
    crop : (left, top, right, bottom) in pixels: read only this part
    storey : which of several on one sheet, from 1
    page : page of a PDF or TIFF, or storey of an IFC, from 1
    layers : layers that hold walls; empty to choose automatically
    mirrored : flip the drawing, which is a mirror image
    config : defaults if None

    Raises
    ------
    MapFormatError
        If the file cannot be read, an option does not apply to it, or it shows no building.
    """
    options = ReadOptions(resolution, length, crop, storey, page, tuple(layers))
    reading = _read_plan(path, options, config)
    return shown_as(Plan, reading.flipped() if mirrored else reading)


@checked
def read_robot_map(
    path: str | Path, config: FpnetConfig | None = None, *, storey: int | None = None
) -> RobotMap:
    """
    Read a robot map: a map image or YAML, a point cloud, or a whole recording.

    Parameters
    ----------
    path : file or folder
    config : defaults if None
    storey : storey of a point cloud with several, from 1 at the bottom

    Raises
    ------
    FpnetError
        If the file cannot be read, is not usable, or ``storey`` is given and it is no cloud.
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
    from fpnet.recordings.opening import (
        open_scans,  # loads odometry, which takes long and maps do not need
    )
    from fpnet_core.odometry import KissOdometry

    builder, odometry = SubmapBuilder(config.submap), KissOdometry(config.odometry)
    scans = open_scans(Path(recording))
    for scan in scans:
        sweep = scan if scans.has_poses else odometry.register_scan(scan)
        assert sweep.T_odom_sensor is not None  # sources with poses have one per scan
        builder.add_scan(sweep.points, sweep.T_odom_sensor, scan.stamp_ns, sweep.viewpoints)
        advance()
    submap = builder.take()
    if submap is None:
        raise CloudFormatError(f'{recording} holds no usable scan; check the range limits')
    return submap


@checked
def segment(subject: Reading | RobotMap | str | Path, config: FpnetConfig | None = None) -> Rooms:
    """
    Segment a floorplan or robot map into rooms and doors.

    Parameters
    ----------
    subject : result of :func:`read_plan` or :func:`read_robot_map`, or a file, which is read as a
        plan unless it is a recording or point cloud

    Returns
    -------
    Rooms and doors, in metres as stated or estimated; an empty result states the reason.
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
        If the description is malformed or contradictory, or a plan cannot be read.
    """
    return _read_site(path, config)


@checked
def match_site(
    site: Site, robot_map: RobotMap | str | Path, config: FpnetConfig | None = None
) -> dict[str, Match]:
    """
    Match a robot map on each storey of a site; return matches by name, most probable first.

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
    Find differences between a drawing, or the right storey of a site, and a robot map.

    Raises
    ------
    NotPlacedError
        If no match of the robot map is accepted.
    FpnetError
        If a file cannot be read, or a plan holds no room.
    """
    found, storey, _ = _best_match(plan, robot_map, config or FpnetConfig())
    if found.status is not MapMatchStatus.MATCHED:
        raise NotPlacedError(f'not placed, so the drawing cannot be checked: {found.reason}')
    A_plan_sub = found.candidates.estimates[0].A_plan_submap
    grid = storey.plan.grid
    return Placed(found, find_differences(found.plan, found.sub, A_plan_sub, grid), storey.name)


@checked
def align(
    plan: Reading | Site | str | Path,
    robot_map: RobotMap | str | Path,
    config: FpnetConfig | None = None,
) -> Aligned:
    """
    Align a robot map with a drawing, or the right storey of a site.

    Parameters
    ----------
    plan, robot_map : as read, or files
    config : defaults if None

    Returns
    -------
    Transform with its covariance, local deformation, residuals by room, differences.

    Raises
    ------
    NotPlacedError
        If no match of the robot map is accepted, or the drawing's mirror image fits as well.
    FpnetError
        If a file cannot be read, or a plan holds no room.
    """
    config = config or FpnetConfig()
    found, storey, seen = _best_match(plan, robot_map, config)
    return align_found(found, storey.plan, seen, config)


def _best_match(
    plan: Reading | Site | str | Path, robot_map: RobotMap | str | Path, config: FpnetConfig
) -> tuple[MapMatch, Storey, RobotMap]:
    """Return the best match of a robot map with a site, its storey, and the map as read."""
    seen = robot_map if isinstance(robot_map, RobotMap) else read_robot_map(robot_map, config)
    site = _as_site(plan, config)
    found = next(iter(match_site(site, seen, config).values()))
    return found, site.storey(found.storey or site.storeys[0].name), seen


def align_found(
    found: MapMatch, plan: Reading, robot_map: RobotMap, config: FpnetConfig
) -> Aligned:
    """Align the robot map of a match with its drawing; raises as :func:`align`."""
    return shown_as(Aligned, align_match(found, plan, robot_map.submap.grid, config))


@checked
def match(
    plan: Reading | str | Path, robot_map: RobotMap | str | Path, config: FpnetConfig | None = None
) -> Match:
    """
    Match a robot map on a floorplan.

    Parameters
    ----------
    plan, robot_map : as read, or files
    config : defaults if None

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
    Localize a recording on a floorplan or site; see :class:`Run`.

    Parameters
    ----------
    plan : floorplan or site as read, or a floorplan's file
    recording : bag, CARMEN log, or folder of scans
    poses : file of scan poses, used as odometry: TUM, KITTI or .npy
    odometry : kiss (KISS-ICP), robot (the bag's), or both; None: the bag's if it has one
    topics : PointCloud2 or LaserScan topics of a bag; empty to choose automatically
    config : defaults if None

    Raises
    ------
    FpnetError
        If a file cannot be read, or ``odometry`` is invalid or not in the recording.
    """
    from fpnet.api.run import Run, scans_of  # see submap_of

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
    Check whether a floorplan is usable: parse, scale, rooms that look alike, advice.

    ``fpnet check-plan`` also drives simulated robots through it.
    """
    config = config or FpnetConfig()
    reading = plan if isinstance(plan, Reading) else read_plan(plan, config=config)
    invocation = Invocation(('fpnet', 'check-plan'), reading.drawing.name)
    checked = _check_plan(reading, config, range(0), _no_drive, invocation, lambda _: None)
    return shown_as(Check, checked)


def _as_site(plan: Reading | Site | str | Path, config: FpnetConfig) -> Site:
    """Return a plan, as read or as a file, as a site of one storey without a name."""
    if isinstance(plan, str | Path):
        plan = read_plan(plan, config=config)
    return Site('', (Storey('', plan),)) if isinstance(plan, Reading) else plan


def _no_drive(*_: object) -> NoReturn:
    raise AssertionError('no simulated drive was requested')
