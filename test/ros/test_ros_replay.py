# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import time

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from fpnet.bag_writer import BagWriter
from fpnet_core.types import Status
from fpnet_ros.runtime import STATUS, STREAM, TF_STATIC, sensor_data
from msg_adapters.clouds import cloud_from_msg
from msg_adapters.diagnostics import LocalizerReport, report_to_msg
from msg_adapters.stamps import stamp_from_msg

pytestmark = pytest.mark.ros

START_NS = 1_700_000_000_250_000_000
PERIOD_NS = 100_000_000
COUNT = 30


def _clouds() -> np.ndarray:
    return np.random.default_rng(3).normal(size=(COUNT, 20_000, 3)).astype(np.float32)


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / 'bag'
    with BagWriter(path) as bag:
        for index, points in enumerate(_clouds()):
            stamp_ns = START_NS + index * PERIOD_NS
            bag.write_cloud('/points', stamp_ns, 'lidar', points)
            bag.write_pose('/truth', stamp_ns, 'building', np.eye(4))
    return path


def test_the_recording_arrives_complete_in_pace_and_alone(bench, recording):
    clouds = bench.collect(PointCloud2, 'points', sensor_data(COUNT))
    truth = bench.collect(PoseStamped, 'truth', STREAM)
    clock = bench.collect(Clock, 'clock', STREAM)
    replay = bench.start(
        'replay',
        {'bag': str(recording), 'topics': ['/points'], 'rate': 2.0, 'clock': True},
    )
    assert bench.wait_for(lambda: bool(clouds)), replay.log_tail()
    first_s = time.monotonic()
    assert bench.wait_for(lambda: len(clouds) == COUNT), (len(clouds), replay.log_tail())
    # 29 periods of 0.1 s at double speed; a busy machine is late, never early.
    assert 1.3 < time.monotonic() - first_s < 10.0
    for index, (msg, points) in enumerate(zip(clouds, _clouds(), strict=True)):
        assert stamp_from_msg(msg.header.stamp) == START_NS + index * PERIOD_NS
        np.testing.assert_array_equal(cloud_from_msg(msg).points, points)
    assert truth == []
    assert bench.wait_for(lambda: replay.process.poll() == 0), replay.log_tail()
    last_ns = START_NS + (COUNT - 1) * PERIOD_NS
    assert bench.wait_for(lambda: stamp_from_msg(clock[-1].clock) == last_ns)
    times = [stamp_from_msg(msg.clock) for msg in clock]
    assert times == sorted(times)
    assert times[0] >= START_NS
    assert len(times) > COUNT


def test_it_waits_for_a_localizer_that_has_its_floorplan(bench, recording):
    """Whoever subscribes first may be one of several, and the last still compiles."""
    clouds = bench.collect(PointCloud2, 'points', sensor_data(COUNT))
    says = bench.node.create_publisher(DiagnosticStatus, 'localizer/status', STATUS)
    replay = bench.start(
        'replay',
        {
            'bag': str(recording), 'topics': ['/points'], 'rate': 20.0,
            'wait_for_localizer': True, 'wait_for_subscriber_s': 60.0,
        },
    )  # fmt: skip
    assert bench.wait_for(lambda: says.get_subscription_count() > 0), replay.log_tail()
    says.publish(report_to_msg(LocalizerReport(Status.NO_PLAN, 0.0, 0), 'localizer'))
    assert not bench.wait_for(lambda: bool(clouds), 2.0)
    says.publish(report_to_msg(LocalizerReport(Status.WAITING, 0.0, 0), 'localizer'))
    assert bench.wait_for(lambda: len(clouds) == COUNT), (len(clouds), replay.log_tail())


def test_the_start_can_be_skipped(bench, recording):
    clouds = bench.collect(PointCloud2, 'points', sensor_data(COUNT))
    replay = bench.start('replay', {'bag': str(recording), 'rate': 10.0, 'start_offset_s': 2.0})
    assert bench.wait_for(lambda: replay.process.poll() == 0), replay.log_tail()
    bench.wait_for(lambda: len(clouds) >= 10, 20.0)
    assert stamp_from_msg(clouds[0].header.stamp) == START_NS + 20 * PERIOD_NS
    assert len(clouds) == 10


