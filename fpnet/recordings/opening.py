# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Entry point to open recordings of lidar scans in any supported format."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fpnet_core.config import ScanStamp
from fpnet_core.errors import CloudFormatError, said_of_system
from fpnet_core.io.message_types import BAG_SUFFIXES
from fpnet_core.io.scans import ScanSource
from fpnet_core.plain_files import regular

BAG_NAME = 'bag'
"""Name of the bag in the folder of a simulated recording."""

_CARMEN_SUFFIXES = ('.log', '.log.gz', '.clf', '.clf.gz')


def open_scans(
    path: Path | str,
    *,
    topics: Sequence[str] = (),
    odometry_topic: str | None = None,
    truth_topic: str | None = None,
    scan_stamp: ScanStamp = 'auto',
) -> ScanSource:
    """
    Open a recording of lidar scans.

    Parameters
    ----------
    path
        A bag of ROS 2 (folder, ``.db3`` or ``.mcap``) or ROS 1 (``.bag``), a folder that contains
        a bag called ``bag`` (simulated recordings), a CARMEN log (``.log``, ``.log.gz``), or a
        folder of point files with a pose file.
    topics, odometry_topic, truth_topic
        Topics of a bag. ``topics`` names one cloud, or planar scanners, which are merged, and
        possibly the odometry. By default scans and odometry are found by type, clouds before
        planar scans. Ground truth is read only if named. An empty ``odometry_topic`` ignores the
        odometry of the bag.
    scan_stamp
        Part of the sweep (start, middle or end) at which clouds in a bag are stamped.

    Raises
    ------
    CloudFormatError, BagFormatError, OdometryError
        If the recording is missing, of unknown format, damaged or incomplete.
    """
    path = Path(path)
    if not path.exists():
        raise CloudFormatError(f'recording {path} does not exist')
    try:
        path = bag_within(regular(path))
    except OSError as error:
        raise CloudFormatError(said_of_system(error)) from None
    if _is_bag(path):
        from fpnet.recordings.bag_lasers import open_bag

        return open_bag(path, topics, odometry_topic, truth_topic, scan_stamp)
    if topics or odometry_topic or truth_topic:
        raise CloudFormatError(f'{path} is not a bag; topics can only be chosen in a bag')
    if path.is_dir():
        from fpnet.recordings.scan_folders import FolderScans

        return FolderScans(path)
    if path.name.lower().endswith(_CARMEN_SUFFIXES):
        from fpnet.recordings.carmen import CarmenScans

        return CarmenScans(path)
    raise CloudFormatError(
        f'{path}: expected a bag (folder, .db3, .mcap, .bag), a CARMEN log (.log, .log.gz) '
        'or a folder of point files with poses'
    )


def bag_within(path: Path) -> Path:
    """Return the bag inside the folder of a simulated recording, else ``path`` itself."""
    inside = path / BAG_NAME
    return inside if path.is_dir() and not _is_bag(path) and inside.exists() else path


def is_recording(path: Path | str) -> bool:
    """Return whether a path is a folder or has the suffix of a recording."""
    path = Path(path)
    is_log = path.name.lower().endswith(_CARMEN_SUFFIXES)
    return path.is_dir() or is_log or _is_bag_file(path)


def _is_bag(path: Path) -> bool:
    if path.is_file():
        return _is_bag_file(path)
    return (path / 'metadata.yaml').exists() or any(
        entry.suffix.lower() in BAG_SUFFIXES for entry in path.iterdir()
    )


def _is_bag_file(path: Path) -> bool:
    return path.suffix.lower() in BAG_SUFFIXES
