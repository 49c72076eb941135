# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Offline tools: the Python interface, the ``fpnet`` command, reports and plots.

The names below are the public interface (``docs/python.md``). They are loaded on first use, so
that ``import fpnet`` is fast. The localizer on a robot does not import this package.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fpnet.api import (
        align,
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
    from fpnet.api.run import Run
    from fpnet.api.values import Match, Plan, RobotMap, Rooms
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
    'align',
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
    'FpnetConfig': 'fpnet_core.config',
    'FpnetError': 'fpnet_core.errors',
    'Match': 'fpnet.api.values',
    'Plan': 'fpnet.api.values',
    'RobotMap': 'fpnet.api.values',
    'Rooms': 'fpnet.api.values',
    'Run': 'fpnet.api.run',
    'Status': 'fpnet_core.types',
    'align': 'fpnet.api',
    'check_plan': 'fpnet.api',
    'diff': 'fpnet.api',
    'load_config': 'fpnet_core.config',
    'localize': 'fpnet.api',
    'match': 'fpnet.api',
    'match_site': 'fpnet.api',
    'read_plan': 'fpnet.api',
    'read_robot_map': 'fpnet.api',
    'read_site': 'fpnet.api',
    'segment': 'fpnet.api',
}


def __getattr__(name: str) -> Any:
    """Load a public name on first access."""
    if name == '__version__':
        from importlib.metadata import version

        return version('fpnet_ros')
    if name not in _MODULE_OF:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(_MODULE_OF[name]), name)


def __dir__() -> list[str]:
    """Return the loaded names and the public interface."""
    return sorted({*globals(), *__all__})
