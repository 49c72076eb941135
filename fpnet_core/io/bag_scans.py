# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans of a ROS 2 bag: clouds, with odometry and static transforms if the bag has them."""

from __future__ import annotations

from collections.abc import Iterator
import logging
from pathlib import Path
import re
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from fpnet_core.errors import BagFormatError, CloudFormatError
from fpnet_core.geometry.rigid3d import rigid_from_quaternion
from fpnet_core.io.bags import (
    LASER_SCANS,
    ODOMETRY,
    POINT_CLOUD,
    POSE,
    BagReader,
    stamp_to_ns,
)
from fpnet_core.io.pointcloud2 import CloudArrays, decode_points
from fpnet_core.io.scans import Scan
from fpnet_core.stamps import NS_PER_S

_log = logging.getLogger(__name__)

MAX_ODOMETRY_GAP_NS = 500_000_000
"""Poses further apart are not interpolated: a robot may have turned by then. Chosen."""

_TF_STATIC, _TF_MESSAGE = '/tf_static', 'tf2_msgs/msg/TFMessage'
_TRUTH_NAME = re.compile(r'truth|(^|[/_])gt([/_]|$)', re.IGNORECASE)
_KISS_CLOUD = re.compile(r'(^|/)kiss/(frame|keypoints|local_map)$')


class PoseTrack:
    """Poses of one frame over time, interpolated between neighbours."""

    def __init__(
        self, stamps_ns: list[int], poses: list[NDArray[np.float64]], child_frame: str
    ) -> None:
        self._stamps_ns, first = np.unique(np.array(stamps_ns, dtype=np.int64), return_index=True)
        self._poses = np.array(poses)[first]
        self.child_frame = child_frame
        if len(self._stamps_ns) > 1:
            seconds = (self._stamps_ns - self._stamps_ns[0]) / NS_PER_S
            self._slerp = Slerp(seconds, Rotation.from_matrix(self._poses[:, :3, :3]))

    def at(self, stamp_ns: int) -> NDArray[np.float64] | None:
        """Return the pose (4, 4) at a time; None outside the track or in a long gap."""
        after = int(np.searchsorted(self._stamps_ns, stamp_ns))
        if after < len(self._stamps_ns) and self._stamps_ns[after] == stamp_ns:
            exact: NDArray[np.float64] = self._poses[after]
            return exact
        if after in (0, len(self._stamps_ns)):
            return None
        before_ns, after_ns = self._stamps_ns[after - 1], self._stamps_ns[after]
        if after_ns - before_ns > MAX_ODOMETRY_GAP_NS:
            return None
        weight = (stamp_ns - before_ns) / (after_ns - before_ns)
        pose = np.eye(4)
        pose[:3, 3] = (1.0 - weight) * self._poses[after - 1, :3, 3] + (
            weight * self._poses[after, :3, 3]
        )
        pose[:3, :3] = self._slerp((stamp_ns - self._stamps_ns[0]) / NS_PER_S).as_matrix()
        return pose


class BagScans:
    """Clouds of a bag; poses and transforms are read on construction."""

    kind: Literal['bag'] = 'bag'

    def __init__(
        self,
        path: Path,
        cloud_topic: str | None = None,
        odometry_topic: str | None = None,
        truth_topic: str | None = None,
    ) -> None:
        self._path = path
        with BagReader(path) as bag:
            self.cloud_topic = _choose_cloud(bag.topics, cloud_topic, path)
            self.odometry_topic = choose_odometry(bag.topics, odometry_topic, path)
            self._count = bag.count(self.cloud_topic)
            self._odometry = read_track(bag, self.odometry_topic, path)
            self._truth = read_track(bag, truth_topic, path)
            self._static = read_static_transforms(bag, path)

    @property
    def has_poses(self) -> bool:
        """Whether the bag brings odometry."""
        return self._odometry is not None

    def __len__(self) -> int:
        """Count the clouds; those outside the time of the odometry are not yielded."""
        return self._count

    def __iter__(self) -> Iterator[Scan]:
        """Decode and yield the clouds."""
        T_child_sensor: NDArray[np.float64] | None = None
        without_pose = 0
        with BagReader(self._path) as bag:
            for index, (_, recorded_ns, cloud) in enumerate(bag.messages([self.cloud_topic])):
                stamp_ns = stamp_to_ns(cloud.header.stamp) or recorded_ns
                T_odom_child = None if self._odometry is None else self._odometry.at(stamp_ns)
                if self._odometry is not None and T_odom_child is None:
                    without_pose += 1
                    continue
                if T_child_sensor is None:
                    T_child_sensor = self._mounting(cloud.header.frame_id)
                arrays = self._decode(cloud, index)
                yield Scan(
                    stamp_ns,
                    arrays.points,
                    arrays.time_s,
                    None if T_odom_child is None else T_odom_child @ T_child_sensor,
                    None if self._truth is None else self._truth.at(stamp_ns),
                    arrays.viewpoints,
                )
        if without_pose:
            _log.warning(
                '%s: %d of %d clouds lie outside the time of %s and were left out',
                self._path,
                without_pose,
                self._count,
                self.odometry_topic,
            )

    def _decode(self, cloud: Any, index: int) -> CloudArrays:
        try:
            return decode_points(
                cloud.fields,
                cloud.data,
                cloud.point_step,
                cloud.row_step,
                cloud.width,
                cloud.height,
                cloud.is_bigendian,
            )
        except CloudFormatError as error:
            raise CloudFormatError(
                f'{self._path}, {self.cloud_topic}, message {index}: {error}'
            ) from None

    def _mounting(self, sensor_frame: str) -> NDArray[np.float64]:
        """Return where the sensor sits in the frame whose odometry the bag brings."""
        if self._odometry is None:
            return np.eye(4)
        child, sensor = self._odometry.child_frame.strip('/'), sensor_frame.strip('/')
        if child in ('', sensor):
            return np.eye(4)
        root_of_child, T_root_child = to_root(child, self._static)
        root_of_sensor, T_root_sensor = to_root(sensor, self._static)
        if root_of_child != root_of_sensor:
            _log.warning(
                '%s: no static transform between %s and %s; taking them to coincide',
                self._path,
                child,
                sensor,
            )
            return np.eye(4)
        mounting: NDArray[np.float64] = np.linalg.inv(T_root_child) @ T_root_sensor
        return mounting


