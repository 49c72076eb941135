# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real nodes in processes of their own, in a private domain; the test is one more participant."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest
from stopwatch import Stopwatch

from fpnet.bag_writer import BagWriter
from fpnet.recordings.trajectories import write_tum
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.sim.drives.recording import (
    CLOUD_TOPIC,
    LIDAR_FRAME,
    RecordingOptions,
    make_recording,
)
from fpnet_lab.sim.lidars.sensors import LidarModel

rclpy = pytest.importorskip('rclpy')

from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402

from fpnet_lab.nodes.processes import (  # noqa: E402
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

    def start_as(self, log_name: str, name: str, parameters=None, remappings=None) -> Child:
        """Start one of several nodes of the same kind."""
        arguments = ros_arguments(parameters, remappings)
        return self.group.start(log_name, [*node_command(name), *arguments])

    def collect(self, kind: type, topic: str, qos: Any) -> list[Any]:
        """Subscribe, and return the list that messages are appended to."""
        received: list[Any] = []
        self.node.create_subscription(kind, topic, received.append, qos)
        return received

    def call(self, kind: type, name: str, request: Any = None, timeout_s: float = 120.0) -> Any:
        """Call a service and return its response; None if it does not answer in time."""
        client = self.node.create_client(kind, name)
        assert self.wait_for(client.service_is_ready, timeout_s), name
        future = client.call_async(request or kind.Request())
        return future.result() if self.wait_for(future.done, timeout_s) else None

    def wait_for(self, condition: Callable[[], bool], timeout_s: float = 120.0) -> bool:
        """Spin until the condition holds; False if it does not in time."""
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=0.05)
        return True

    def wait_soon(self, condition: Callable[[], bool], seconds: float) -> bool:
        """Spin until the condition holds; False if a quiet machine had seconds for it."""
        watch = Stopwatch()
        while not condition():
            if watch.elapsed_s > seconds:
                return False
            self._executor.spin_once(timeout_sec=0.05)
        return True


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with _bench_in(tmp_path) as bench:
        yield bench


@pytest.fixture(scope='module')
def shared_bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """One for all tests of a module, where starting its nodes takes long."""
    with _bench_in(tmp_path_factory.mktemp('bench')) as bench:
        yield bench


@contextmanager
def _bench_in(folder: Path) -> Iterator[Bench]:
    domain_id = free_domain_id()
    environment = private_environment(domain_id)
    with pytest.MonkeyPatch.context() as monkeypatch:
        for name in set(environment) - set(os.environ) | {'ROS_DOMAIN_ID'}:
            monkeypatch.setenv(name, environment[name])
        yield from _bench(folder, domain_id, environment)


def _bench(folder: Path, domain_id: int, environment: dict[str, str]) -> Iterator[Bench]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain_id)
    executor = SingleThreadedExecutor(context=context)
    node = Node('test_bench', context=context)
    executor.add_node(node)
    with ProcessGroup(folder / 'log', environment) as group:
        yield Bench(node, executor, group)
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


SWEEP_S = 0.1
COARSE = LidarModel(beams=16, columns=300)  # odometry takes a fraction of the time
SCANS = 300  # half a minute of the tour: a slow machine needs more of it to be localised


@dataclass(frozen=True)
class Excerpt:
    """The start of a simulated recording, as ``write_recording`` would write it."""

    folder: Path
    floorplan: Path
    stamps_ns: np.ndarray
    truth: PlanarTrajectory
    A_plan_building: Affine2D


@pytest.fixture(scope='session')
def excerpt(tmp_path_factory: pytest.TempPathFactory) -> Excerpt:
    folder = tmp_path_factory.mktemp('excerpt')
    recording = make_recording(0, RecordingOptions(lidar=COARSE))
    write_map(recording.floorplan, folder / 'floorplan.yaml')
    with BagWriter(folder / 'bag') as bag:
        for index in range(SCANS):
            scan = recording.scan(index)
            bag.write_cloud(
                CLOUD_TOPIC,
                scan.stamp_ns,
                LIDAR_FRAME,
                scan.points,
                scan.intensity,
                scan.ring,
                # Since the stamp, which is the end of the sweep.
                (scan.time_s - SWEEP_S).astype(np.float32),
            )
            bag.write_pose('/ground_truth/pose', scan.stamp_ns, 'building', scan.T_truth_sensor)
    poses = recording.truth()[:SCANS]
    yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    truth = PlanarTrajectory(recording.stamps_ns[:SCANS], poses[:, :2, 3], yaw)
    write_tum(folder / 'truth.tum', truth.stamps_ns, truth.xy, truth.yaw)
    facts = {'A_plan_building': recording.A_plan_building.matrix[:2].tolist()}
    (folder / 'truth.json').write_text(json.dumps(facts))
    return Excerpt(
        folder, folder / 'floorplan.yaml', truth.stamps_ns, truth, recording.A_plan_building
    )


@pytest.fixture(scope='session')
def install_space(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the package with colcon in a workspace of its own; returns ``install``."""
    workspace = tmp_path_factory.mktemp('workspace')
    root = Path(__file__).parents[2]
    scripts = Path(sys.executable).parent
    colcon = shutil.which('colcon', path=f'{scripts}{os.pathsep}{os.environ["PATH"]}')
    if colcon is None:
        pytest.fail('colcon is missing; install requirements-dev.txt')
    environment = dict(os.environ)
    environment['PATH'] = f'{scripts}{os.pathsep}{environment["PATH"]}'
    environment.setdefault('AMENT_PREFIX_PATH', sys.prefix)
    subprocess.run(
        [
            *(colcon, '--log-base', 'log', 'build', '--base-paths', str(root)),
            *('--packages-select', 'fpnet_ros'),
        ],
        cwd=workspace,
        env=environment,
        check=True,
    )
    return workspace / 'install'
