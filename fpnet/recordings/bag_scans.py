# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans of a bag: clouds, with odometry and static transforms if the bag has them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
import logging
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fpnet.recordings.bag_gyro import BagGyro
from fpnet_core.config import ScanStamp
from fpnet_core.errors import BagFormatError, CloudFormatError, OdometryError
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.geometry.pose_track import MAX_GAP_NS, PoseTrack
from fpnet_core.io.bags import BagReader, first_frame
from fpnet_core.io.message_types import (
    ODOMETRY,
    POSE,
    SCANS,
    TRANSFORMS,
)
from fpnet_core.io.messages import StampedTransform, rigid_of, stamp_to_ns, transforms_of
from fpnet_core.io.pointcloud2 import CloudArrays, decode_cloud
from fpnet_core.io.scans import Scan
from fpnet_core.io.sweep_stamps import SweepStamps, in_silence
from fpnet_core.io.topic_names import (
    KISS_ODOMETRY,
    TF_STATIC_TOPIC,
    TF_TOPIC,
    TRUTH_TOPICS,
    is_registered,
    usable_clouds,
)
from fpnet_core.stamps import NS_PER_S

_log = logging.getLogger(__name__)


class BagScans:
    """Clouds of a bag; the constructor reads poses and transforms."""

    kind: Literal['bag'] = 'bag'

    def __init__(
        self,
        path: Path,
        cloud_topic: str | None = None,
        odometry_topic: str | None = None,
        truth_topic: str | None = None,
        scan_stamp: ScanStamp = 'auto',
    ) -> None:
        self._path, self._scan_stamp = path, scan_stamp
        with BagReader(path) as bag:
            self.cloud_topic = _choose_cloud(bag.topics, cloud_topic, path)
            self.odometry_topic = choose_odometry(bag.topics, odometry_topic, path)
            self._count = bag.count(self.cloud_topic)
            self._static = read_static_transforms(bag, path, self.cloud_topic)
            self._odometry = read_odometry(
                bag, self.odometry_topic, path, self._static, self.cloud_topic
            )
            self._truth = read_track(bag, truth_topic, path)
            self._gyro: BagGyro | None = None
            if self._odometry is None and self._count:
                sensor = first_frame(bag, self.cloud_topic, path)
                self._gyro = BagGyro(bag, path, self._static, sensor)

    @property
    def has_poses(self) -> bool:
        """Whether the bag has odometry."""
        return self._odometry is not None

    def __len__(self) -> int:
        """Return the number of clouds; those without an odometry pose are not yielded."""
        return self._count

    def __iter__(self) -> Iterator[Scan]:
        """Decode and yield the clouds."""
        tally = Tally(self._path, self.odometry_topic, self._odometry)
        # KISS-ICP publishes deskewed clouds without times, stamped like their poses.
        log = in_silence if is_registered(self.cloud_topic) else _log.warning
        stamps = SweepStamps(self._scan_stamp, log)
        with BagReader(self._path) as bag:
            for index, (_, recorded_ns, cloud) in enumerate(bag.messages([self.cloud_topic])):
                arrays = self._decode(cloud, index)
                stamp_ns = stamps.pose_ns(arrays, stamp_to_ns(cloud.header.stamp) or recorded_ns)
                truth = None if self._truth is None else self._truth.at(stamp_ns)
                scan = Scan(stamp_ns, arrays.points, arrays.time_s, None, truth, arrays.viewpoints)
                yield from tally.usable(self._placed(scan, cloud.header.frame_id))
        tally.tell()

    def _placed(self, scan: Scan, frame: str) -> Scan | None:
        """Return a scan with its odometry pose, or None if the odometry has none."""
        if self._odometry is None:
            T_base_sensor = self._static.mount(self._static.body(frame), frame)
            R_gyro_sensor = None if self._gyro is None else self._gyro.at(scan.stamp_ns)
            return replace(scan, T_base_sensor=T_base_sensor, R_gyro_sensor=R_gyro_sensor)
        T_odom_child = self._odometry.at(scan.stamp_ns)
        if T_odom_child is None:
            return None
        T_odom_sensor = T_odom_child @ self._mounting(frame)
        T_odom_first = self._odometry.at(scan.first_ns)
        if T_odom_first is not None:
            T_odom_first = T_odom_first @ self._mounting(frame)
            scan = scan.without_motion(np.linalg.inv(T_odom_first) @ T_odom_sensor)
        return replace(scan, T_odom_sensor=T_odom_sensor)

    def _decode(self, cloud: Any, index: int) -> CloudArrays:
        try:
            return decode_cloud(cloud)
        except CloudFormatError as error:
            raise CloudFormatError(
                f'{self._path}, {self.cloud_topic}, message {index}: {error}'
            ) from None

    def _mounting(self, sensor_frame: str) -> NDArray[np.float64]:
        """Return the sensor's mount ``T_child_sensor (4, 4)`` in the odometry's child frame."""
        assert self._odometry is not None  # the caller has checked
        try:
            return self._static.mount(self._odometry.child_frame, sensor_frame)
        except OdometryError as error:
            raise OdometryError(
                f'{self._path}, {self.odometry_topic}: {error}; record /tf_static too, '
                'pass the poses of the sensor (--poses), or choose KISS-ICP (--odometry kiss)'
            ) from None


