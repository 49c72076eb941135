# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lifecycle nodes that start themselves unless told otherwise, and say why they do not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any

from pydantic import Field
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.task import Future as ExecutorFuture

from fpnet_core.config import Section
from fpnet_core.errors import FpnetError
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import one_line, run_node

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class LifecycleParameters(Section):
    """How the node starts."""

    autostart: bool = Field(
        True, description='Configure and activate at the start, without a lifecycle manager.'
    )


class ManagedNode(LifecycleNode):
    """
    A lifecycle node whose transitions are four methods to override.

    ``configure`` raises FpnetError on bad input: the transition fails, with the error logged, and
    the node stays unconfigured. What it makes with the ``add_...`` methods is destroyed when
    the node is cleaned up, and publishes only while active.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.is_active = False
        self._autostart = ParameterTree(self, LifecycleParameters).value.autostart
        self._undo: list[Callable[[], Any]] = []
        self._error: FpnetError | None = None
        self._is_starting = False

    def configure(self) -> None:
        """Read parameters, load, and make publishers, subscriptions, services and timers."""

    def activate(self) -> None:
        """Begin to work; publishers publish from here on."""

    def deactivate(self) -> None:
        """Pause."""

    def cleanup(self) -> None:
        """Give up what ``configure`` made beside ROS entities; it may have made it in part."""

    def start(self) -> None:
        """
        Configure and activate, unless the parameter ``autostart`` is false.

        Raises
        ------
        FpnetError
            If the node cannot be configured.
        """
        if not self._autostart:
            return
        self._is_starting = True
        self.trigger_configure()
        self._is_starting = False
        if self._error is not None:
            raise self._error
        self.trigger_activate()

    def add_publisher(self, kind: type, topic: str, qos: Any) -> Any:
        """Return a publisher that is silent unless the node is active."""
        publisher = self.create_lifecycle_publisher(
            kind,
            topic,
            qos,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )
        self._undo.append(lambda: self.destroy_lifecycle_publisher(publisher))
        return publisher

    def add_subscription(
        self, kind: type, topic: str, callback: Callable[..., None], qos: Any, raw: bool = False
    ) -> None:
        """
        Subscribe; the callback takes the message, or the message and its information.

        ``raw`` messages are handed over as serialized bytes.
        """
        subscription = self.create_subscription(
            kind,
            topic,
            callback,
            qos,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            raw=raw,
        )
        self._undo.append(lambda: self.destroy_subscription(subscription))

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

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run ``configure``; on an error give up what was made."""
        self._error = None
        try:
            self.configure()
        except FpnetError as error:
            self._error = error
            if not self._is_starting:
                self.get_logger().error(one_line(error))
            self._release()
            return FAILURE
        result: TransitionCallbackReturn = super().on_configure(state)
        return result

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Open the publishers, then run ``activate``."""
        result: TransitionCallbackReturn = super().on_activate(state)
        self.is_active = True
        self.activate()
        self.get_logger().info('active')
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run ``deactivate``, then close the publishers."""
        self.is_active = False
        self.deactivate()
        self.get_logger().info('inactive')
        result: TransitionCallbackReturn = super().on_deactivate(state)
        return result

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give up everything that ``configure`` made."""
        self._release()
        return SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give up everything; a node in this state is never used again."""
        self._release()
        return SUCCESS

    def destroy_node(self) -> None:
        """Give up everything, in whatever state."""
        self._release()
        super().destroy_node()

    def _release(self) -> None:
        self.is_active = False
        self.cleanup()
        while self._undo:
            self._undo.pop()()


def run_managed(make_node: Callable[[], ManagedNode], arguments: Sequence[str] | None) -> int:
    """Run a lifecycle node until it is interrupted; returns the process's exit status."""

    def run(node: ManagedNode) -> None:
        node.start()
        rclpy.spin(node)

    return run_node(make_node, arguments, run)