def test_who_comes_late_gets_what_was_latched(bench, tmp_path):
    """Places of sensors, for a tf2 buffer that is there only after they were played."""
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write_transform('/tf_static', START_NS, 'base', 'lidar', np.eye(4))
        for index, points in enumerate(_clouds()):
            bag.write_cloud('/points', START_NS + index * PERIOD_NS, 'lidar', points)
    clouds = bench.collect(PointCloud2, 'points', sensor_data(COUNT))
    parameters = {'bag': str(tmp_path / 'bag'), 'start_offset_s': 1.0}
    replay = bench.start('replay', parameters)
    assert bench.wait_for(lambda: bool(clouds)), replay.log_tail()
    static = bench.collect(TFMessage, '/tf_static', TF_STATIC)
    assert bench.wait_for(lambda: bool(static), 10.0), replay.log_tail()
    (transforms,) = static
    (transform,) = transforms.transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ('base', 'lidar')


def test_what_is_latched_comes_before_anybody_is_waited_for(bench, tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        for index, points in enumerate(_clouds()):
            bag.write_cloud('/points', START_NS + index * PERIOD_NS, 'lidar', points)
        bag.write_transform('/tf_static', START_NS + PERIOD_NS, 'base', 'lidar', np.eye(4))
    clouds = bench.collect(PointCloud2, 'points', sensor_data(COUNT))
    static = bench.collect(TFMessage, '/tf_static', TF_STATIC)
    parameters = {'bag': str(tmp_path / 'bag'), 'wait_for_localizer': True}
    replay = bench.start('replay', parameters | {'wait_for_subscriber_s': 600.0})
    assert bench.wait_for(lambda: bool(static)), replay.log_tail()
    assert not clouds  # no localizer has come


def test_a_loop_starts_again_and_takes_the_clock_back(bench, recording):
    clouds = bench.collect(PointCloud2, 'points', STREAM)
    clock = bench.collect(Clock, 'clock', STREAM)
    parameters = {'bag': str(recording), 'rate': 20.0, 'loop': True, 'clock': True}
    replay = bench.start('replay', parameters)
    assert bench.wait_for(lambda: len(clouds) > 2 * COUNT, 60.0), replay.log_tail()
    stamps = [stamp_from_msg(msg.header.stamp) for msg in clouds]
    assert stamps[COUNT:].count(START_NS) >= 1
    assert min(np.diff([stamp_from_msg(msg.clock) for msg in clock])) < -2.0 * 10**9
    assert replay.process.poll() is None


@pytest.mark.parametrize(
    ('plugin', 'mode'),
    [('SQLITE3', 'FILE'), ('SQLITE3', 'MESSAGE'), ('MCAP', 'NONE'), ('MCAP', 'MESSAGE')],
)
def test_recordings_of_every_kind_play(bench, tmp_path, plugin, mode):
    path = tmp_path / 'recording'
    store = get_typestore(Stores.ROS2_JAZZY)
    writer = Writer(path, version=9, storage_plugin=StoragePlugin[plugin])
    if mode != 'NONE':
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer as bag:
        topic = bag.add_connection('/ticks', 'std_msgs/msg/Header', typestore=store)
        for index in range(COUNT):
            time_msg = store.types['builtin_interfaces/msg/Time'](index, 0)
            message = store.types['std_msgs/msg/Header'](time_msg, 'map')
            data = store.serialize_cdr(message, 'std_msgs/msg/Header')
            bag.write(topic, START_NS + index * PERIOD_NS, data)
    headers = bench.collect(Header, 'ticks', STREAM)
    replay = bench.start('replay', {'bag': str(path), 'rate': 20.0})
    assert bench.wait_for(lambda: len(headers) == COUNT, 60.0), replay.log_tail()
    assert [msg.stamp.sec for msg in headers] == list(range(COUNT))


def test_bad_input_ends_the_node_with_one_line(bench, recording, tmp_path):
    cases = {
        'missing': ({'bag': str(tmp_path / 'absent')}, 'does not exist'),
        'topic': ({'bag': str(recording), 'topics': ['/lidar']}, 'lacks /lidar'),
    }
    started = {
        name: bench.start_as(name, 'replay', parameters) for name, (parameters, _) in cases.items()
    }
    for name, (_, message) in cases.items():
        assert started[name].process.wait(timeout=180) == 1
        lines = started[name].log_tail().splitlines()
        assert len(lines) == 1
        assert message in lines[0]
