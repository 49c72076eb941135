# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Handover of the first pose to AMCL."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped

from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.runtime import STREAM


class HandOver:
    """
    Publishes the first accepted pose on ``initialpose``, and another one on request.

    Every pose on ``initialpose`` scatters AMCL's particles, so it is not repeated.
    """

    def __init__(self, node: ManagedNode) -> None:
        self._logger = node.get_logger()
        self._publisher = node.add_publisher(PoseWithCovarianceStamped, 'initialpose', STREAM)
        self._is_due, self._was_heard = True, False

    def again(self) -> None:
        """Hand over the next accepted pose as well."""
        self._is_due = True

    def follow(self, pose: Any) -> None:
        """Publish the accepted pose if due; None: there is none. Called about every second."""
        # Discovery is mutual: wait one more call until a new subscriber also knows this publisher.
        was_heard, self._was_heard = self._was_heard, self._publisher.get_subscription_count() > 0
        if pose is not None and self._is_due and was_heard and self._was_heard:
            self._is_due = False
            self._publisher.publish(pose)
            at = pose.pose.pose.position
            self._logger.info(f'handed over to AMCL: the robot is at ({at.x:.2f}, {at.y:.2f})')
