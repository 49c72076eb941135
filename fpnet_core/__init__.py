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
        check_plan,
        diff,
        localize,
        match,
        match_site,
        read_plan,
        read_robot_map,
        read_site,
        segment,
    )
    from fpnet_core.api.run import Run
    from fpnet_core.api.values import Match, Plan, RobotMap, Rooms
    from fpnet_core.config import FpnetConfig, load_config
    from fpnet_core.errors import FpnetError
    from fpnet_core.types import Status

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
    'diff',
    'load_config',
    'localize',
    'match',
    'match_site',
    'read_plan',
    'read_robot_map',
    'read_site',
    'segment',
]

_MODULE_OF = {
    'FpnetConfig': 'config',
    'FpnetError': 'errors',
    'Match': 'api.values',
    'Plan': 'api.values',
    'RobotMap': 'api.values',
    'Rooms': 'api.values',
    'Run': 'api.run',
    'Status': 'types',
    'check_plan': 'api',
    'diff': 'api',
    'load_config': 'config',
    'localize': 'api',
    'match': 'api',
    'match_site': 'api',
    'read_plan': 'api',
    'read_robot_map': 'api',
    'read_site': 'api',
    'segment': 'api',
}


def __getattr__(name: str) -> Any:
    """Load a name of the interface."""
    if name not in _MODULE_OF:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(f'fpnet_core.{_MODULE_OF[name]}'), name)


def __dir__() -> list[str]:
    """Return the interface beside what is loaded."""
    return sorted({*globals(), *__all__})
