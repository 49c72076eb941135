# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Optional message types, and the log line for each that is not installed."""

from __future__ import annotations

from typing import Any

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # not in any wheel; see docs/install.md
    TFMessage = None

try:
    from bond.msg import Status as BondStatus
except ImportError:
    BondStatus: Any = None

try:
    from nav2_msgs.srv import SetInitialPose
except ImportError:
    SetInitialPose: Any = None

try:
    from fpnet_msgs.action import Localize
except ImportError:
    Localize: Any = None

__all__ = ['NO_ACTION', 'NO_BOND', 'NO_SERVICE', 'NO_TF', 'BondStatus', 'Localize']
__all__ += ['SetInitialPose', 'TFMessage']

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
