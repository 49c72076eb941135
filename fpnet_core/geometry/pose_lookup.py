# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where sensor and robot were: by an odometry's messages or by TF, and in the robot's own tree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fpnet_core.geometry.frame_tree import FrameTree, plain_frame
from fpnet_core.geometry.pose_track import Array, PoseTrack
from fpnet_core.stamps import NS_PER_S

_HORIZON_NS = 10 * NS_PER_S  # numerical: as the tree's; what waits longer for its pose is dropped


@dataclass(frozen=True, eq=False)
class SensorPose:
    """
    Poses (4, 4) of a sensor and of the robot's base at one time.

    ``T_odom_...`` are in the odometry's frame; ``T_tf_odom`` leads from there to the frame that
    TF is published for, and is the identity where that is the same.
    """

    odom_frame: str
    T_odom_sensor: Array
    T_odom_base: Array
    tf_frame: str
    T_tf_odom: Array


class PoseLookup:
    """
    Puts together what an odometry, TF and static transforms say.

    Poses of an odometry's messages stay apart from the tree of TF: a frame has one parent there,
    which is another one's where a robot publishes ``odom -> base_link`` itself. Both meet in the
    robot's base, whose pose either knows.

    Parameters
    ----------
    from_tf
        Poses come from ``odom_frame`` in TF; else from messages, see :meth:`add_pose`.
    odom_frame
        Frame that TF is published for: of the robot's own tree. Empty: that of the odometry.
    base_frame
        Frame whose pose is wanted. Empty: the child of the odometry's messages, or what moves in
        TF with the sensor fixed to it.
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
        """Frame whose pose is wanted; empty as long as nobody has said."""
        return self._base or ('' if self._track is None else self._track.child_frame)

    @property
    def needs_tf(self) -> bool:
        """Whether moving transforms are needed."""
        return bool(self._tf_frame)

    def clear(self) -> None:
        """Forget everything that moves."""
        self.tree.clear()
        self._track = None

    def add_pose(self, odom: str, child: str, T_odom_child: Array, stamp_ns: int) -> None:
        """Take a pose of the odometry."""
        child = plain_frame(child)
        if self._track is None or self._track.child_frame != child or self._odom != odom:
            self._track = PoseTrack(child, _HORIZON_NS)
        self._odom = odom
        self._track.add(stamp_ns, T_odom_child)

    def pose(self, frame: str, stamp_ns: int) -> Array | None:
        """Return ``T_odom_frame (4, 4)`` of a frame on the robot; None where it is not known."""
        if self._from_tf:
            return self.tree.lookup(self._odom, frame, stamp_ns)
        T_odom_child = None if self._track is None else self._track.at(stamp_ns)
        if self._track is None or T_odom_child is None or not self._track.child_frame:
            return None
        T_child_frame = self.tree.lookup(self._track.child_frame, frame, stamp_ns)
        return None if T_child_frame is None else T_odom_child @ T_child_frame

    def sensor_pose(self, sensor: str, stamp_ns: int) -> SensorPose | None:
        """Return where a sensor was; None while something is missing, see :meth:`reason`."""
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
        """Return ``T_first_last (4, 4)`` of a frame on the robot between two times."""
        T_odom_first, T_odom_last = self.pose(frame, first_ns), self.pose(frame, last_ns)
        if T_odom_first is None or T_odom_last is None:
            return None
        T_first_last: Array = np.linalg.inv(T_odom_first) @ T_odom_last
        return T_first_last

    def reason(self, sensor: str, stamp_ns: int) -> str:
        """Return in words why :meth:`placing` knows nothing."""
        tree, base = self.tree, self.base_frame
        if not self._from_tf and self._track is None:
            return f'no odometry has come for scans in {sensor!r}'
        moving = (base or sensor) if self._track is None else self._track.child_frame
        for frame in (sensor, base or sensor):
            if not moving or tree.root(moving) != tree.root(frame):
                return tree.reason(moving, frame, stamp_ns)
        if self._track is not None and self._track.at(stamp_ns) is None:
            why = self._track.reason(stamp_ns)
            return f'{moving!r} in {self._odom!r} is unknown at {stamp_ns} ns: {why}'
        if tree.root(base or sensor) != tree.root(self._tf_frame):
            if moved := tree.children(self._tf_frame):  # it is there, but does not lead here
                return tree.reason(moved[0], base or sensor, stamp_ns)
            return (
                f'{base or sensor!r} in {self._tf_frame!r} is unknown: nobody publishes it on '
                '/tf; leave odom_frame empty where the robot has no such frame'
            )
        return tree.reason(self._tf_frame, base or sensor, stamp_ns)
