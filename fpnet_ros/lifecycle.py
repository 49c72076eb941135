# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lifecycle nodes that start themselves unless told otherwise, and say why they do not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from typing import Any

from pydantic import Field
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.task import Future as ExecutorFuture

from fpnet_core.config import Section
from fpnet_core.errors import FpnetError
from fpnet_ros.bond import Bond
from fpnet_ros.optional_messages import NO_BOND, BondStatus
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.runtime import described, run_node
from fpnet_ros.work import in_background

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
ERROR = TransitionCallbackReturn.ERROR


class TransitionError(FpnetError):
    """A step of the lifecycle failed; the message says which one and why."""


class LifecycleParameters(Section):
    """How the node starts."""

    autostart: bool = Field(
        True, description='Configure and activate at the start, without a lifecycle manager.'
    )


class ManagedNode(OwnValues, LifecycleNode):
    """
    A lifecycle node whose transitions are four methods to override.

    Before the first one :meth:`prepare` runs, beside the executor's thread where
    :func:`run_managed` runs the node. Each may raise. Bad input (an FpnetError) fails the
    transition, and the node stays where it was; anything else is a defect: the node gives up
    everything and is unconfigured again. Either is logged once. What ``configure`` makes with the
    ``add_...`` methods is destroyed when the node is cleaned up, and publishes only while active.
    One that does not start itself has a
    bond to whoever does.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.is_active = False
        self._autostart = ParameterTree(self, LifecycleParameters).value.autostart
        self._bond = None if self._autostart else self._bond_to_manager()
        self._prepared: Future[None] | None = None
        self._undo: list[Callable[[], Any]] = []
        self._error: TransitionError | None = None
        self._is_starting = False
        # rclpy lets a request that does not fit the state end the process.
        self._change_state = self._service_change_state.callback
        self._service_change_state.callback = self._on_change_state

    def _bond_to_manager(self) -> Bond | None:
        if BondStatus is None:
            self.get_logger().warning(NO_BOND)
            return None
        return Bond(self)

    @property
    def way_to_change(self) -> str:
        """What to do about a parameter that is read when the node is configured."""
        name = self.get_fully_qualified_name()
        return (
            f'is read when the node is configured: ros2 lifecycle set {name} deactivate, then '
            'cleanup, set it, then configure and activate'
        )

    def prepare(self) -> None:
        """Do once what takes long and needs no ROS: meanwhile the node answers."""

    def prepared(self) -> Future[None]:
        """Return the end of ``prepare``, which begins now if it has not succeeded yet."""
        if self._prepared is None or (self._prepared.done() and self._prepared.exception()):
            self._prepared = in_background(self.prepare)
        return self._prepared

    def configure(self) -> None:
        """Read parameters, load, and make publishers, subscriptions, services and timers."""

    def activate(self) -> None:
        """Begin to work; publishers publish from here on."""

    def deactivate(self) -> None:
        """Pause."""

    def cleanup(self) -> None:
        """Begin to give up what ``configure`` made, or made in part: the rest goes by itself."""

    def start(self) -> None:
        """
        Configure and activate, unless the parameter ``autostart`` is false.

        Raises
        ------
        FpnetError
            If the node cannot be configured or activated.
        """
        if not self._autostart:
            return
        self._is_starting = True
        for trigger in (self.trigger_configure, self.trigger_activate):
            if trigger() != SUCCESS:
                raise self._error or TransitionError('the node could not be started')
        self._is_starting = False

    def add_publisher(self, kind: type, topic: str, qos: Any) -> Any:
        """Return a publisher that is silent unless the node is active."""
        options = QoSOverridingOptions.with_default_policies()
        publisher = self.create_lifecycle_publisher(
            kind, topic, qos, qos_overriding_options=options
        )
        self._undo.append(lambda: self.destroy_lifecycle_publisher(publisher))
        return publisher

    def add_subscription(
        self, kind: type, topic: str, callback: Callable[..., None], qos: Any, raw: bool = False
    ) -> Any:
        """Subscribe as every node does, until the node is cleaned up."""
        subscription = super().add_subscription(kind, topic, callback, qos, raw)
        self._undo.append(lambda: self.destroy_subscription(subscription))
        return subscription

    def add_service(self, kind: type, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """Offer a service."""
        service = self.create_service(kind, name, callback)
        self._undo.append(lambda: self.destroy_service(service))

    def add_slow_service(self, kind: type, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """
        Offer a service whose callback is a coroutine: while it waits, the node does all else.

        It exists as long as the node, as an answer that is still due needs it; the callback
        refuses while the node is not configured.
        """
        self.create_service(kind, name, callback, callback_group=MutuallyExclusiveCallbackGroup())

    async def finished(self, work: Future[Any]) -> None:
        """Wait, in a coroutine of the executor, for work that another thread does."""
        done = ExecutorFuture()

        def wake(_: Future[Any]) -> None:
            done.set_result(None)
            if self.executor is not None:
                self.executor.wake()

        work.add_done_callback(wake)
        await done

    def add_timer(self, period_s: float, callback: Callable[[], None], clock: Any = None) -> Any:
        """Return a running timer; ``clock`` None is the node's own."""
        timer = self.create_timer(period_s, callback, clock=clock)
        self._undo.append(lambda: self.destroy_timer(timer))
        return timer

    def add_end(self, end: Callable[[], Any]) -> None:
        """Have something ended when the node is cleaned up, before what was made earlier."""
        self._undo.append(end)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run ``configure``; on bad input give up what was made."""

        def configure() -> None:
            self.prepared().result()
            self.configure()

        result = self._guarded('configure', configure)
        if result == FAILURE and self._guarded('cleanup', self._release) != SUCCESS:
            return ERROR
        return result if result != SUCCESS else super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Open the publishers, then run ``activate``."""
        super().on_activate(state)
        self.is_active = True
        result = self._guarded('activate', self.activate)
        if result == SUCCESS:
            self.get_logger().info('active')
            if self._bond is not None:
                self._bond.form()
            return result
        self.is_active = False
        super().on_deactivate(state)
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run ``deactivate``, then close the publishers."""
        self.is_active = False
        result = self._guarded('deactivate', self.deactivate)
        if result == SUCCESS:
            self.get_logger().info('inactive')
            self._dissolve_bond()
        elif result == FAILURE:  # it stays active
            self.is_active = True
            return result
        super().on_deactivate(state)
        return result

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give up everything that ``configure`` made."""
        # What is half given up cannot be used: a failure is an error here.
        return SUCCESS if self._guarded('cleanup', self._release) == SUCCESS else ERROR

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give up everything; a node in this state is never used again."""
        return FAILURE if self._guarded('shutdown', self._release) != SUCCESS else SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give up everything after a defect: unconfigured, or finalized where that fails, too."""
        return FAILURE if self._guarded('error', self._release) != SUCCESS else SUCCESS

    def destroy_node(self) -> None:
        """Give up everything, in whatever state."""
        self._guarded('cleanup', self._release)
        super().destroy_node()

    def _guarded(self, step: str, run: Callable[[], None]) -> TransitionCallbackReturn:
        """Run a step; log what it raises, once: the first error of a start is the caller's."""
        try:
            run()
        except Exception as error:  # rclpy drops them in silence
            said = f'{step} failed: {described(error)}'
            is_first, self._error = self._error is None, self._error or TransitionError(said)
            if not (is_first and self._is_starting):
                self.get_logger().error(said)
            return FAILURE if isinstance(error, FpnetError) else ERROR
        return SUCCESS

    def _on_change_state(self, request: Any, response: Any) -> Any:
        self._error = None
        try:
            return self._change_state(request, response)
        except rclpy_implementation.RCLError:
            wanted = request.transition.label or request.transition.id
            label = self._state_machine.current_state[1]
            self.get_logger().warning(f'no transition {wanted} from state {label}; ignored')
            response.success = False
            return response

    def _dissolve_bond(self) -> None:
        if self._bond is not None:
            self._bond.dissolve()

    def _release(self) -> None:
        """Give up everything, one after the other, whatever one of them raises."""
        self.is_active = False
        with ExitStack() as steps:
            steps.callback(self._dissolve_bond)
            while self._undo:
                steps.callback(self._undo.pop(0))
            steps.callback(self.cleanup)


def run_managed(make_node: Callable[[], ManagedNode], arguments: Sequence[str] | None) -> int:
    """Run a lifecycle node until it is interrupted; returns the process's exit status."""
    return run_node(make_node, arguments, spin)


def spin(node: ManagedNode) -> None:
    """Prepare a node, start it, and go on until it is interrupted; it answers all the time."""
    rclpy.spin_until_future_complete(node, node.prepared())
    node.start()
    rclpy.spin(node)
