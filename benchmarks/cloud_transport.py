# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Number of large clouds that arrive in another process, with and without the Fast DDS profile.

Run: python benchmarks/cloud_transport.py [--points 300000] [--clouds 50] [--json OUT]; then
fpnet bench figures cloud_transport=OUT

Clouds have x, y, z, intensity, ring and time like those of a driver, and are sent at 10 Hz.
Prints a table.
"""

from __future__ import annotations

import argparse
from itertools import product
import os
from pathlib import Path
import subprocess
import sys
import time
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import PointCloud2

from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.nodes.processes import free_domain_id, private_environment, share_file
from fpnet_ros.runtime import STREAM, sensor_data
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.stamps import stamp_from_msg, stamp_to_msg

PERIOD_S, QUIET_S, START_S = 0.1, 3.0, 60.0
PROFILE = 'FASTRTPS_DEFAULT_PROFILES_FILE'
RECEIVERS = ('best effort', 'reliable')
CASES = tuple(product(('defaults', 'fastdds_shm.xml'), RECEIVERS))


def receive(is_reliable: bool) -> None:
    """Count clouds until none arrives; print the count and the median latency [ms]."""
    rclpy.init()
    node = rclpy.create_node('receiver')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    latencies_ms: list[float] = []

    def note(msg: PointCloud2) -> None:
        latencies_ms.append((time.time_ns() - stamp_from_msg(msg.header.stamp)) / 1e6)

    node.create_subscription(
        PointCloud2, 'cloud', note, STREAM if is_reliable else sensor_data(10)
    )
    heard_s, deadline_s = 0, time.monotonic() + START_S
    while time.monotonic() < deadline_s:
        executor.spin_once(timeout_sec=0.5)
        if len(latencies_ms) > heard_s:
            heard_s, deadline_s = len(latencies_ms), time.monotonic() + QUIET_S
    print(len(latencies_ms), np.median(latencies_ms or [np.nan]))


def send(points: int, clouds: int) -> None:
    """Publish clouds at 10 Hz once there is a subscription."""
    rclpy.init()
    node = rclpy.create_node('sender')
    publisher = node.create_publisher(PointCloud2, 'cloud', STREAM)
    rng = np.random.default_rng(0)
    columns = np.arange(points)
    msg = cloud_to_msg(
        rng.normal(size=(points, 3)).astype(np.float32),
        0,
        'lidar',
        columns,
        columns % 128,
        columns,
    )
    while not publisher.get_subscription_count():
        time.sleep(0.05)
    time.sleep(1.0)  # discovery is mutual
    started_s = time.monotonic()
    for index in range(clouds):
        time.sleep(max(0.0, started_s + index * PERIOD_S - time.monotonic()))
        msg.header.stamp = stamp_to_msg(time.time_ns())
        publisher.publish(msg)
    time.sleep(QUIET_S)


def case(points: int, clouds: int, profile: str, receiver: str) -> dict[str, Any]:
    """Return the number and latency of clouds received in one set-up."""
    environment = private_environment(free_domain_id())
    environment.pop(PROFILE, None)
    if profile != 'defaults':
        environment[PROFILE] = str(share_file('config/fastdds_shm.xml'))
    program = [sys.executable, str(Path(__file__))]
    sizes = ['--points', str(points), '--clouds', str(clouds)]
    with subprocess.Popen(  # noqa: S603 - this very file
        [*program, '--receive', receiver], env=environment, stdout=subprocess.PIPE, text=True
    ) as listening:
        subprocess.run([*program, '--send', *sizes], env=environment, check=True)  # noqa: S603
        arrived, latency_ms = listening.communicate()[0].split()
    found = {'arrived': int(arrived), 'latency_ms': float(latency_ms)}
    return {'profile': profile, 'subscription': receiver, **found}


def main() -> None:
    """Print how many clouds arrive in each set-up."""
    parser = script_parser(__doc__)
    parser.add_argument('--points', type=int, default=300_000)
    parser.add_argument('--clouds', type=int, default=50)
    parser.add_argument('--send', action='store_true', help=argparse.SUPPRESS)
    parser.add_argument('--receive', choices=RECEIVERS, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.send:
        send(arguments.points, arguments.clouds)
    elif arguments.receive:
        receive(arguments.receive == 'reliable')
    else:
        os.environ.pop(PROFILE, None)
        sizes = {'points': arguments.points, 'clouds': arguments.clouds}
        cases = [case(**sizes, profile=profile, receiver=each) for profile, each in CASES]
        finish('cloud_transport', arguments.json, sizes | {'cases': cases})


if __name__ == '__main__':
    main()