class Tally:
    """
    Counts the usable and the skipped scans of a bag, and reports the skipped ones at the end.

    A scan stamped before its predecessor is skipped, unless the odometry's clock jumped back too:
    it would get an old pose. The lidar's clock jumped back, or two drivers publish.
    """

    def __init__(self, path: Path, topic: str | None, odometry: PoseTrack | None) -> None:
        self._path, self._topic = path, topic
        self._goes_on = odometry is not None and not odometry.went_back
        self._used = self._unplaced = self._past = self._last_ns = 0

    def usable(self, scan: Scan | None) -> Iterator[Scan]:
        """Yield a scan if it can be used; None stands for a scan without an odometry pose."""
        if scan is None:
            self._unplaced += 1
        elif self._goes_on and scan.stamp_ns <= self._last_ns:
            self._past += 1
        else:
            self._used, self._last_ns = self._used + 1, scan.stamp_ns
            yield scan

    def tell(self) -> None:
        """
        Log how many scans were skipped, and why.

        Raises
        ------
        OdometryError
            If no scan has an odometry pose.
        """
        apart_s = MAX_GAP_NS / NS_PER_S
        why = (
            f'outside the time of {self._topic}, or between poses more than {apart_s} s or half '
            'a turn apart'
        )
        if self._unplaced and not self._used:
            raise OdometryError(
                f'bag {self._path}: all {self._unplaced} scans lie {why}; record odometry more '
                'often, from one publisher and on the clock of the scans, or choose KISS-ICP '
                '(--odometry kiss)'
            )
        total = self._used + self._unplaced + self._past
        if self._unplaced:
            text = '%s: skipped %d of %d scans, which lie %s'
            _log.warning(text, self._path, self._unplaced, total, why)
        if self._past:
            _log.warning(
                '%s: skipped %d of %d scans, which are stamped before their predecessor: do two '
                "drivers share the topic, or was the lidar's clock set during the recording? "
                'KISS-ICP needs no other clock (--odometry kiss)',
                self._path,
                self._past,
                total,
            )


def _choose_cloud(topics: dict[str, str], wanted: str | None, path: Path) -> str:
    if wanted:
        clouds = [t for t, msgtype in topics.items() if msgtype in SCANS]
        return _require(wanted, clouds, topics, path)
    return _the_only(usable_clouds(topics), 'PointCloud2 or LaserScan', topics, path)


def choose_odometry(topics: dict[str, str], wanted: str | None, path: Path) -> str | None:
    """Return the odometry topic to use, or None if there is none."""
    odometry = [topic for topic, msgtype in topics.items() if msgtype == ODOMETRY]
    if wanted == '':
        return None
    if wanted:
        in_tf = [topic for topic, msgtype in topics.items() if msgtype == TRANSFORMS]
        return _require(wanted, odometry + in_tf, topics, path)
    usable = [topic for topic in odometry if not TRUTH_TOPICS.search(topic)]
    usable = [topic for topic in usable if topic.endswith(KISS_ODOMETRY)] or usable
    if not usable:
        return None
    return _the_only(usable, 'Odometry', topics, path)


