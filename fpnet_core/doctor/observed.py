# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What was heard of a robot in a few seconds: of a bag or of live topics, the same values."""

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

_FIRST = 10  # messages that tell two clocks apart, before either may jump; chosen


@dataclass(frozen=True)
class Offer:
    """QoS of one publisher, or what a subscriber asks for; ``who`` is a node, or empty."""

    who: str = ''
    is_reliable: bool = True
    is_latched: bool = False


@dataclass(frozen=True, eq=False)
class Topic:
    """
    What came on a topic: times ``stamps_ns (M,)`` in headers and ``heard_ns (M,)`` of arrival.

    ``frames`` are those of the headers, ``children`` those of odometry. ``offers`` and
    ``requests`` are of its publishers and of the subscribers that take part.
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
        """Count the messages."""
        return len(self.heard_ns)

    @property
    def lag_s(self) -> float:
        """By how much the first arrivals are behind their stamps [s]; NaN without messages."""
        lags = (self.heard_ns - self.stamps_ns)[:_FIRST]
        return float(np.median(lags)) / NS_PER_S if len(lags) else float('nan')


@dataclass(frozen=True, eq=False)
class Transform:
    """``T_parent_child (4, 4)`` as it came last on ``/tf`` or ``/tf_static``."""

    parent: str
    child: str
    T_parent_child: NDArray[np.float64]
    is_static: bool


@dataclass(frozen=True, eq=False)
class SeenScan:
    """
    One scan: ``points (P, 3)`` [m] in ``frame``; ``stamp_ns`` is what its pose is of.

    ``time_s (P,)`` None: without times; ``fields`` are the names in the message; ``is_planar``:
    of a LaserScan.
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
    Everything that the checks look at.

    Parameters
    ----------
    seconds
        For how long was listened.
    topics
        All of them, heard or not.
    scans, odometry
        Names of the topics that are meant; empty: none was named and none found.
    transforms
        Of ``tf`` and the static ones.
    sweeps
        Scans of ``scans``, in order.
    track
        Poses of ``odometry``.
    imu, gyro_ns, gyro_radps
        Topic of an IMU, empty without one; stamps ``(R,)`` and angular rates ``(R, 3)``.
    unreadable
        What was wrong with scans that could not be decoded.
    is_live
        Arrival was measured by the clock that the nodes follow.
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
        """Return a topic by its name; None where there is none."""
        return next((topic for topic in self.topics if topic.name == name), None)

    def of_types(self, *msgtypes: str) -> list[str]:
        """Return the names of the topics that carry one of these types."""
        return sorted(topic.name for topic in self.topics if topic.msgtype in msgtypes)

    @property
    def child_frame(self) -> str:
        """Whose poses the odometry gives; empty where it does not say."""
        topic = self.topic(self.odometry)
        return topic.children[0] if topic and topic.children else ''

    @cached_property
    def tree(self) -> FrameTree:
        """Where sensors sit on the robot."""
        tree = FrameTree()
        for each in self.transforms:
            if each.is_static:
                tree.add_fixed(each.parent, each.child, each.T_parent_child)
        return tree


def heard_transforms(message: Any, is_static: bool) -> Iterator[Transform]:
    """Yield the transforms of a TFMessage; ValueError as :func:`transforms_of`."""
    for each in transforms_of(message):
        yield Transform(each.parent, each.child, each.T_parent_child, is_static)
