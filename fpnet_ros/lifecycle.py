# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Base class of the lifecycle nodes, which by default start themselves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from typing import Any
from uuid import uuid4

from lifecycle_msgs.srv import ChangeState
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.task import Future as ExecutorFuture

from fpnet_core.errors import FpnetError
from fpnet_ros.logs import described
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.runtime import NO_BOND, STREAM, BondStatus, run_node
from fpnet_ros.settings import LifecycleParameters
from fpnet_ros.work import in_background
from msg_adapters.stamps import header_to_msg

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
ERROR = TransitionCallbackReturn.ERROR

# Given: Nav2's default of bond_heartbeat_period, and the heartbeat timeout of its bonds.
_BOND_PERIOD_S, _BOND_TIMEOUT_S = 0.25, 4.0


class ManagedNode(OwnValues, LifecycleNode):
    """
    Lifecycle node; subclasses override one method for each of four transitions.

    :meth:`prepare` runs before the first transition, beside the executor's thread if
    :func:`run_managed` runs the node. Each method may raise. An FpnetError (bad input) fails the
    transition, and the node keeps its state; any other exception is a defect: the node releases
    everything and becomes unconfigured. Both are logged once. What ``configure`` creates with the
    ``add_...`` methods is destroyed at cleanup and publishes only while the node is active.
    Without ``autostart`` the node has a bond to its lifecycle manager.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.is_active = False
        self._autostart = ParameterTree(self, LifecycleParameters).value.autostart
        self._bond = _Bond(self, is_wanted=not self._autostart)
        self._prepared: Future[None] | None = None
        self._undo = ExitStack()
        self._error: FpnetError | None = None  # the first one of a transition
        self._is_starting = False
        # In rclpy a transition request that does not fit the state ends the process.
        (service,) = (each for each in self.services if each.srv_type is ChangeState)
        self._change_state, service.callback = service.callback, self._on_change_state

    @property
    def way_to_change(self) -> str:
        """Instructions to change a parameter that is read when the node is configured."""
        name = self.get_fully_qualified_name()
        return (
            f'is read when the node is configured: ros2 lifecycle set {name} deactivate, then '
            'cleanup, set it, then configure and activate'
        )

    def prepare(self) -> None:
        """Do slow work without ROS, once; the node answers requests meanwhile."""

    def configure(self) -> None:
        """Read parameters and files; create publishers, subscriptions, services and timers."""

    def activate(self) -> None:
        """Start working; publishers are enabled from here on."""

    def deactivate(self) -> None:
        """Pause; publishers are disabled afterwards."""

    def cleanup(self) -> None:
        """Start to release what ``configure`` created, perhaps in part; the rest is automatic."""

    def prepared(self) -> Future[None]:
        """Return the future of ``prepare``; start it if it has not succeeded yet."""
        if self._prepared is None or (self._prepared.done() and self._prepared.exception()):
            self._prepared = in_background(self.prepare)
        return self._prepared

    def start(self) -> None:
        """Configure and activate with ``autostart``; raise FpnetError if that fails."""
        if not self._autostart:
            return
        self._is_starting = True
        for trigger in (self.trigger_configure, self.trigger_activate):
            if trigger() != SUCCESS:
                raise self._error or FpnetError('the node could not be started')
        self._is_starting = False

    def add_publisher(self, kind: type, topic: str, qos: Any) -> Any:
        """Return a publisher that is silent unless the node is active."""
        options = QoSOverridingOptions.with_default_policies()
        publisher = self.create_lifecycle_publisher(
            kind, topic, qos, qos_overriding_options=options
        )
        self._undo.callback(self.destroy_lifecycle_publisher, publisher)
        return publisher

    def add_subscription(
        self, kind: type, topic: str, callback: Callable[..., None], qos: Any, raw: bool = False
    ) -> Any:
        """Subscribe until the node is cleaned up; otherwise as :class:`OwnValues`."""
        subscription = super().add_subscription(kind, topic, callback, qos, raw)
        self._undo.callback(self.destroy_subscription, subscription)
        return subscription

    def add_service(self, kind: type, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """Offer a service until the node is cleaned up."""
        self._undo.callback(self.destroy_service, self.create_service(kind, name, callback))

    def add_slow_service(self, kind: type, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """
        Offer a service whose callback is a coroutine, which does not block the node.

        The service exists as long as the node, because pending responses need it; the callback
        must refuse requests while the node is not configured.
        """
        self.create_service(kind, name, callback, callback_group=MutuallyExclusiveCallbackGroup())

    def add_timer(self, period_s: float, callback: Callable[[], None], clock: Any = None) -> Any:
        """Return a running timer; ``clock`` None uses the node's clock."""
        timer = self.create_timer(period_s, callback, clock=clock)
        self._undo.callback(self.destroy_timer, timer)
        return timer

    def add_end(self, end: Callable[[], Any]) -> None:
        """Register a function to call at cleanup, in reverse order of creation."""
        self._undo.callback(end)

    async def finished(self, work: Future[Any]) -> None:
        """Await work of another thread, in a coroutine of the executor."""
        done = ExecutorFuture()

        def wake(_: Future[Any]) -> None:
            done.set_result(None)
            if self.executor is not None:
                self.executor.wake()

        work.add_done_callback(wake)
        await done

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run ``configure``; on bad input release what it created."""
        result = self._guarded('configure', lambda: self.prepared().result(), self.configure)
        if result == FAILURE and self._guarded('cleanup', self._release) != SUCCESS:
            return ERROR
        return result if result != SUCCESS else super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Enable the publishers, then run ``activate``."""
        super().on_activate(state)
        self.is_active = True
        result = self._guarded('activate', self.activate)
        if result == SUCCESS:
            self.get_logger().info('active')
            self._bond.form()
            return result
        self.is_active = False
        super().on_deactivate(state)
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run ``deactivate``, then disable the publishers; on bad input the node stays active."""
        self.is_active = False
        result = self._guarded('deactivate', self.deactivate)
        if result == FAILURE:
            self.is_active = True
            return result
        if result == SUCCESS:
            self.get_logger().info('inactive')
            self._bond.dissolve()
        super().on_deactivate(state)
        return result

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release everything; a partly released node is unusable, so any failure is an error."""
        return SUCCESS if self._guarded('cleanup', self._release) == SUCCESS else ERROR

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release everything; a node in this state is never used again."""
        return FAILURE if self._guarded('shutdown', self._release) != SUCCESS else SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release everything after a defect: unconfigured, or finalized if that fails as well."""
        return FAILURE if self._guarded('error', self._release) != SUCCESS else SUCCESS

    def destroy_node(self) -> None:
        """Release everything, in any state."""
        self._guarded('cleanup', self._release)
        super().destroy_node()

    def _guarded(self, step: str, *actions: Callable[[], Any]) -> TransitionCallbackReturn:
        """Run a step and log its error once; the caller logs the first error of a start."""
        try:
            for act in actions:
                act()
        except Exception as error:  # rclpy would drop it silently
            said = f'{step} failed: {described(error)}'
            is_first, self._error = self._error is None, self._error or FpnetError(said)
            if not (is_first and self._is_starting):
                self.get_logger().error(said)
            return FAILURE if isinstance(error, FpnetError) else ERROR
        return SUCCESS

    def _on_change_state(self, request: Any, response: Any) -> Any:
        self._error = None
        try:
            return self._change_state(request, response)
        except RuntimeError:  # of rcl; errors of the steps are guarded
            wanted = request.transition.label or request.transition.id
            label = self._state_machine.current_state[1]
            self.get_logger().warning(f'no transition {wanted} from state {label}; ignored')
            response.success = False
            return response

    def _release(self) -> None:
        """Release everything in reverse order of creation, even if a step raises."""
        self.is_active = False
        with ExitStack() as steps:
            steps.callback(self._bond.dissolve)
            steps.callback(self._undo.close)
            steps.callback(self.cleanup)


