# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reader for bags of ROS 2 (sqlite3 or mcap) and ROS 1; uses rosbags and needs no ROS."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Self

from rosbags import rosbag1, rosbag2
from rosbags.interfaces import Connection, QosDurability, QosReliability
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from fpnet_core.errors import BagFormatError, said_of_system
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.io.message_types import BAG_SUFFIXES, ROS_1_SUFFIX, TRANSFORMS
from fpnet_core.plain_files import regular
from fpnet_core.plain_yaml import parse_yaml

TYPESTORE = get_typestore(Stores.ROS2_JAZZY)

_RENAMED = {'tf/msg/tfMessage': TRANSFORMS}  # given: the name in ROS 1 before tf2


class BagReader:
    """
    Context manager that reads a bag: a folder, a ``.db3`` or ``.mcap`` file, or a ROS 1 ``.bag``.

    ROS 1 messages are returned with the types and attributes of ROS 2.

    Raises
    ------
    BagFormatError
        On opening or while reading, if the bag is missing, corrupt or incomplete.
    """

    def __init__(self, path: Path | str) -> None:
        self._path = _storage_path(Path(path))
        self._is_of_ros_1 = self._path.is_file() and self._path.suffix.lower() == ROS_1_SUFFIX
        self._reader: rosbag1.Reader | rosbag2.Reader | None = None

    def __enter__(self) -> Self:
        """Open the bag."""
        try:
            for each in self._path.iterdir() if self._path.is_dir() else [self._path]:
                regular(each)
            _check_metadata(self._path)
            self._reader = (rosbag1 if self.is_of_ros_1 else rosbag2).Reader(self._path)
            self._reader.open()
        except Exception as error:
            raise self._corrupt(error) from None
        return self

    def __exit__(self, *_: object) -> None:
        """Close the bag."""
        reader, self._reader = self._reader, None
        if reader is not None:
            with suppress(Exception):  # closing a corrupt file may fail, which is harmless
                reader.close()

    @property
    def is_of_ros_1(self) -> bool:
        """Whether the bag is a ROS 1 file; old ones have no ``/tf_static``."""
        return self._is_of_ros_1

    @property
    def topics(self) -> dict[str, str]:
        """Message type by topic."""
        return {c.topic: _type_of(c) for c in self._open_reader().connections}

    def count(self, topic: str) -> int:
        """Return the number of messages on ``topic``, 0 if there is no such topic."""
        return sum(c.msgcount for c in self._open_reader().connections if c.topic == topic)

    def offers(self, topic: str) -> list[tuple[bool, bool]]:
        """Return (is reliable, is transient local) for each recorded publisher of a topic."""
        return [
            (
                qos.reliability is not QosReliability.BEST_EFFORT,
                qos.durability is QosDurability.TRANSIENT_LOCAL,
            )
            for connection in self._open_reader().connections
            if connection.topic == topic
            for qos in getattr(connection.ext, 'offered_qos_profiles', ())
            if not isinstance(qos, str)
        ]

    def is_latched(self, topic: str) -> bool:
        """
        Return whether a topic was latched (transient local), as recorded.

        ``/tf_static`` is always latched, whatever QoS was recorded.
        """
        of_ros_1 = (
            getattr(connection.ext, 'latching', False)
            for connection in self._open_reader().connections
            if connection.topic == topic
        )
        offered = (latched for _, latched in self.offers(topic))
        return topic.endswith('tf_static') or any(of_ros_1) or any(offered)

    def messages(self, topics: Sequence[str]) -> Iterator[tuple[str, int, Any]]:
        """
        Yield topic, time of recording [ns] and message, in the order of recording.

        Messages have the attributes of their ROS definition; numeric sequences are NumPy arrays.
        """
        for connection, stamp_ns, data in self._stream(topics):
            yield connection.topic, stamp_ns, self._decoded(connection, data)

    def raw_messages(self, topics: Sequence[str] = ()) -> Iterator[tuple[str, str, int, bytes]]:
        """Yield topic, type, time of recording [ns] and CDR bytes; without topics, of all."""
        for connection, stamp_ns, data in self._stream(topics):
            msgtype = _type_of(connection)
            cdr = data
            if self.is_of_ros_1:
                cdr = bytes(TYPESTORE.serialize_cdr(self._decoded(connection, data), msgtype))
            yield connection.topic, msgtype, stamp_ns, cdr

    def _stream(self, topics: Sequence[str]) -> Iterator[tuple[Connection, int, bytes]]:
        reader = self._open_reader()
        connections = [c for c in reader.connections if not topics or c.topic in topics]
        if not connections:
            return
        stream = reader.messages(connections)
        while True:
            try:
                yield next(stream)
            except StopIteration:
                return
            except Exception as error:
                raise self._corrupt(error) from None

    def _decoded(self, connection: Connection, data: bytes) -> Any:
        try:
            if self.is_of_ros_1:
                return _ros_1_types().deserialize_ros1(data, _type_of(connection))
            return TYPESTORE.deserialize_cdr(data, connection.msgtype)
        except Exception as error:
            raise self._corrupt(error) from None

    def _open_reader(self) -> rosbag1.Reader | rosbag2.Reader:
        if self._reader is None:
            raise BagFormatError(f'bag {self._path} is not open; use it in a with statement')
        return self._reader

    def _corrupt(self, error: Exception) -> BagFormatError:
        # Each storage plugin and decoder raises its own types on damaged bytes (sqlite3, struct,
        # zstd, YAML, assertions); callers get a single type.
        text = said_of_system(error) if isinstance(error, OSError) else str(error)
        detail = text.splitlines()[0] if text else type(error).__name__
        repair = 'rosbag reindex' if self.is_of_ros_1 else 'ros2 bag reindex'
        return BagFormatError(
            f'cannot read bag {self._path}: {detail}; record it again or repair it ({repair})'
        )


def _type_of(connection: Connection) -> str:
    return _RENAMED.get(connection.msgtype, connection.msgtype)


@cache
def _ros_1_types() -> Typestore:
    types = get_typestore(Stores.ROS1_NOETIC)
    types.register(get_types_from_msg('geometry_msgs/TransformStamped[] transforms', TRANSFORMS))
    return types


def _check_metadata(path: Path) -> None:
    """Refuse YAML aliases before rosbags reads the metadata: it expands them without limit."""
    metadata = path / 'metadata.yaml'
    if metadata.is_file() and '*' in (text := metadata.read_text(encoding='utf-8')):
        parse_yaml(text)


def _storage_path(path: Path) -> Path:
    """Return the path for rosbags: of a folder without metadata, its only storage file."""
    if not path.exists():
        raise BagFormatError(f'bag {path} does not exist')
    if path.is_file() and path.suffix.lower() not in BAG_SUFFIXES:
        raise BagFormatError(
            f'{path} is not a bag: expected a folder or a file ({", ".join(BAG_SUFFIXES)})'
        )
    if path.is_dir() and not (path / 'metadata.yaml').exists():
        files = sorted(each for each in path.iterdir() if each.suffix.lower() in BAG_SUFFIXES)
        if len(files) != 1:
            raise BagFormatError(
                f'{path} is not a bag: no metadata.yaml and {len(files)} storage files; '
                'repair it (ros2 bag reindex)'
            )
        return files[0]
    return path


def first_frame(bag: BagReader, topic: str, path: Path) -> str:
    """
    Return the frame of the first message on a topic.

    Raises
    ------
    BagFormatError
        If there is no message.
    """
    for _, _, message in bag.messages([topic]):
        return plain_frame(message.header.frame_id)
    raise BagFormatError(f'bag {path}: {topic} has no messages; choose another topic')
