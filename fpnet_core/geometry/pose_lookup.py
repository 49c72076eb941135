# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pose lookup of sensor and base, from odometry messages or from TF."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fpnet_core.geometry.frame_tree import FrameTree, plain_frame
from fpnet_core.geometry.pose_track import Array, PoseTrack
from fpnet_core.stamps import NS_PER_S

_HORIZON_NS = 10 * NS_PER_S  # numerical: as in FrameTree; older scans get no pose


@dataclass(frozen=True, eq=False)
class SensorPose:
    """
    Poses (4, 4) of a sensor and of the robot's base at one time.

    ``T_odom_...`` are in the odometry's frame. ``T_tf_odom`` maps that frame to ``tf_frame``, the
    one that the localizer's TF refers to; it is the identity if both are the same.
    """

    odom_frame: str
    T_odom_sensor: Array
    T_odom_base: Array
    tf_frame: str
    T_tf_odom: Array


class PoseLookup:
    """
    Combines odometry messages, TF and static transforms.

    Poses from odometry messages are kept out of the TF tree: a frame has only one parent there,
    and the robot may already publish ``odom -> base_link``. The two are connected at the robot's
    base, whose pose is known in both.

    Parameters
    ----------
    from_tf
        Take poses from ``odom_frame`` in TF; else from messages, see :meth:`add_pose`.
    odom_frame
        Frame of the robot's TF tree to publish TF for. Empty: the odometry's frame.
    base_frame
        Frame to localize. Empty: the ``child_frame_id`` of the odometry's messages, or in TF the
        topmost frame that the sensor is fixed to.
    """

    def __init__(
        self, *, from_tf: bool = False, odom_frame: str = '', base_frame: str = ''
    ) -> None:
        self.tree = FrameTree()
        self._from_tf, self._tf_frame, self._base = from_tf, odom_frame, base_frame
        self._odom = odom_frame if from_tf else ''
        self._track: PoseTrack | None = None

    @property
    def base_frame(self) -> str:
        """Frame to localize; empty until it is known."""
        return self._base or ('' if self._track is None else self._track.child_frame)

    @property
    def needs_tf(self) -> bool:
        """Whether moving transforms (``/tf``) are needed."""
        return bool(self._tf_frame)

    def clear(self) -> None:
        """Remove all moving transforms and odometry poses."""
        self.tree.clear()
        self._track = None

    def add_pose(self, odom: str, child: str, T_odom_child: Array, stamp_ns: int) -> None:
        """Add a pose of the odometry."""
        child = plain_frame(child)
        if self._track is None or self._track.child_frame != child or self._odom != odom:
            self._track = PoseTrack(child, _HORIZON_NS)
        self._odom = odom
        self._track.add(stamp_ns, T_odom_child)

    def pose(self, frame: str, stamp_ns: int) -> Array | None:
        """Return ``T_odom_frame (4, 4)`` of a frame on the robot, or None if it is unknown."""
        if self._from_tf:
            return self.tree.lookup(self._odom, frame, stamp_ns)
        T_odom_child = None if self._track is None else self._track.at(stamp_ns)
        if self._track is None or T_odom_child is None or not self._track.child_frame:
            return None
        T_child_frame = self.tree.lookup(self._track.child_frame, frame, stamp_ns)
        return None if T_child_frame is None else T_odom_child @ T_child_frame

    def sensor_pose(self, sensor: str, stamp_ns: int) -> SensorPose | None:
        """Return the sensor's pose, or None if a transform is missing, see :meth:`reason`."""
        base = self.base_frame or self.tree.body(sensor)
        T_odom_sensor, T_odom_base = self.pose(sensor, stamp_ns), self.pose(base, stamp_ns)
        if T_odom_sensor is None or T_odom_base is None:
            return None
        if self._from_tf or not self._tf_frame:
            odom = self._odom
            return SensorPose(odom, T_odom_sensor, T_odom_base, odom, np.eye(4))
        T_tf_base = self.tree.lookup(self._tf_frame, base, stamp_ns)
        if T_tf_base is None:
            return None
        T_tf_odom = T_tf_base @ np.linalg.inv(T_odom_base)
        return SensorPose(self._odom, T_odom_sensor, T_odom_base, self._tf_frame, T_tf_odom)

    def motion(self, frame: str, first_ns: int, last_ns: int) -> Array | None:
        """Return the motion ``T_first_last (4, 4)`` of a frame between two times, or None."""
        T_odom_first, T_odom_last = self.pose(frame, first_ns), self.pose(frame, last_ns)
        if T_odom_first is None or T_odom_last is None:
            return None
        T_first_last: Array = np.linalg.inv(T_odom_first) @ T_odom_last
        return T_first_last

    def reason(self, sensor: str, stamp_ns: int) -> str:
        """Return a message that explains why :meth:`sensor_pose` returned None."""
        tree, base = self.tree, self.base_frame
        if not self._from_tf and self._track is None:
            return f'no odometry received for scans in {sensor!r}'
        moving = (base or sensor) if self._track is None else self._track.child_frame
        for frame in (sensor, base or sensor):
            if not moving or tree.root(moving) != tree.root(frame):
                return tree.reason(moving, frame, stamp_ns)
        if self._track is not None and self._track.at(stamp_ns) is None:
            why = self._track.reason(stamp_ns)
            return f'{moving!r} in {self._odom!r} is unknown at {stamp_ns} ns: {why}'
        if tree.root(base or sensor) != tree.root(self._tf_frame):
            if moved := tree.children(self._tf_frame):  # it exists, but is not connected
                return tree.reason(moved[0], base or sensor, stamp_ns)
            return (
                f'{base or sensor!r} in {self._tf_frame!r} is unknown: nobody publishes it on '
                '/tf; leave odom_frame empty if the robot has no such frame'
            )
        return tree.reason(self._tf_frame, base or sensor, stamp_ns)