class _Bond:
    """
    Heartbeat on ``bond`` while a node is active, as Nav2's lifecycle manager expects it.

    This is the watched side of bondcpp's protocol: the manager keeps the bond, which has the
    node's name, as long as it receives this heartbeat, four times a second as from Nav2's nodes.
    The class does not subscribe, because all of them and their manager publish on that one topic.
    """

    def __init__(self, node: Node, is_wanted: bool) -> None:
        self._node, self._publisher = node, None
        self._instance = ''
        self._timer: Any = None
        if is_wanted and BondStatus is not None:
            self._publisher = node.create_publisher(BondStatus, 'bond', STREAM)
        elif is_wanted:
            node.get_logger().warning(NO_BOND)

    def form(self) -> None:
        """Start a new bond, if one is wanted."""
        if self._publisher is None:
            return
        self._instance = str(uuid4())
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # simulated time may be paused
        self._timer = self._node.create_timer(_BOND_PERIOD_S, self._beat, clock=steady)
        self._beat()

    def dissolve(self) -> None:
        """End the bond, if any, so that the manager does not wait for its timeout."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
            if self._node.context.ok():  # otherwise publishing would fail
                self._beat()

    def _beat(self) -> None:
        self._publisher.publish(
            BondStatus(
                header=header_to_msg(self._node.get_clock().now().nanoseconds, ''),
                id=self._node.get_name(),
                instance_id=self._instance,
                active=self._timer is not None,
                heartbeat_timeout=_BOND_TIMEOUT_S,
                heartbeat_period=_BOND_PERIOD_S,
            )
        )


def run_managed(make_node: Callable[[], ManagedNode], arguments: Sequence[str] | None) -> int:
    """Run a lifecycle node until it is interrupted and return the process's exit status."""
    return run_node(make_node, arguments, spin)


def spin(node: ManagedNode) -> None:
    """Prepare a node, start it and spin until interrupted; it answers requests throughout."""
    rclpy.spin_until_future_complete(node, node.prepared())
    node.start()
    rclpy.spin(node)