def usable_clouds(topics: dict[str, str]) -> list[str]:
    """Return the topics, of all with their types, that carry clouds fit for the localizer."""
    clouds = [topic for topic, msgtype in topics.items() if msgtype == POINT_CLOUD]
    # KISS-ICP's frame is deskewed and stamped like the raw cloud, so it will do on its own; its
    # keypoints and local map are no scans.
    raw = [topic for topic in clouds if not _KISS_CLOUD.search(topic)]
    return raw or [topic for topic in clouds if topic.endswith('kiss/frame')]


def _choose_cloud(topics: dict[str, str], wanted: str | None, path: Path) -> str:
    if wanted:
        clouds = [t for t, msgtype in topics.items() if msgtype in (POINT_CLOUD, *LASER_SCANS)]
        return _require(wanted, clouds, topics, path)
    return _the_only(usable_clouds(topics), 'PointCloud2 or LaserScan', '--topic', topics, path)


def choose_odometry(topics: dict[str, str], wanted: str | None, path: Path) -> str | None:
    """Return the topic of the odometry that is meant, None where there is none."""
    odometry = [topic for topic, msgtype in topics.items() if msgtype == ODOMETRY]
    if wanted == '':
        return None
    if wanted:
        return _require(wanted, odometry, topics, path)
    usable = [topic for topic in odometry if not _TRUTH_NAME.search(topic)]
    usable = [topic for topic in usable if topic.endswith('kiss/odometry')] or usable
    if not usable:
        return None
    return _the_only(usable, 'Odometry', 'odometry_topic', topics, path)


def _require(wanted: str, candidates: list[str], topics: dict[str, str], path: Path) -> str:
    if wanted not in candidates:
        kind = topics.get(wanted, 'missing')
        raise BagFormatError(
            f'bag {path}: topic {wanted} is {kind}; expected one of {candidates or "none"}'
        )
    return wanted


def _the_only(
    candidates: list[str], kind: str, option: str, topics: dict[str, str], path: Path
) -> str:
    if len(candidates) == 1:
        return candidates[0]
    if candidates:
        raise BagFormatError(
            f'bag {path} has several {kind} topics: {", ".join(sorted(candidates))}; '
            f'choose one ({option})'
        )
    raise BagFormatError(
        f'bag {path} has no {kind} topic; it holds {", ".join(sorted(topics)) or "nothing"}'
    )


def read_track(bag: BagReader, topic: str | None, path: Path) -> PoseTrack | None:
    """Return the poses on ``topic``; None for no topic, or if it carries no message."""
    if topic is None:
        return None
    msgtype = bag.topics.get(topic)
    if msgtype not in (ODOMETRY, POSE):
        raise BagFormatError(
            f'bag {path}: topic {topic} is {msgtype or "missing"}; expected {ODOMETRY} or {POSE}'
        )
    stamps: list[int] = []
    poses: list[NDArray[np.float64]] = []
    child_frame = ''
    for _, recorded_ns, message in bag.messages([topic]):
        pose = message.pose
        if msgtype == ODOMETRY:
            pose, child_frame = message.pose.pose, message.child_frame_id
        stamps.append(stamp_to_ns(message.header.stamp) or recorded_ns)
        poses.append(_matrix(pose.position, pose.orientation, f'bag {path}, {topic}'))
    return PoseTrack(stamps, poses, child_frame) if stamps else None


def _matrix(translation: Any, rotation: Any, where: str) -> NDArray[np.float64]:
    try:
        return rigid_from_quaternion(
            [translation.x, translation.y, translation.z],
            [rotation.x, rotation.y, rotation.z, rotation.w],
        )
    except ValueError as error:
        raise BagFormatError(f'{where}: {error}') from None


Transforms = dict[str, tuple[str, NDArray[np.float64]]]
"""Parent frame and ``T_parent_child`` by child frame."""


def read_static_transforms(bag: BagReader, path: Path) -> Transforms:
    """Return what ``/tf_static`` holds."""
    transforms: Transforms = {}
    if bag.topics.get(_TF_STATIC) != _TF_MESSAGE:
        return transforms
    for _, _, message in bag.messages([_TF_STATIC]):
        for stamped in message.transforms:
            pose = stamped.transform
            matrix = _matrix(pose.translation, pose.rotation, f'bag {path}, {_TF_STATIC}')
            parent = stamped.header.frame_id.strip('/')
            transforms[stamped.child_frame_id.strip('/')] = (parent, matrix)
    return transforms


def to_root(frame: str, transforms: Transforms) -> tuple[str, NDArray[np.float64]]:
    """Return the root of the tree that ``frame`` is in, and ``T_root_frame``."""
    T_root_frame = np.eye(4)
    for _ in range(len(transforms)):
        if frame not in transforms:
            break
        frame, T_parent_child = transforms[frame]
        T_root_frame = T_parent_child @ T_root_frame
    return frame, T_root_frame
