# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Opens recordings of lidar scans, whatever they are stored in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fpnet_core.config import ScanStamp
from fpnet_core.errors import CloudFormatError, said_of_system
from fpnet_core.io.message_types import BAG_SUFFIXES
from fpnet_core.io.scans import ScanSource
from fpnet_core.plain_files import regular

BAG_NAME = 'bag'
"""Of the bag of a simulated recording, in its folder."""

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
        A bag of ROS 2 (folder, ``.db3`` or ``.mcap``) or ROS 1 (``.bag``), a folder with one
        called ``bag``, as simulated recordings are, a CARMEN log (``.log``, ``.log.gz``), or a
        folder of point files with a pose file.
    topics, odometry_topic, truth_topic
        Topics of a bag: of one cloud, or of planar scanners, which are merged; that of the
        odometry may be named among them. Scans and odometry are found by type, clouds before
        planar scans; ground truth is read only if named. An empty ``odometry_topic`` ignores the
        odometry of the bag.
    scan_stamp
        What of a sweep the stamps of a bag's clouds are of.

    Raises
    ------
    CloudFormatError, BagFormatError, OdometryError
        If the recording is missing, of another kind, damaged, or lacks what is needed.
    """
    path = Path(path)
    if not path.exists():
        raise CloudFormatError(f'recording {path} does not exist')
    try:
        path = bag_within(regular(path))
    except OSError as error:
        raise CloudFormatError(said_of_system(error)) from None
    if _is_bag(path):
        from fpnet_core.io.bag_lasers import open_bag

        return open_bag(path, topics, odometry_topic, truth_topic, scan_stamp)
    if topics or odometry_topic or truth_topic:
        raise CloudFormatError(f'{path} is no bag; topics can be chosen in a bag only')
    if path.is_dir():
        from fpnet_core.io.scan_folders import FolderScans

        return FolderScans(path)
    if path.name.lower().endswith(_CARMEN_SUFFIXES):
        from fpnet_core.io.carmen import CarmenScans

        return CarmenScans(path)
    raise CloudFormatError(
        f'{path}: expected a bag (folder, .db3, .mcap, .bag), a CARMEN log (.log, .log.gz) '
        'or a folder of point files with poses'
    )


def bag_within(path: Path) -> Path:
    """Return the bag of a folder that is none and holds one as simulated recordings do."""
    inside = path / BAG_NAME
    return inside if path.is_dir() and not _is_bag(path) and inside.exists() else path


def is_recording(path: Path | str) -> bool:
    """Tell whether a path is named as a recording of scans is, or is a folder."""
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