def _require(wanted: str, candidates: list[str], topics: dict[str, str], path: Path) -> str:
    if wanted not in candidates:
        kind = topics.get(wanted, 'missing')
        raise BagFormatError(
            f'bag {path}: topic {wanted} is {kind}; expected one of {candidates or "none"}'
        )
    return wanted


def _the_only(candidates: list[str], kind: str, topics: dict[str, str], path: Path) -> str:
    if len(candidates) == 1:
        return candidates[0]
    if candidates:
        raise BagFormatError(
            f'bag {path} has several {kind} topics: {", ".join(sorted(candidates))}; '
            'choose one (--topic)'
        )
    raise BagFormatError(
        f'bag {path} has no {kind} topic; it has {", ".join(sorted(topics)) or "nothing"}'
    )


def read_track(bag: BagReader, topic: str | None, path: Path) -> PoseTrack | None:
    """Return the poses on ``topic``; None without a topic or without messages on it."""
    if topic is None:
        return None
    msgtype = bag.topics.get(topic)
    if msgtype not in (ODOMETRY, POSE):
        raise BagFormatError(
            f'bag {path}: topic {topic} is {msgtype or "missing"}; expected {ODOMETRY} or {POSE}'
        )
    track = PoseTrack()
    for _, recorded_ns, message in bag.messages([topic]):
        pose = message.pose
        if msgtype == ODOMETRY:
            pose, track.child_frame = message.pose.pose, message.child_frame_id
        stamp_ns = stamp_to_ns(message.header.stamp) or recorded_ns
        with _as_bag_errors(path, topic):
            track.add(stamp_ns, rigid_of(pose.position, pose.orientation))
    return track if len(track) else None


def read_odometry(
    bag: BagReader, topic: str | None, path: Path, static: FrameTree, scan_topic: str
) -> PoseTrack | None:
    """Return the poses on ``topic``; from TF, those of the topmost frame fixed to the sensor."""
    if topic is None or bag.topics.get(topic) != TRANSFORMS:
        return read_track(bag, topic, path)
    body = static.body(first_frame(bag, scan_topic, path))
    track = PoseTrack(body)
    for each in _transforms(bag, path, [topic], body):
        track.add(each.stamp_ns, each.T_parent_child)
    return track if len(track) else None


def _transforms(
    bag: BagReader, path: Path, topics: list[str], child: str = ''
) -> Iterator[StampedTransform]:
    """Yield all transforms on topics, or only those of one child frame."""
    for topic, _, message in bag.messages(topics):
        with _as_bag_errors(path, topic):
            yield from transforms_of(message, child)


@contextmanager
def _as_bag_errors(path: Path, topic: str) -> Iterator[None]:
    """Turn a ValueError into a BagFormatError that names the bag and the topic."""
    try:
        yield
    except ValueError as error:
        raise BagFormatError(f'bag {path}, {topic}: {error}') from None


def read_static_transforms(bag: BagReader, path: Path, scan_topic: str) -> FrameTree:
    """
    Return the transforms on ``/tf_static``; an empty tree if there are none.

    With several robots, the topic in the namespace of ``scan_topic`` is used. Old ROS 1 robots had
    no ``/tf_static`` and repeated fixed transforms on ``/tf``; these are included.
    """
    tree = FrameTree()
    if bag.is_of_ros_1:
        for (parent, child), places in _edge_samples(bag, path, TF_TOPIC, scan_topic).items():
            if len(places) > 1 and all(np.allclose(place, places[0]) for place in places):
                tree.add_fixed(parent, child, places[0])
    for (parent, child), places in _edge_samples(bag, path, TF_STATIC_TOPIC, scan_topic).items():
        tree.add_fixed(parent, child, places[-1])
    return tree


def _edge_samples(
    bag: BagReader, path: Path, name: str, scan_topic: str
) -> dict[tuple[str, str], list[NDArray[np.float64]]]:
    """Return all ``T_parent_child`` on a robot's transform topics, by parent and child."""
    of_robot = [
        topic
        for topic, msgtype in bag.topics.items()
        if msgtype == TRANSFORMS
        and topic.endswith(name)
        and scan_topic.startswith(topic.removesuffix(name) + '/')
    ]
    found: dict[tuple[str, str], list[NDArray[np.float64]]] = {}
    for each in _transforms(bag, path, of_robot) if of_robot else ():
        found.setdefault((each.parent, each.child), []).append(each.T_parent_child)
    return found
