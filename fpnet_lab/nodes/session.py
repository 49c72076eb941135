# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Program that runs all nodes over a recording, each in a process of its own, over DDS.

``fpnet demo`` simulates the recording, runs this program and evaluates the result; it is a
separate program because commands import no ROS. It starts ``floorplan_server``, ``odometry``,
``localizer`` and ``replay`` in a private ROS domain, subscribes to ``/floorplan_pose``, and writes

- ``poses.tum``: every published pose, in the frame of the floorplan;
- ``session.json``: the localizer's status after each update, and counts of scans;
- ``last_tick.npz``: the localizer's last update;
- ``log/*.log``: the output of each process.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
import os
from pathlib import Path
import signal
import sys
import time
from types import FrameType
from typing import NamedTuple

from fpnet_core.errors import BagFormatError, FpnetError
from fpnet_core.io.bags import BagReader
from fpnet_core.io.message_types import LASER_SCAN, POINT_CLOUD
from fpnet_core.io.topic_names import KISS_FRAME
from fpnet_lab.nodes.monitor import Monitor
from fpnet_lab.nodes.processes import (
    Child,
    ProcessGroup,
    free_domain_id,
    node_command,
    private_environment,
    ros_arguments,
)
from fpnet_ros.wiring import wired

# Chosen, not measured:
_READY_S = 300.0  # the first start after an installation compiles
_QUIET_S = 5.0  # odometry without output for this long after the last cloud is done
_STALLED_S = 90.0
_POLL_S = 0.1
_MAX_AHEAD = 20  # scans; a slow machine then plays slower and gives the same result


@dataclass(frozen=True)
class SessionOptions:
    """
    Options of a session.

    ``bag`` holds one topic of clouds or of laser scans; ``out`` is the folder for results and
    logs; ``rate`` is in recorded seconds per second; ``params_file`` configures every node, None
    uses the defaults.
    """

    bag: Path
    floorplan: Path
    out: Path
    rate: float = 1.0
    params_file: Path | None = None


class _Topic(NamedTuple):
    """Topic of the scans in a recording."""

    name: str
    is_laser: bool
    count: int


class Interruption:
    """
    Defers SIGINT and SIGTERM until the session checks for them.

    An exception at an arbitrary point could be lost in a destructor, or leave the middleware half
    initialized.
    """

    def __init__(self) -> None:
        self._is_signalled = False
        self._parent = os.getppid()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal has come, or the parent has ended."""
        if self._is_signalled or os.getppid() != self._parent:
            raise KeyboardInterrupt

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        self._is_signalled = True


def run_session(options: SessionOptions, interruption: Interruption) -> None:
    """
    Run the nodes until the recording is played and processed, and write the results.

    Raises
    ------
    FpnetError
        If the recording has no scans, or a node dies or stops publishing.
    KeyboardInterrupt
        If interrupted, after every node has ended.
    """
    topic = _scan_topic(options.bag)
    domain_id = free_domain_id()
    environment = private_environment(domain_id)
    with ProcessGroup(options.out / 'log', environment) as group:
        _start_listening_nodes(group, options, topic)
        os.environ.update(environment)
        with Monitor(topic.count) as monitor:

            def spin() -> None:
                monitor.spin(_POLL_S)
                interruption.check()

            _wait_until(lambda: monitor.is_ready(topic.name), spin, group)
            replay = group.start('replay', _replay_command(options, topic.name))
            _follow(monitor, spin, group, replay)
    monitor.write(options.out)


def _scan_topic(path: Path) -> _Topic:
    """Return the topic of a recording's clouds, or of its laser scans if it has no clouds."""
    with BagReader(path) as bag:
        for kind in (POINT_CLOUD, LASER_SCAN):
            topics = [topic for topic, msgtype in bag.topics.items() if msgtype == kind]
            if len(topics) == 1:
                return _Topic(topics[0], kind == LASER_SCAN, bag.count(topics[0]))
            if topics:
                break
        raise BagFormatError(
            f'bag {path} has {len(topics)} scan topics, expected one; record one lidar'
        )


def _start_listening_nodes(group: ProcessGroup, options: SessionOptions, topic: _Topic) -> None:
    # Reliable, so that the result does not depend on this machine's shared memory.
    reliable = 'qos_overrides.{}.subscription.reliability'
    waiting = {'max_pending_scans': 2 * _MAX_AHEAD}
    more = {
        'odometry': {reliable.format(topic.name): 'reliable', **waiting},
        'localizer': {
            'run_dir': str(options.out),
            reliable.format(f'/{KISS_FRAME}'): 'reliable',
            **waiting,
        },
    }
    scans = 'scan' if topic.is_laser else 'points'
    for node in wired({'floorplan': str(options.floorplan), scans: topic.name}):
        parameters = node.parameters | more.get(node.executable, {})
        arguments = ros_arguments(parameters, node.remappings)
        if options.params_file is not None:
            arguments += ['--params-file', str(options.params_file)]
        group.start(node.executable, [*node_command(node.executable), *arguments])


def _replay_command(options: SessionOptions, topic: str) -> list[str]:
    # Scans only: the recording also holds the true poses, which no node may receive.
    parameters = {
        'bag': str(options.bag),
        'topics': [topic],
        'rate': options.rate,
        'wait_for_subscriber_s': _STALLED_S,
        'max_ahead': _MAX_AHEAD,
    }
    return [*node_command('replay'), *ros_arguments(parameters)]


def _wait_until(
    is_ready: Callable[[], bool], spin: Callable[[], None], group: ProcessGroup
) -> None:
    deadline = time.monotonic() + _READY_S
    while not is_ready():
        spin()
        group.check()
        if time.monotonic() > deadline:
            raise FpnetError(f'the nodes were not ready within {_READY_S:.0f} s; see their logs')


def _follow(
    monitor: Monitor, spin: Callable[[], None], group: ProcessGroup, replay: Child
) -> None:
    """Wait until the recording is played and odometry has processed it."""
    started_s = time.monotonic()
    while True:
        spin()
        group.check(may_end=[replay])
        quiet_s = min(monitor.quiet_s(), time.monotonic() - started_s)
        if monitor.is_complete() or (replay.process.poll() == 0 and quiet_s > _QUIET_S):
            return
        if quiet_s > _STALLED_S:
            raise FpnetError(f'no odometry for {quiet_s:.0f} s; see the logs of the nodes')


def _parse(arguments: Sequence[str] | None) -> SessionOptions:
    parser = argparse.ArgumentParser(prog='python -m fpnet_lab.nodes.session', description=__doc__)
    parser.add_argument('bag', type=Path)
    parser.add_argument('floorplan', type=Path)
    parser.add_argument('out', type=Path)
    parser.add_argument('--rate', type=float, default=1.0)
    parser.add_argument('--params-file', type=Path)
    return SessionOptions(**vars(parser.parse_args(arguments)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program; return 0, 1 on a known error, or 130 if interrupted."""
    options, interruption = _parse(arguments), Interruption()
    try:
        run_session(options, interruption)
    except FpnetError as error:
        print(f'fpnet: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == '__main__':
    sys.exit(main())
