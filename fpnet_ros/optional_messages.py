# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Optional message types, None if not installed, and the log line for each that is missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def _optional(module: str, name: str) -> Any:
    try:
        return getattr(import_module(module), name)
    except ImportError:
        return None


TFMessage = _optional('tf2_msgs.msg', 'TFMessage')  # in no wheel; see docs/install.md
BondStatus = _optional('bond.msg', 'Status')
SetInitialPose = _optional('nav2_msgs.srv', 'SetInitialPose')
Localize = _optional('fpnet_msgs.action', 'Localize')

_SETUP = 'or run make setup with a C++ compiler'

NO_TF = f'tf2_msgs is not installed; install ROS 2, {_SETUP}'
NO_BOND = (
    f'no bond to a lifecycle manager: bond is not installed; install ros-jazzy-bond, {_SETUP}, or '
    "set the manager's bond_timeout to 0.0"
)
NO_SERVICE = (
    f'no ~/set_initial_pose: nav2_msgs is not installed; install ros-jazzy-nav2-msgs, {_SETUP}'
)
NO_ACTION = f'no ~/localize: fpnet_msgs is not installed; build interfaces/fpnet_msgs, {_SETUP}'
