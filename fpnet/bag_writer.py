# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writer for ROS 2 bags (sqlite3 or mcap); uses rosbags and needs no ROS."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, Self, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer

from fpnet_core.errors import BagFormatError
from fpnet_core.geometry.rigid3d import quaternion_from_rigid
from fpnet_core.io.bags import TYPESTORE
from fpnet_core.io.laserscan import LaserScanLike
from fpnet_core.io.message_types import (
    GRID,
    IMU,
    LASER_SCAN,
    NUMBER,
    ODOMETRY,
    POINT_CLOUD,
    POSE,
    TEXT,
    TRANSFORMS,
    UNCERTAIN_POSE,
)
from fpnet_core.io.pointcloud2 import encode_points
from fpnet_core.io.topic_names import TF_STATIC_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import GridMap

Storage = Literal['sqlite3', 'mcap']

_BAG_VERSION: Literal[9] = 9  # given: the version that ROS 2 Jazzy writes
_NO_LIMIT = QosTime(0, 0)  # given
_MSG = TYPESTORE.types
_NOT_MEASURED = -1.0  # given: sensor_msgs/Imu
# Given: indices of x, y and yaw in ROS's order x, y, z, roll, pitch, yaw.
_PLANAR = np.ix_((0, 1, 5), (0, 1, 5))


def _qos(depth: int, durability: QosDurability) -> Qos:
    return Qos(
        QosHistory.KEEP_LAST,
        depth,
        QosReliability.RELIABLE,
        durability,
        _NO_LIMIT,
        _NO_LIMIT,
        QosLiveliness.AUTOMATIC,
        _NO_LIMIT,
        False,
    )


# Chosen, not measured:
_STREAM_QOS = _qos(10, QosDurability.VOLATILE)
_LATCHED_QOS = _qos(1, QosDurability.TRANSIENT_LOCAL)
_STATIC_QOS = _qos(100, QosDurability.TRANSIENT_LOCAL)  # one message for each transform


