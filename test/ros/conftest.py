# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real nodes in processes of their own, in a private domain; the test is one more participant."""

from collections.abc import Callable, Iterator
import os
from pathlib import Path
import time
from typing import Any

import pytest

rclpy = pytest.importorskip('rclpy')

from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402

from fpnet_ros.processes import (  # noqa: E402
    Child,
    ProcessGroup,
    free_domain_id,
    node_command,
    private_environment,
    ros_arguments,
)


class Bench:
    """A test's own node, and what it needs to start others beside it."""

    def __init__(self, node: Node, executor: SingleThreadedExecutor, group: ProcessGroup) -> None:
        self.node = node
        self.group = group
        self._executor = executor

    def start(self, name: str, parameters=None, remappings=None, command=None) -> Child:
        arguments = ros_arguments(parameters, remappings)
        return self.group.start(name, [*(command or node_command(name)), *arguments])

    def start_as(self, log_name: str, name: str, parameters=None) -> Child:
        """Start one of several nodes of the same kind."""
        return self.group.start(log_name, [*node_command(name), *ros_arguments(parameters)])

    def collect(self, kind: type, topic: str, qos: Any) -> list[Any]:
        """Subscribe, and return the list that messages are appended to."""
        received: list[Any] = []
        self.node.create_subscription(kind, topic, received.append, qos)
        return received

    def wait_for(self, condition: Callable[[], bool], timeout_s: float = 30.0) -> bool:
        """Spin until the condition holds; False if it does not in time."""
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=0.05)
        return True


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    domain_id = free_domain_id()
    environment = private_environment(domain_id)
    for name in set(environment) - set(os.environ) | {'ROS_DOMAIN_ID'}:
        monkeypatch.setenv(name, environment[name])
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain_id)
    executor = SingleThreadedExecutor(context=context)
    node = Node('test_bench', context=context)
    executor.add_node(node)
    with ProcessGroup(tmp_path / 'log', environment) as group:
        yield Bench(node, executor, group)
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)
