# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans from the planar scanners of a bag; several are merged in the frame of the base."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
import logging
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fpnet.recordings.bag_gyro import BagGyro
from fpnet.recordings.bag_scans import (
    BagScans,
    Tally,
    choose_odometry,
    read_odometry,
    read_static_transforms,
    read_track,
)
from fpnet_core.config import ScanStamp
from fpnet_core.errors import BagFormatError, CloudFormatError, OdometryError
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.io.bags import BagReader, first_frame
from fpnet_core.io.laser_sweeps import LaserSweep, SweepMerger, mounted
from fpnet_core.io.laserscan import decode_laser
from fpnet_core.io.message_types import LASER_SCANS, ODOMETRY
from fpnet_core.io.messages import stamp_to_ns
from fpnet_core.io.scans import Scan, ScanSource
from fpnet_core.io.topic_names import usable_clouds

_log = logging.getLogger(__name__)


def open_bag(
    path: Path,
    topics: Sequence[str] = (),
    odometry_topic: str | None = None,
    truth_topic: str | None = None,
    scan_stamp: ScanStamp = 'auto',
) -> ScanSource:
    """
    Open the scans of a bag: those on ``topics``, else its cloud, else all its planar scanners.

    One of ``topics`` may be the odometry.

    Raises
    ------
    BagFormatError
        If the bag is damaged, lacks the topic, or has several candidates.
    """
    with BagReader(path) as bag:
        types = bag.topics
    topics, odometry_topic = _split_topics(topics, odometry_topic, types, path)
    lasers = [topic for topic, msgtype in types.items() if msgtype in LASER_SCANS]
    if topics and all(topic in lasers for topic in topics):
        return BagLasers(path, topics, odometry_topic, truth_topic)
    if len(topics) > 1:
        raise BagFormatError(
            f'bag {path}: cannot merge {", ".join(topics)}; name one PointCloud2 topic, or only '
            f'topics with planar scans; the bag has {", ".join(sorted(lasers)) or "none"}'
        )
    if lasers and not topics and not usable_clouds(types):
        return BagLasers(path, sorted(lasers), odometry_topic, truth_topic)
    topic = topics[0] if topics else None
    scans = BagScans(path, topic, odometry_topic, truth_topic, scan_stamp)
    if lasers and not topics:  # the cloud may come from a camera
        text = '%s: using the scans on %s; to use %s instead, pass --topic'
        _log.warning(text, path, scans.cloud_topic, ' or '.join(sorted(lasers)))
    return scans


def _split_topics(
    topics: Sequence[str], odometry_topic: str | None, types: dict[str, str], path: Path
) -> tuple[list[str], str | None]:
    """Split ``topics`` into the scan topics and the odometry topic, which may be among them."""
    odometry = [topic for topic in topics if types.get(topic) == ODOMETRY]
    if odometry and (odometry_topic is not None or len(odometry) > 1):
        raise BagFormatError(
            f'bag {path}: cannot use {", ".join(odometry)} as odometry; name one odometry topic, '
            'and none with --odometry kiss or --poses'
        )
    scans = [topic for topic in topics if topic not in odometry]
    return scans, odometry[0] if odometry else odometry_topic


