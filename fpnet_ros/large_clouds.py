# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fast DDS profile for large clouds, and the log line if no profile is set."""

from __future__ import annotations

from collections.abc import Mapping
import os
import shutil

PROFILE_VARIABLE = 'FASTRTPS_DEFAULT_PROFILES_FILE'
"""Given: environment variable with the path of Fast DDS's profile."""

PROFILE = 'config/fastdds_shm.xml'
"""Path of the profile in the share folder of this package."""

LARGE_CLOUDS = f'{PROFILE} passes clouds through shared memory (docs/ros.md)'
"""Remedy for clouds that are lost in transport. Given."""

_FAST_DDS = 'rmw_fastrtps'  # given: prefix of its RMW implementations
_OTHERS = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTDDS_BUILTIN_TRANSPORTS')  # given
# Segments of five participants; container engines mount 64 MB by default.
_SHARED_MEMORY = '/dev/shm'  # noqa: S108 - given: the kernel's, not a temporary file of ours
_NEEDED_BYTES = 5 * 64 * 2**20  # chosen


def has_shared_memory() -> bool:
    """Return whether shared memory has room for the segments of the profile."""
    try:
        return shutil.disk_usage(_SHARED_MEMORY).free >= _NEEDED_BYTES
    except OSError:
        return False


def said_of_transport(middleware: str, environment: Mapping[str, str] = os.environ) -> str:
    """Return the line that a node with clouds logs at its start; empty if none is needed."""
    is_set = any(environment.get(name) for name in (PROFILE_VARIABLE, *_OTHERS))
    if is_set or not middleware.startswith(_FAST_DDS):
        return ''
    return (
        f'{PROFILE_VARIABLE} is not set: most clouds above 500 kB will be lost; '
        f"{LARGE_CLOUDS}; set it for this node and the lidar's driver"
    )
