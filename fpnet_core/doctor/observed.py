# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Input of the doctor's checks: a few seconds of messages, from a bag or from live topics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.geometry.pose_track import PoseTrack
from fpnet_core.io.messages import transforms_of
from fpnet_core.io.topic_names import TF_TOPIC
from fpnet_core.stamps import NS_PER_S

_FIRST = 10  # chosen: messages to compare two clocks, early to exclude later jumps


@dataclass(frozen=True)
class Offer:
    """QoS of a publisher, or requested by a subscriber; ``who`` is the node's name or empty."""

    who: str = ''
    is_reliable: bool = True
    is_latched: bool = False


@dataclass(frozen=True, eq=False)
class Topic:
    """
    Messages of a topic: ``stamps_ns (M,)`` of headers and times of arrival ``heard_ns (M,)``.

    ``frames`` are the headers' frames, ``children`` the child frames of odometry. ``offers`` and
    ``requests`` are the QoS of its publishers and subscribers.
    """

    name: str
    msgtype: str
    stamps_ns: NDArray[np.int64]
    heard_ns: NDArray[np.int64]
    frames: tuple[str, ...] = ()
    children: tuple[str, ...] = ()
    offers: tuple[Offer, ...] = ()
    requests: tuple[Offer, ...] = ()

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.heard_ns)

    @property
    def lag_s(self) -> float:
        """Delay of the first messages from stamp to arrival [s]; NaN without messages."""
        lags = (self.heard_ns - self.stamps_ns)[:_FIRST]
        return float(np.median(lags)) / NS_PER_S if len(lags) else float('nan')


@dataclass(frozen=True, eq=False)
class Transform:
    """``T_parent_child (4, 4)`` as last received on ``/tf`` or ``/tf_static``."""

    parent: str
    child: str
    T_parent_child: NDArray[np.float64]
    is_static: bool


@dataclass(frozen=True, eq=False)
class SeenScan:
    """
    One scan: ``points (P, 3)`` [m] in ``frame``; ``stamp_ns`` is the reference time of its pose.

    ``time_s (P,)`` is None without point times; ``fields`` are the message's field names;
    ``is_planar`` marks a LaserScan.
    """

    frame: str
    stamp_ns: int
    points: NDArray[np.float32]
    time_s: NDArray[np.float64] | None
    fields: tuple[str, ...] = ()
    is_planar: bool = False


@dataclass(frozen=True, eq=False)
class Observed:
    """
    Input of all checks.

    Parameters
    ----------
    seconds
        Duration of the observation.
    topics
        All topics, with or without messages.
    scans, odometry
        Names of the topics to check; empty if none was named and none found.
    transforms
        Latest moving and static transforms.
    sweeps
        Scans of ``scans``, in order.
    track
        Poses of ``odometry``.
    imu, gyro_ns, gyro_radps
        Topic of an IMU, empty without one; stamps ``(R,)`` and angular rates ``(R, 3)``.
    unreadable
        Errors of messages that could not be decoded.
    is_live
        Whether times of arrival are on the clock of the nodes.
    tf
        Topic of the moving transforms.
    """

    seconds: float
    topics: tuple[Topic, ...]
    scans: str = ''
    odometry: str = ''
    transforms: tuple[Transform, ...] = ()
    sweeps: tuple[SeenScan, ...] = ()
    track: PoseTrack = field(default_factory=PoseTrack)
    imu: str = ''
    gyro_ns: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    gyro_radps: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    unreadable: tuple[str, ...] = ()
    is_live: bool = False
    tf: str = TF_TOPIC

    def topic(self, name: str) -> Topic | None:
        """Return a topic by its name, or None."""
        return next((topic for topic in self.topics if topic.name == name), None)

    def of_types(self, *msgtypes: str) -> list[str]:
        """Return the sorted names of the topics of these types."""
        return sorted(topic.name for topic in self.topics if topic.msgtype in msgtypes)

    @property
    def child_frame(self) -> str:
        """Child frame of the odometry; empty if unknown."""
        topic = self.topic(self.odometry)
        return topic.children[0] if topic and topic.children else ''

    @cached_property
    def tree(self) -> FrameTree:
        """Tree of the static transforms."""
        tree = FrameTree()
        for each in self.transforms:
            if each.is_static:
                tree.add_fixed(each.parent, each.child, each.T_parent_child)
        return tree


def heard_transforms(message: Any, is_static: bool) -> Iterator[Transform]:
    """Yield the transforms of a TFMessage; raise ValueError as :func:`transforms_of`."""
    for each in transforms_of(message):
        yield Transform(each.parent, each.child, each.T_parent_child, is_static)
