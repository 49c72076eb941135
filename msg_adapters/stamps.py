# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``builtin_interfaces/Time`` and ``std_msgs/Header``, to and from integer nanoseconds."""

from __future__ import annotations

from typing import Any

from fpnet_core.io.messages import stamp_to_ns
from fpnet_core.stamps import NS_PER_S


def stamp_from_msg(msg: Any) -> int:
    """Return the nanoseconds of a ``builtin_interfaces/Time``."""
    return stamp_to_ns(msg)


def stamp_to_msg(stamp_ns: int) -> Any:
    """Return a ``builtin_interfaces/Time``."""
    from builtin_interfaces.msg import Time

    sec, nanosec = divmod(int(stamp_ns), NS_PER_S)
    return Time(sec=sec, nanosec=nanosec)


def header_to_msg(stamp_ns: int, frame_id: str) -> Any:
    """Return a ``std_msgs/Header``."""
    from std_msgs.msg import Header

    return Header(stamp=stamp_to_msg(stamp_ns), frame_id=frame_id)
