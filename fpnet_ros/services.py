# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What others ask of the localizer node: pose hints, services and an action."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
import math
import time
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future as ExecutorFuture
from std_srvs.srv import Empty, Trigger

from fpnet_core.errors import FpnetError
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.inputs import LocatedScan
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.logs import one_line
from fpnet_ros.runtime import NO_ACTION, NO_SERVICE, STREAM, Localize, SetInitialPose
from msg_adapters.diagnostics import LocalizerReport
from msg_adapters.poses import UncertainPose, uncertain_pose_from_msg

# Feedback is repeated after this time, because a client's subscription may match only after its
# goal was accepted and miss the first one. Numerical: well below a behaviour tree's timeouts.
_FEEDBACK_EVERY_S = 1.0


class InitialPoses:
    """
    Passes pose hints to the localizer, in the executor's thread, and logs each.

    A hint refers to a floorplan and a scan, those of ``situation()``, or for the plan of a storey
    to ``frame_named(frame)``. Before there are both it waits; a newer hint replaces it. ``first``
    is the hint from the parameters, if any.
    """

    def __init__(
        self,
        situation: Callable[[], tuple[MapFrame | None, LocatedScan | None]],
        frame_named: Callable[[str], tuple[str, MapFrame] | None],
        suggest: Callable[[PoseHint], None],
        logger: Any,
        first: UncertainPose | None = None,
    ) -> None:
        self._situation, self._frame_named = situation, frame_named
        self._suggest, self._logger = suggest, logger
        self._waiting = None if first is None else (first, 'parameter initial_pose')

    def on_message(self, msg: PoseWithCovarianceStamped, source: str = 'initialpose') -> None:
        """Take a hint from a message; log and ignore an unusable one."""
        try:
            self._waiting = uncertain_pose_from_msg(msg), source
        except FpnetError as error:
            self._reject(source, error)
            return
        self.follow()
        if self._waiting is not None:
            self._logger.info(f'{source} waits for the first floorplan and the first scan')

    def follow(self) -> None:
        """Use a waiting hint once there are a floorplan and a scan."""
        if self._waiting is None:
            return
        given, source = self._waiting
        pose, (frame, scan) = given.pose, self._situation()
        storey, frame = self._frame_named(pose.frame_id) or ('', frame)
        if frame is None or scan is None:
            return
        self._waiting = None
        try:
            hint = frame.hint(pose.T_frame_body, pose.frame_id, given.cov, scan.T_odom_base)
        except FpnetError as error:
            self._reject(source, error)
            return
        self._suggest(replace(hint, storey=storey))
        self._logger.info('received the initial pose; it takes effect once scans confirm it')

    def _reject(self, source: str, error: FpnetError) -> None:
        self._logger.warning(f'{source} was rejected: {one_line(error)}')


def offer_services(
    node: ManagedNode,
    hints: InitialPoses,
    search_again: Callable[[], None],
    reset: Callable[[], None],
    update: Callable[[], None],
    is_amcl_there: bool,
) -> None:
    """Offer the node's services, and AMCL's topic and services unless AMCL is there to do it."""

    def offer(kind: type, name: str, act: Callable[[Any], Any], **answer: Any) -> None:
        def on_request(request: Any, response: Any) -> Any:
            act(request)
            for key, value in answer.items():
                setattr(response, key, value)
            return response

        node.add_service(kind, name, on_request)

    def on_reset(_: Any) -> None:
        reset()
        search_again()

    def done(message: str) -> dict[str, Any]:
        return {'success': True, 'message': message}

    kept = done('discarded all hypotheses; the submap stays')
    offer(Trigger, '~/relocalize', lambda _: search_again(), **kept)
    offer(Trigger, '~/reset', on_reset, **done('discarded the submap and all hypotheses'))
    if SetInitialPose is None:
        node.get_logger().warning(NO_SERVICE)
    else:
        for name in ('~/set_initial_pose', *(() if is_amcl_there else ('set_initial_pose',))):
            offer(SetInitialPose, name, lambda r: hints.on_message(r.pose, 'set_initial_pose'))
    if not is_amcl_there:
        offer(Empty, 'reinitialize_global_localization', lambda _: search_again())
        offer(Empty, 'request_nomotion_update', lambda _: update())
        node.add_subscription(PoseWithCovarianceStamped, 'initialpose', hints.on_message, STREAM)


def offer_save_state(
    node: ManagedNode, path: Callable[[], str], save: Callable[[], Future[str] | None]
) -> None:
    """
    Offer ``~/save_state``; the response is sent once the file is written.

    ``save`` starts to save; its future has the error message, empty on success. It returns None
    if the node is not configured.
    """

    async def on_save(_: Any, response: Trigger.Response) -> Trigger.Response:
        if not path():
            response.message = 'parameter state_file is empty; set it to a path'
        elif (saved := save()) is None:
            response.message = 'the node is not configured'
        else:
            await node.finished(saved)
            error = 'the node was cleaned up' if saved.cancelled() else saved.result()
            response.success, response.message = not error, error or f'saved to {path()}'
        return response

    node.add_slow_service(Trigger, '~/save_state', on_save)


@dataclass(eq=False)
class _Goal:
    """An active goal; the future ``ended`` gets its result."""

    handle: Any
    deadline_s: float
    ended: ExecutorFuture = field(default_factory=ExecutorFuture)
    told: LocalizerReport | None = None
    told_s: float = -math.inf


class LocalizeAction:
    """
    Serves any number of goals of ``~/localize``: each waits until the node is localized.

    Everything runs in the executor's thread, which calls :meth:`follow` often. The server exists
    as long as the node, because pending results need it; it rejects goals while the node is not
    active. If the action's type is not installed there is no server, and the log says so.
    ``search_again`` discards all hypotheses, for goals with ``anew``.
    """

    def __init__(self, node: ManagedNode, search_again: Callable[[], None]) -> None:
        self._node, self._search_again = node, search_again
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
        now_s = time.monotonic()
        for goal in list(self._goals):
            if report is not goal.told or now_s > goal.told_s + _FEEDBACK_EVERY_S:
                goal.told, goal.told_s = report, now_s
                goal.handle.publish_feedback(_feedback(report))
            if goal.handle.is_cancel_requested:
                goal.handle.canceled()
                self._end(goal, Localize.Result.CANCELED, 'the goal was cancelled')
            elif pose is not None:
                goal.handle.succeed()
                self._end(goal, Localize.Result.NONE, '', pose)
            elif now_s > goal.deadline_s:
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
            self._search_again()
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
