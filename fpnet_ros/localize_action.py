# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Server of the action ``~/localize``, which succeeds once the robot is localized."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
import math
import time
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future

from fpnet_core.stamps import NS_PER_S
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.optional_messages import NO_ACTION, Localize
from msg_adapters.diagnostics import LocalizerReport

# Feedback is repeated after this time, because a client's subscription may match only after its
# goal was accepted and miss the first one. Numerical: well below a behaviour tree's timeouts.
_FEEDBACK_EVERY_S = 1.0


@dataclass(eq=False)
class _Goal:
    """An active goal; the future ``ended`` gets its result."""

    handle: Any
    deadline_s: float
    ended: Future = field(default_factory=Future)
    told: LocalizerReport | None = None
    told_s: float = -math.inf

    def is_due(self, report: LocalizerReport) -> bool:
        """Return whether a report is new, or the last feedback is old enough to be repeated."""
        return report is not self.told or time.monotonic() > self.told_s + _FEEDBACK_EVERY_S


class LocalizeAction:
    """
    Serves any number of goals at once: each waits until the node is localized.

    Everything runs in the executor's thread, which calls :meth:`follow` often. The server exists
    as long as the node, because pending results need it; it rejects goals while the node is not
    active. If the action's type is not installed there is no server, and the log says so.

    Parameters
    ----------
    node
        Goals are accepted while it is active.
    look_again
        Discards all hypotheses, for goals with ``anew``.
    """

    def __init__(self, node: ManagedNode, look_again: Callable[[], None]) -> None:
        self._node, self._relocalize = node, look_again
        self._goals: list[_Goal] = []
        if Localize is None:
            node.get_logger().warning(NO_ACTION)
            return
        ActionServer(
            node,
            Localize,
            '~/localize',
            self._execute,
            # A pending result must not block requests to cancel it.
            callback_group=ReentrantCallbackGroup(),
            goal_callback=self._on_goal,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def follow(self, report: LocalizerReport, pose: Any) -> None:
        """
        Send feedback to every goal, and end those reached, cancelled or timed out.

        ``pose`` is the accepted PoseWithCovarianceStamped, None unless localized.
        """
        for goal in list(self._goals):
            if goal.is_due(report):
                goal.told, goal.told_s = report, time.monotonic()
                goal.handle.publish_feedback(_feedback(report))
            if goal.handle.is_cancel_requested:
                goal.handle.canceled()
                self._end(goal, Localize.Result.CANCELED, 'the goal was cancelled')
            elif pose is not None:
                goal.handle.succeed()
                self._end(goal, Localize.Result.NONE, '', pose)
            elif time.monotonic() > goal.deadline_s:
                goal.handle.abort()
                self._end(goal, Localize.Result.TIMEOUT, f'not localized in time: {report.said}')

    def stop(self) -> None:
        """Abort every goal, as the node is deactivated."""
        for goal in list(self._goals) if self._node.context.ok() else ():
            goal.handle.abort()
            self._end(goal, Localize.Result.INACTIVE, 'the localizer was deactivated')

    def _on_goal(self, _: Any) -> GoalResponse:
        if self._node.is_active:
            return GoalResponse.ACCEPT
        self._node.get_logger().warning('rejected a goal of ~/localize: the node is not active')
        return GoalResponse.REJECT

    async def _execute(self, handle: Any) -> Any:
        timeout = handle.request.timeout
        timeout_s = timeout.sec + timeout.nanosec / NS_PER_S
        goal = _Goal(handle, time.monotonic() + timeout_s if timeout_s > 0.0 else math.inf)
        if handle.request.anew:
            self._relocalize()
        self._goals.append(goal)
        return await goal.ended

    def _end(self, goal: _Goal, code: int, message: str, pose: Any = None) -> None:
        self._goals.remove(goal)
        result = Localize.Result(error_code=code, error_msg=message)
        if pose is not None:
            result.pose = pose
        goal.ended.set_result(result)


def _feedback(report: LocalizerReport) -> Any:
    return Localize.Feedback(
        status=report.status.value,
        probability=report.probability,
        reason=report.reason,
        next=report.next,
    )
