# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Find a robot on a floorplan: no ROS, no network, data in and data out.

The names below are the Python interface (``docs/python.md``); they are loaded when they are first
used, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

# Before any kernel is compiled.
from fpnet_core import kernel_cache as kernel_cache

if TYPE_CHECKING:
    from fpnet_core.api import (
        FpnetConfig,
        FpnetError,
        Match,
        Plan,
        RobotMap,
        Rooms,
        Run,
        Status,
        check_plan,
        load_config,
        localize,
        match,
        read_plan,
        read_robot_map,
        segment,
    )

__all__ = [
    'FpnetConfig',
    'FpnetError',
    'Match',
    'Plan',
    'RobotMap',
    'Rooms',
    'Run',
    'Status',
    'check_plan',
    'load_config',
    'localize',
    'match',
    'read_plan',
    'read_robot_map',
    'segment',
]


def __getattr__(name: str) -> Any:
    """Load a name of the interface."""
    if name not in __all__:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module('fpnet_core.api'), name)


def __dir__() -> list[str]:
    """Return the interface beside what is loaded."""
    return sorted({*globals(), *__all__})
