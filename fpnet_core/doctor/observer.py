# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Collector of messages for the doctor, from rclpy or from a bag's reader."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.doctor.observed import (
    Observed,
    Offer,
    SeenScan,
    Topic,
    Transform,
    heard_transforms,
)
from fpnet_core.errors import FpnetError
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.geometry.pose_track import PoseTrack
from fpnet_core.io.laserscan import decode_laser
from fpnet_core.io.message_types import IMU, LASER_SCANS, ODOMETRY, TRANSFORMS
from fpnet_core.io.messages import has_gyro, rate_of, rigid_of, stamp_to_ns
from fpnet_core.io.pointcloud2 import decode_cloud
from fpnet_core.io.sweep_stamps import SweepStamps, in_silence
from fpnet_core.io.topic_names import (
    KISS_ODOMETRY,
    TF_STATIC_TOPIC,
    TF_TOPIC,
    TRUTH_TOPICS,
    usable_clouds,
)
from fpnet_core.stamps import NS_PER_S

MOST_SWEEPS = 150
"""Largest number of sweeps that are kept; checks need no more. Chosen."""

_MOST_POINTS = 20_000  # numerical: points kept of a sweep, evenly; KISS-ICP downsamples anyway


@dataclass(eq=False)
class _Heard:
    """Messages of one topic."""

    msgtype: str
    stamps_ns: list[int] = field(default_factory=list)
    heard_ns: list[int] = field(default_factory=list)
    frames: dict[str, None] = field(default_factory=dict)
    children: dict[str, None] = field(default_factory=dict)


class Observer:
    """
    Collects messages of a robot for some time.

    Parameters
    ----------
    types
        Message type of every existing topic.
    scans, odometry
        Topics to use; empty selects the likeliest of their type, ``odometry`` None uses none.
    """

    def __init__(self, types: dict[str, str], scans: str = '', odometry: str | None = '') -> None:
        self.scans = scans or likeliest_scans(types)
        self.odometry = '' if odometry is None else odometry or likeliest_odometry(types)
        self.imu = min((name for name, kind in types.items() if kind == IMU), default='')
        self.tf = tf_beside(types, self.scans)
        self._types = dict(types)
        self._heard = {name: _Heard(msgtype) for name, msgtype in types.items()}
        self._transforms: dict[tuple[str, str, bool], Transform] = {}
        self._sweeps: list[SeenScan] = []
        self._track = PoseTrack()
        self._rates: dict[int, NDArray[np.float64]] = {}
        self._stamps = SweepStamps(say=in_silence)
        self._unreadable: list[str] = []

    @property
    def topics(self) -> list[str]:
        """Topics to subscribe to."""
        wanted = dict.fromkeys((self.scans, self.odometry, self.imu, *self.tf))
        return [name for name in wanted if name in self._types]

    def wanted(self, msgtypes: Collection[str], names: Collection[str]) -> list[str]:
        """Return the topics to check for QoS: the scans, those of ``msgtypes``, and ``names``."""
        of_types = [name for name, msgtype in self._types.items() if msgtype in msgtypes]
        found = dict.fromkeys((self.scans, *of_types, *names))
        return [name for name in found if name in self._types]

    def hear(self, name: str, heard_ns: int, message: Any) -> None:
        """Add a message with its time of arrival [ns]."""
        heard = self._heard[name]
        if heard.msgtype == TRANSFORMS:
            self._take_transforms(heard, name, heard_ns, message)
            return
        if not hasattr(message, 'header'):
            return
        stamp_ns, frame = stamp_to_ns(message.header.stamp), plain_frame(message.header.frame_id)
        heard.stamps_ns.append(stamp_ns)
        heard.heard_ns.append(heard_ns)
        heard.frames[frame] = None
        if heard.msgtype == ODOMETRY:
            self._take_pose(heard, name, stamp_ns or heard_ns, message)
        elif name == self.imu:
            self._take_rate(name, stamp_ns or heard_ns, message)
        elif name == self.scans and len(self._sweeps) < MOST_SWEEPS:
            self._take_scan(heard.msgtype, stamp_ns or heard_ns, frame, message)

    def observed(
        self,
        seconds: float,
        offers: dict[str, tuple[Offer, ...]],
        requests: dict[str, tuple[Offer, ...]] | None = None,
        is_live: bool = False,
    ) -> Observed:
        """Return the collected input of the checks, with QoS offers and requests by topic."""
        asked = defaultdict(tuple, requests or {})
        topics = [
            Topic(
                name,
                heard.msgtype,
                np.array(heard.stamps_ns, dtype=np.int64),
                np.array(heard.heard_ns, dtype=np.int64),
                tuple(heard.frames),
                tuple(heard.children),
                offers.get(name, ()),
                asked[name],
            )
            for name, heard in sorted(self._heard.items())
        ]
        return Observed(
            seconds,
            tuple(topics),
            self.scans,
            self.odometry,
            tuple(self._transforms.values()),
            tuple(self._sweeps),
            self._track,
            self.imu,
            np.array(sorted(self._rates), dtype=np.int64),
            np.array([rate for _, rate in sorted(self._rates.items())]).reshape(-1, 3),
            tuple(self._unreadable),
            is_live,
            self.tf[0],
        )

    def _take_transforms(self, heard: _Heard, name: str, heard_ns: int, message: Any) -> None:
        try:
            for each in heard_transforms(message, is_static=name.endswith(TF_STATIC_TOPIC)):
                self._transforms[each.parent, each.child, each.is_static] = each
        except ValueError as error:
            self._unreadable.append(f'{name}: {error}')
        for stamped in message.transforms:
            heard.stamps_ns.append(stamp_to_ns(stamped.header.stamp))
            heard.heard_ns.append(heard_ns)

    def _take_pose(self, heard: _Heard, name: str, stamp_ns: int, message: Any) -> None:
        if child := plain_frame(message.child_frame_id):
            heard.children[child] = None
        if name != self.odometry:
            return
        pose = message.pose.pose
        try:
            self._track.add(stamp_ns, rigid_of(pose.position, pose.orientation))
        except ValueError as error:
            self._unreadable.append(f'{name}: {error}')

    def _take_rate(self, name: str, stamp_ns: int, message: Any) -> None:
        if not has_gyro(message):
            return
        try:
            self._rates[stamp_ns] = rate_of(message)
        except ValueError as error:
            self._unreadable.append(f'{name}: {error}')

    def _take_scan(self, msgtype: str, stamp_ns: int, frame: str, message: Any) -> None:
        try:
            self._sweeps.append(_scan(msgtype, stamp_ns, frame, message, self._stamps))
        except FpnetError as error:
            self._unreadable.append(str(error))


