# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The Fast DDS profile that large clouds need: where it is, and what to say where none is set."""

from __future__ import annotations

from collections.abc import Mapping
import os
import shutil

PROFILE_VARIABLE = 'FASTRTPS_DEFAULT_PROFILES_FILE'
"""Given: environment variable by which Fast DDS finds a profile."""

PROFILE = 'config/fastdds_shm.xml'
"""In the share of this package."""

LARGE_CLOUDS = f'{PROFILE} passes clouds through shared memory (docs/ros.md)'
"""What to do about clouds that are lost on the way. Given."""

_FAST_DDS = 'rmw_fastrtps'  # given: what the names of its middlewares begin with
_OTHERS = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTDDS_BUILTIN_TRANSPORTS')  # given
# Segments of five participants; container engines mount 64 MB unless told otherwise.
_SHARED_MEMORY = '/dev/shm'  # noqa: S108 - given: the kernel's, not a temporary file of ours
_NEEDED_BYTES = 5 * 64 * 2**20  # chosen


def has_shared_memory() -> bool:
    """Tell whether the segments of the profile fit."""
    try:
        return shutil.disk_usage(_SHARED_MEMORY).free >= _NEEDED_BYTES
    except OSError:
        return False


def said_of_transport(middleware: str, environment: Mapping[str, str] = os.environ) -> str:
    """Return what a node that takes clouds says at its start; empty where all is set."""
    is_set = any(environment.get(name) for name in (PROFILE_VARIABLE, *_OTHERS))
    if is_set or not middleware.startswith(_FAST_DDS):
        return ''
    return (
        f'{PROFILE_VARIABLE} is not set: most clouds of 500 kB and more will be lost; '
        f"{LARGE_CLOUDS}, of this node and of the lidar's driver"
    )