class BagLasers:
    """
    Sweeps of the planar scanners of a bag.

    Points are in the frame of the robot's base: the child frame of the odometry, else the root of
    ``/tf_static`` above the scanners, else the scanner's own frame. A scan's stamp is the time of
    its last return, whereas a LaserScan is stamped at its first ray. With odometry in the bag,
    the points are deskewed.
    """

    kind: Literal['bag'] = 'bag'

    def __init__(
        self,
        path: Path,
        topics: Sequence[str],
        odometry_topic: str | None = None,
        truth_topic: str | None = None,
    ) -> None:
        self._path = path
        self.topics = tuple(topics)
        with BagReader(path) as bag:
            self.odometry_topic = choose_odometry(bag.topics, odometry_topic, path)
            static = read_static_transforms(bag, path, topics[0])
            self._odometry = read_odometry(bag, self.odometry_topic, path, static, topics[0])
            self._truth = read_track(bag, truth_topic, path)
            self._count = max(bag.count(topic) for topic in topics)
            frames = {topic: first_frame(bag, topic, path) for topic in topics}
            self._places = self._places_of(_one_topic_each(frames, path), static)
            self._gyro: BagGyro | None = None
            if self._odometry is None:
                base = static.root(next(iter(frames.values())))
                self._gyro = BagGyro(bag, path, static, base)

    @property
    def has_poses(self) -> bool:
        """Whether the bag has odometry."""
        return self._odometry is not None

    def __len__(self) -> int:
        """Return the number of sweeps of the scanner with the most."""
        return self._count

    def __iter__(self) -> Iterator[Scan]:
        """Decode, merge and yield the sweeps."""
        tally = Tally(self._path, self.odometry_topic, self._odometry)
        for sweep in self._sweeps():
            yield from tally.usable(self._scan(sweep))
        tally.tell()

    def _sweeps(self) -> Iterator[LaserSweep]:
        merger = SweepMerger(len(self.topics))
        with BagReader(self._path) as bag:
            for index, (topic, recorded_ns, message) in enumerate(bag.messages(self.topics)):
                stamp_ns = stamp_to_ns(message.header.stamp) or recorded_ns
                yield from merger.add(topic, self._mounted(topic, message, stamp_ns, index))
        yield from merger.flush()

    def _mounted(self, topic: str, message: Any, stamp_ns: int, index: int) -> LaserSweep:
        try:
            points = decode_laser(message)
            return mounted(points, stamp_ns, self._places[topic], message.header.frame_id)
        except CloudFormatError as error:
            raise CloudFormatError(f'{self._path}, {topic}, message {index}: {error}') from None

    def _scan(self, sweep: LaserSweep) -> Scan | None:
        truth = None if self._truth is None else self._truth.at(sweep.stamp_ns)
        if self._odometry is None:
            return Scan(
                sweep.stamp_ns,
                sweep.points,
                sweep.time_s,
                T_truth_sensor=truth,
                viewpoints=sweep.viewpoints,
                R_gyro_sensor=None if self._gyro is None else self._gyro.at(sweep.stamp_ns),
            )
        T_odom_first = self._odometry.at(sweep.first_ns)
        T_odom_last = self._odometry.at(sweep.stamp_ns)
        if T_odom_first is None or T_odom_last is None:
            return None
        deskewed = sweep.without_motion(np.linalg.inv(T_odom_first) @ T_odom_last)
        return Scan(sweep.stamp_ns, deskewed.points, None, T_odom_last, truth, deskewed.viewpoints)

    def _places_of(
        self, frames: dict[str, str], static: FrameTree
    ) -> dict[str, NDArray[np.float64]]:
        """Return ``T_base_laser (4, 4)`` of each topic."""
        first = next(iter(frames.values()))
        base = static.root(first) if self._odometry is None else self._odometry.child_frame
        places: dict[str, NDArray[np.float64]] = {}
        for topic, frame in frames.items():
            try:
                places[topic] = static.mount(base, frame)
            except OdometryError as error:
                raise OdometryError(
                    f'bag {self._path}, {topic}: {error}; record /tf_static too, or choose one '
                    'scanner (--topic) and pass its poses (--poses)'
                ) from None
        return places


def _one_topic_each(frames: dict[str, str], path: Path) -> dict[str, str]:
    """Return the frames by topic; refuse two topics of the same scanner."""
    topic_of: dict[str, str] = {}
    for topic, frame in frames.items():
        if frame in topic_of:
            raise BagFormatError(
                f'bag {path}: {topic_of[frame]} and {topic} are from the same scanner {frame!r}; '
                'choose one (--topic)'
            )
        topic_of[frame] = topic
    return frames