class BagWriter:
    """
    Context manager that writes a recording.

    Parameters
    ----------
    path
        The bag's folder; must not exist.
    storage
        ``sqlite3`` or ``mcap``.

    Stamps are integer nanoseconds, used for both the header and the time of recording. ``T_...``
    are rigid (4, 4) transforms.

    Raises
    ------
    BagFormatError
        If the path exists or cannot be written.
    """

    def __init__(self, path: Path | str, storage: Storage = 'sqlite3') -> None:
        plugins = {'sqlite3': StoragePlugin.SQLITE3, 'mcap': StoragePlugin.MCAP}
        if storage not in plugins:
            raise BagFormatError(f'bag storage {storage!r} is unknown; use sqlite3 or mcap')
        self._path = Path(path)
        if self._path.exists():
            raise BagFormatError(f'{self._path} exists; remove it or choose another name')
        self._writer = Writer(self._path, version=_BAG_VERSION, storage_plugin=plugins[storage])
        self._connections: dict[str, Connection] = {}

    def __enter__(self) -> Self:
        """Create the bag's folder."""
        try:
            self._writer.open()
        except OSError as error:
            raise BagFormatError(f'cannot write bag {self._path}: {error.strerror}') from None
        return self

    def __exit__(self, *_: object) -> None:
        """Close the bag, also after an error, so that the messages written so far are readable."""
        self._writer.close()

    def write_cloud(
        self,
        topic: str,
        stamp_ns: int,
        frame_id: str,
        points: ArrayLike,
        intensity: ArrayLike | None = None,
        ring: ArrayLike | None = None,
        time_s: ArrayLike | None = None,
        heard_ns: int | None = None,
    ) -> None:
        """
        Write a PointCloud2 of ``points (P, 3)`` [m]; see pointcloud2.encode_points.

        ``heard_ns`` is its time of recording; None uses the stamp.
        """
        fields, point_step, data = encode_points(points, intensity, ring, time_s)
        width = len(data) // point_step
        message = _MSG[POINT_CLOUD](
            header=_header(stamp_ns, frame_id),
            height=1,
            width=width,
            fields=[
                _MSG['sensor_msgs/msg/PointField'](f.name, f.offset, f.datatype, f.count)
                for f in fields
            ],
            is_bigendian=False,
            point_step=point_step,
            row_step=point_step * width,
            data=np.frombuffer(data, dtype=np.uint8),
            is_dense=True,
        )
        at_ns = stamp_ns if heard_ns is None else heard_ns
        self._write(topic, POINT_CLOUD, at_ns, message)

    def write_imu(self, topic: str, stamp_ns: int, frame_id: str, rate: ArrayLike) -> None:
        """Write an Imu message with only an angular rate ``(3,)`` [rad/s]."""
        vector = _MSG['geometry_msgs/msg/Vector3']
        unknown = np.array([_NOT_MEASURED, *[0.0] * 8])
        message = _MSG[IMU](
            header=_header(stamp_ns, frame_id),
            orientation=_MSG['geometry_msgs/msg/Quaternion'](0.0, 0.0, 0.0, 1.0),
            orientation_covariance=unknown,
            angular_velocity=vector(*np.asarray(rate, dtype=np.float64).tolist()),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=vector(0.0, 0.0, 0.0),
            linear_acceleration_covariance=unknown,
        )
        self._write(topic, IMU, stamp_ns, message)

    def write_laser_scan(
        self, topic: str, stamp_ns: int, frame_id: str, readings: LaserScanLike
    ) -> None:
        """Write a LaserScan; the stamp is the time of its first ray."""
        ranges = np.asarray(readings.ranges, dtype=np.float32)
        turned = readings.angle_increment * max(len(ranges) - 1, 0)
        message = _MSG[LASER_SCAN](
            header=_header(stamp_ns, frame_id),
            angle_min=readings.angle_min,
            angle_max=readings.angle_min + turned,
            angle_increment=readings.angle_increment,
            time_increment=readings.time_increment,
            scan_time=readings.time_increment * len(ranges),
            range_min=readings.range_min,
            range_max=readings.range_max,
            ranges=ranges,
            intensities=np.zeros(0, dtype=np.float32),
        )
        self._write(topic, LASER_SCAN, stamp_ns, message)

    def write_odometry(
        self,
        topic: str,
        stamp_ns: int,
        frame_id: str,
        child_frame_id: str,
        T_frame_child: NDArray[np.float64],
    ) -> None:
        """Write an Odometry without velocity and with zero covariance (unknown)."""
        zero = _vector3(0.0, 0.0, 0.0)
        covariance = np.zeros(36)
        message = _MSG[ODOMETRY](
            header=_header(stamp_ns, frame_id),
            child_frame_id=child_frame_id,
            pose=_MSG['geometry_msgs/msg/PoseWithCovariance'](_pose(T_frame_child), covariance),
            twist=_MSG['geometry_msgs/msg/TwistWithCovariance'](
                _MSG['geometry_msgs/msg/Twist'](zero, zero), covariance
            ),
        )
        self._write(topic, ODOMETRY, stamp_ns, message)

    def write_pose(
        self, topic: str, stamp_ns: int, frame_id: str, T_frame_body: NDArray[np.float64]
    ) -> None:
        """Write a PoseStamped."""
        message = _MSG[POSE](_header(stamp_ns, frame_id), _pose(T_frame_body))
        self._write(topic, POSE, stamp_ns, message)

    def write_uncertain_pose(
        self,
        topic: str,
        stamp_ns: int,
        frame_id: str,
        T_frame_body: NDArray[np.float64],
        cov: NDArray[np.float64],
    ) -> None:
        """Write a PoseWithCovarianceStamped; ``cov (3, 3)`` is over x, y [m] and yaw [rad]."""
        full = np.zeros((6, 6))
        full[_PLANAR] = cov
        pose = _MSG['geometry_msgs/msg/PoseWithCovariance'](_pose(T_frame_body), full.ravel())
        message = _MSG[UNCERTAIN_POSE](_header(stamp_ns, frame_id), pose)
        self._write(topic, UNCERTAIN_POSE, stamp_ns, message)

    def write_grid(self, topic: str, stamp_ns: int, grid: GridMap) -> None:
        """Write an OccupancyGrid in the grid's own frame, with transient-local durability."""
        height, width = grid.shape
        header = _header(stamp_ns, grid.frame)
        info = _MSG['nav_msgs/msg/MapMetaData'](
            header.stamp, grid.resolution, width, height, _pose(grid.T_frame_grid.as_matrix4())
        )
        message = _MSG[GRID](header, info, np.ascontiguousarray(grid.cells).ravel())
        self._write(topic, GRID, stamp_ns, message, _LATCHED_QOS)

    def write_transform(
        self,
        topic: str,
        stamp_ns: int,
        frame_id: str,
        child_frame_id: str,
        T_frame_child: NDArray[np.float64],
        is_latched: bool | None = None,
    ) -> None:
        """Write a TFMessage with one transform; ``is_latched`` None latches ``/tf_static``."""
        pose = _pose(T_frame_child)
        translation = _vector3(pose.position.x, pose.position.y, pose.position.z)
        stamped = _MSG['geometry_msgs/msg/TransformStamped'](
            _header(stamp_ns, frame_id),
            child_frame_id,
            _MSG['geometry_msgs/msg/Transform'](translation, pose.orientation),
        )
        if is_latched is None:
            is_latched = topic.endswith(TF_STATIC_TOPIC)
        qos = _STATIC_QOS if is_latched else _STREAM_QOS
        self._write(topic, TRANSFORMS, stamp_ns, _MSG[TRANSFORMS]([stamped]), qos)

    def write_number(self, topic: str, stamp_ns: int, value: float) -> None:
        """Write a Float64, which viewers can plot over time."""
        self._write(topic, NUMBER, stamp_ns, _MSG[NUMBER](float(value)))

    def write_text(self, topic: str, stamp_ns: int, text: str) -> None:
        """Write a String."""
        self._write(topic, TEXT, stamp_ns, _MSG[TEXT](text))

    def _write(
        self, topic: str, msgtype: str, stamp_ns: int, message: Any, qos: Qos = _STREAM_QOS
    ) -> None:
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic, msgtype, typestore=TYPESTORE, offered_qos_profiles=[qos]
            )
        connection = self._connections[topic]
        if connection.msgtype != msgtype:
            raise BagFormatError(f'{topic} carries {connection.msgtype}, cannot add {msgtype}')
        self._writer.write(connection, stamp_ns, TYPESTORE.serialize_cdr(message, msgtype))


def _header(stamp_ns: int, frame_id: str) -> Any:
    sec, nanosec = divmod(int(stamp_ns), NS_PER_S)
    return _MSG['std_msgs/msg/Header'](_MSG['builtin_interfaces/msg/Time'](sec, nanosec), frame_id)


def _vector3(x: float, y: float, z: float) -> Any:
    return _MSG['geometry_msgs/msg/Vector3'](x, y, z)


def _pose(T_frame_body: NDArray[np.float64]) -> Any:
    try:
        xyzw = quaternion_from_rigid(T_frame_body)
    except ValueError as error:
        raise BagFormatError(f'pose to record: {error}') from None
    point = cast('Any', _MSG['geometry_msgs/msg/Point'])(*map(float, T_frame_body[:3, 3]))
    rotation = cast('Any', _MSG['geometry_msgs/msg/Quaternion'])(*map(float, xyzw))
    return _MSG['geometry_msgs/msg/Pose'](point, rotation)
