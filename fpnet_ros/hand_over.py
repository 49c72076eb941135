# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tell AMCL where the robot is, once."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped

from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.runtime import STREAM


class HandOver:
    """
    Publishes ``initialpose``: the first pose that is claimed, and again where somebody asks.

    A pose that kept coming would scatter AMCL's particles every time.
    """

    def __init__(self, node: ManagedNode) -> None:
        self._logger = node.get_logger()
        self._publisher = node.add_publisher(PoseWithCovarianceStamped, 'initialpose', STREAM)
        self._is_due, self._was_heard = True, False

    def again(self) -> None:
        """Hand over the next pose that is claimed, too."""
        self._is_due = True

    def follow(self, pose: Any) -> None:
        """Take the pose with covariance that is claimed, None: none; called about every second."""
        # Who has just subscribed knows us, and is known, but the other way round it may take.
        was_heard, self._was_heard = self._was_heard, self._publisher.get_subscription_count() > 0
        if pose is not None and self._is_due and was_heard and self._was_heard:
            self._is_due = False
            self._publisher.publish(pose)
            at = pose.pose.pose.position
            self._logger.info(f'handed over: the robot is at ({at.x:.2f}, {at.y:.2f})')