def _scan(msgtype: str, stamp_ns: int, frame: str, message: Any, stamps: SweepStamps) -> SeenScan:
    """Decode a scan, stamped at the end of its sweep as in the nodes."""
    if msgtype in LASER_SCANS:
        seen = decode_laser(message)
        last_ns = stamp_ns + round(float(seen.time_s.max(initial=0.0)) * NS_PER_S)
        return SeenScan(frame, last_ns, seen.points, seen.time_s, is_planar=True)
    names = tuple(each.name for each in message.fields)
    cloud = decode_cloud(message)
    step = max(1, len(cloud.points) // _MOST_POINTS)
    times = None if cloud.time_s is None else cloud.time_s[::step]
    return SeenScan(frame, stamps.pose_ns(cloud, stamp_ns), cloud.points[::step], times, names)


def tf_beside(types: Collection[str], scans: str) -> tuple[str, str]:
    """Return the topics of TF and static TF, in the scans' namespace if it has them."""
    namespace = scans
    while namespace:
        namespace = namespace.rpartition('/')[0]
        if namespace + TF_TOPIC in types or namespace + TF_STATIC_TOPIC in types:
            break
    return namespace + TF_TOPIC, namespace + TF_STATIC_TOPIC


def likeliest_scans(types: dict[str, str]) -> str:
    """Return the likeliest topic of scans, clouds before planar scans; empty if none."""
    clouds = usable_clouds(types)
    lasers = [topic for topic, msgtype in types.items() if msgtype in LASER_SCANS]
    return next(iter(sorted(clouds) or sorted(lasers)), '')


def likeliest_odometry(types: dict[str, str]) -> str:
    """Return the likeliest odometry topic, KISS-ICP's first; empty if none."""
    found = [name for name, msgtype in types.items() if msgtype == ODOMETRY]
    usable: Iterable[str] = [name for name in found if not TRUTH_TOPICS.search(name)]
    return min(usable, key=lambda name: (not name.endswith(KISS_ODOMETRY), name), default='')
