# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet doctor`` beside running publishers: each fault is found over DDS."""

import json
import subprocess
import sys
import time

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2

from fpnet_ros.runtime import LATCHED, STREAM, TF, TF_STATIC
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.odometry import odometry_to_msg

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = pytest.mark.ros

COMMAND = [sys.executable, '-c', 'from fpnet.cli import main; main()', 'doctor']
SECONDS = 2.0


class _Robot:
    """A robot that stands in a room; what is wrong with it is said by arguments."""

    def __init__(self, bench, scans='/lidar/points', parents=('odom',), behind_s=0.0, told_m=0.9):
        self._bench, self._parents, self._behind_s = bench, parents, behind_s
        node = bench.node
        self._clouds = node.create_publisher(PointCloud2, scans, qos_profile_sensor_data)
        self._odometry = node.create_publisher(Odometry, '/odom', STREAM)
        self._tf = node.create_publisher(tf2_msgs.TFMessage, '/tf', TF)
        static = node.create_publisher(tf2_msgs.TFMessage, '/tf_static', TF_STATIC)
        static.publish(tf2_msgs.TFMessage(transforms=[_transform('base_link', 'lidar', told_m)]))
        self._static = static
        node.create_timer(0.1, self._publish)
        rays = np.random.default_rng(4).normal(size=(4000, 3))
        walls = np.where(rays > 0.0, (3.5, 2.0, 1.8), (-2.5, -3.0, -0.9))
        self._points = rays * (walls / rays).min(axis=1)[:, None]

    def _publish(self) -> None:
        now_ns = time.time_ns()
        scan_ns = now_ns - round(self._behind_s * 1e9)
        times = np.linspace(0.0, 0.1, len(self._points))
        self._clouds.publish(cloud_to_msg(self._points, scan_ns, 'lidar', time_s=times))
        self._odometry.publish(odometry_to_msg(np.eye(4), now_ns, 'odom', 'base_link'))
        transforms = [_transform(parent, 'base_link') for parent in self._parents]
        for each in transforms:
            each.header.stamp = self._bench.node.get_clock().now().to_msg()
        self._tf.publish(tf2_msgs.TFMessage(transforms=transforms))


def _transform(parent: str, child: str, height_m: float = 0.0) -> TransformStamped:
    msg = TransformStamped(child_frame_id=child)
    msg.header.frame_id = parent
    msg.transform.translation.z = height_m
    msg.transform.rotation.w = 1.0
    return msg


def asked(bench, tmp_path, *arguments) -> tuple[int, list[dict]]:
    """Run the command beside the bench; return its status and findings."""
    path = tmp_path / 'doctor.json'
    command = [*COMMAND, '--seconds', str(SECONDS), '--json', str(path), *arguments]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    assert bench.wait_for(lambda: process.poll() is not None, 60.0)
    return process.returncode, json.loads(path.read_text())['findings']


def test_a_robot_that_is_wired_well_is_healthy(bench, tmp_path):
    _Robot(bench)
    assert asked(bench, tmp_path) == (0, [])


def test_every_fault_of_a_robot_is_found_at_once(bench, tmp_path):
    robot = _Robot(bench, parents=('odom', 'odom_lidar'), behind_s=500.0, told_m=1.6)
    grids = bench.node.create_publisher(OccupancyGrid, '/map', STREAM)
    bench.node.create_subscription(OccupancyGrid, '/map', print, LATCHED)
    status, findings = asked(bench, tmp_path)
    assert status == 1
    assert {(found['problem'], found['where']) for found in findings} == {
        ('QoS does not match', '/map'),
        ('frame with two parents', 'base_link'),
        ('stamps from another clock', '/lidar/points'),
        ('stamps from another clock', '/odom'),
        ('stamps from another clock', '/tf'),
        ('sensor at the wrong height', 'lidar'),
    }
    assert 'but test_bench requests transient local' in findings[0]['evidence']
    assert robot
    assert grids


def test_a_topic_that_a_node_asks_for_and_nobody_publishes_is_named(bench, tmp_path):
    _Robot(bench)
    bench.node.create_subscription(PointCloud2, '/points', print, qos_profile_sensor_data)
    status, findings = asked(bench, tmp_path)
    assert status == 1
    (finding,) = findings
    assert (finding['problem'], finding['where']) == ('topic missing', '/points')
    assert finding['next'].startswith('points:=/lidar/points')


def test_best_effort_scans_for_a_reliable_subscriber_are_found(bench, tmp_path):
    _Robot(bench)
    bench.node.create_subscription(PointCloud2, '/lidar/points', print, STREAM)
    status, (finding,) = asked(bench, tmp_path)
    assert status == 1
    assert 'published best effort by test_bench' in finding['evidence']
    assert 'qos_overrides./lidar/points.subscription' in finding['next']
