# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bags in both storages: round trips, topic choice, poses in between, and damage."""

import logging

import numpy as np
import pytest
from rosbags import rosbag1
from rosbags.convert import convert
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from fpnet.api.run import scans_of
from fpnet.bag_writer import BagWriter
from fpnet.recordings.opening import open_scans
from fpnet_core.errors import BagFormatError, CloudFormatError, OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.geometry.rigid3d import quaternion_from_rigid, rigid_from_quaternion
from fpnet_core.io.bags import BagReader
from fpnet_core.types import GridMap

STORAGES = ('sqlite3', 'mcap')
POINTS = np.random.default_rng(1).normal(0.0, 5.0, (50, 3)).astype(np.float32)
SECOND_NS = 1_000_000_000
START_NS = 1_700_000_000 * SECOND_NS


def pose(x, yaw, y=2.0):
    return rigid_from_quaternion([x, y, 0.5], [0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])


def record(path, storage='sqlite3', clouds=('/points',), odometry=('/odom',), child='lidar'):
    """Three clouds, a second apart; odometry at twice that rate, turning 0.2 rad per second."""
    with BagWriter(path, storage) as bag:
        for k in range(-1, 5):
            for topic in odometry:
                stamp = START_NS + k * SECOND_NS // 2
                bag.write_odometry(topic, stamp, 'odom', child, pose(0.5 * k, 0.1 * k))
            if k % 2 == 0:
                for topic in clouds:
                    time = np.linspace(-0.1, 0.0, 50)
                    stamp = START_NS + k * SECOND_NS // 2
                    bag.write_cloud(topic, stamp, 'lidar', POINTS + k, np.ones(50), None, time)
                bag.write_pose('/ground_truth', stamp, 'map', pose(100.0 + k, 1.0))
    return path


@pytest.mark.parametrize('storage', STORAGES)
def test_scans_round_trip(tmp_path, storage):
    source = open_scans(record(tmp_path / 'bag', storage), truth_topic='/ground_truth')
    scans = list(source)
    assert (source.kind, len(source), len(scans), source.has_poses) == ('bag', 3, 3, True)
    moved = np.linalg.norm(scans[1].points - (POINTS + np.float32(2)), axis=1)
    assert moved[-1] < 1e-6 < moved[0]  # the motion during the sweep is undone, up to its end
    assert scans[1].time_s is None
    np.testing.assert_allclose(scans[1].T_odom_sensor, pose(1.0, 0.2), atol=1e-12)
    np.testing.assert_allclose(scans[1].T_truth_sensor, pose(102.0, 1.0), atol=1e-12)
    assert scans[1].stamp_ns == START_NS + SECOND_NS
    assert [scan.stamp_ns for scan in source] == [scan.stamp_ns for scan in scans]


@pytest.mark.parametrize('storage', STORAGES)
def test_grid_round_trip_is_row_major_with_a_turned_origin(tmp_path, storage):
    cells = np.array([[0, 100, -1], [-1, 0, 0]], np.int8)
    with BagWriter(tmp_path / 'bag', storage) as bag:
        bag.write_grid('/map', 7, GridMap(cells, 0.05, SE2.from_xy_yaw(1.0, 2.0, 0.6), 'plan'))
    with BagReader(tmp_path / 'bag') as bag:
        [(_, stamp_ns, message)] = bag.messages(['/map'])
    assert (stamp_ns, message.header.frame_id) == (7, 'plan')
    assert (message.info.height, message.info.width) == (2, 3)
    assert message.data.tolist() == [0, 100, -1, -1, 0, 0]
    assert message.info.origin.orientation.z == pytest.approx(np.sin(0.3))


class SteadyRecorder(BagWriter):
    """Its own clock goes on whatever messages are stamped."""

    now_ns = START_NS

    def _write(self, topic, msgtype, stamp_ns, message, *rest):
        super()._write(topic, msgtype, self.now_ns, message, *rest)


@pytest.mark.parametrize('is_odometry_set', [False, True])
def test_a_clock_that_goes_back_is_the_lidars_alone_or_the_robots(
    tmp_path, caplog, is_odometry_set
):
    """Where odometry goes on, scans from the past would be put where the robot was then."""
    with SteadyRecorder(tmp_path / 'bag') as bag:
        for k in range(40):
            back_ns = 2 * SECOND_NS if k >= 30 else 0
            stamp_ns = bag.now_ns = START_NS + k * SECOND_NS // 10
            odometry_ns = stamp_ns - back_ns * is_odometry_set
            bag.write_odometry('/odom', odometry_ns, 'odom', 'lidar', pose(0.1 * k, 0.0))
            bag.write_cloud('/points', stamp_ns - back_ns, 'lidar', POINTS)
    with caplog.at_level(logging.WARNING):
        scans = list(open_scans(tmp_path / 'bag'))
    assert len(scans) == (40 if is_odometry_set else 30)
    said = [record.message for record in caplog.records if 'stamped before' in record.message]
    assert len(said) == (0 if is_odometry_set else 1)
    if said:
        assert '10 of 40 scans' in said[0]


def test_storage_file_without_its_folder(tmp_path):
    bag = record(tmp_path / 'bag', 'mcap')
    assert len(list(open_scans(next(bag.glob('*.mcap'))))) == 3
    (bag / 'metadata.yaml').unlink()
    assert len(list(open_scans(bag))) == 3


def test_raw_clouds_need_an_odometry(tmp_path):
    source = open_scans(record(tmp_path / 'bag', odometry=()))
    assert not source.has_poses
    assert all(scan.T_odom_sensor is None for scan in source)


def test_truth_is_never_taken_for_odometry(tmp_path):
    bag = record(tmp_path / 'bag', odometry=('/truth/odometry', '/robot/gt'))
    source = open_scans(bag)
    assert not source.has_poses
    assert next(iter(source)).T_truth_sensor is None


def test_debug_clouds_of_kiss_are_passed_over(tmp_path):
    clouds = ('/kiss/frame', '/kiss/local_map', '/velodyne_points')
    odometry = ('/wheels', '/kiss/odometry')
    source = open_scans(record(tmp_path / 'bag', clouds=clouds, odometry=odometry))
    assert (source.cloud_topic, source.odometry_topic) == ('/velodyne_points', '/kiss/odometry')
    source = open_scans(record(tmp_path / 'bag2', clouds=clouds[:2]))
    assert source.cloud_topic == '/kiss/frame'


@pytest.mark.parametrize(
    ('topics', 'options', 'message'),
    [
        ({'clouds': ()}, {}, 'no PointCloud2 or LaserScan topic; it has /ground_truth, /odom'),
        ({'clouds': ('/a', '/b')}, {}, 'several PointCloud2 or LaserScan topics: /a, /b'),
        ({'odometry': ('/a', '/b')}, {}, 'several Odometry topics: /a, /b'),
        ({}, {'topics': ['/kiss/odometry']}, '/kiss/odometry is missing'),
        ({'odometry': ('/a', '/b')}, {'topics': ['/a', '/b']}, 'name one odometry topic'),
        ({}, {'topics': ['/odom'], 'odometry_topic': ''}, 'cannot use /odom'),
        ({}, {'odometry_topic': '/none'}, '/none is missing'),
        ({}, {'truth_topic': '/points'}, '/points is sensor_msgs'),
    ],
)
def test_topics_that_do_not_serve_are_named(tmp_path, topics, options, message):
    bag = record(tmp_path / 'bag', **topics)
    with pytest.raises(BagFormatError, match=message):
        open_scans(bag, **options)


def test_topics_can_be_chosen(tmp_path):
    bag = record(tmp_path / 'bag', clouds=('/a', '/b'), odometry=('/c', '/d'))
    source = open_scans(bag, topics=['/b'], odometry_topic='/c')
    assert (source.cloud_topic, source.odometry_topic) == ('/b', '/c')
    source = open_scans(bag, topics=['/b', '/d'])
    assert (source.cloud_topic, source.odometry_topic) == ('/b', '/d')


def test_sensor_mounting_comes_from_static_transforms(tmp_path):
    """The lidar hangs on a mast, turned by 0.5 rad; odometry is that of base."""
    T_base_mast, T_mast_lidar = pose(0.2, 0.5, 0.0), pose(-0.1, -0.2, 0.3)
    types = get_typestore(Stores.ROS2_JAZZY)
    msg = types.types
    bag = record(tmp_path / 'bag', child='base')
    with Writer(tmp_path / 'with_tf', version=9) as writer, BagReader(bag) as reader:
        tf = writer.add_connection('/tf_static', 'tf2_msgs/msg/TFMessage', typestore=types)
        stamp = msg['builtin_interfaces/msg/Time'](0, 0)
        transforms = [
            msg['geometry_msgs/msg/TransformStamped'](
                msg['std_msgs/msg/Header'](stamp, parent),
                child,
                msg['geometry_msgs/msg/Transform'](
                    msg['geometry_msgs/msg/Vector3'](*T[:3, 3]),
                    msg['geometry_msgs/msg/Quaternion'](*quaternion_from_rigid(T)),
                ),
            )
            for parent, child, T in (
                ('base', 'mast', T_base_mast),
                ('mast', 'lidar', T_mast_lidar),
            )
        ]
        message = msg['tf2_msgs/msg/TFMessage'](transforms)
        writer.write(tf, 0, types.serialize_cdr(message, 'tf2_msgs/msg/TFMessage'))
        connections = {}
        for topic, msgtype, at_ns, data in reader.raw_messages():
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=types)
            writer.write(connections[topic], at_ns, data)
    scan = list(open_scans(tmp_path / 'with_tf'))[1]
    np.testing.assert_allclose(
        scan.T_odom_sensor, pose(1.0, 0.2) @ T_base_mast @ T_mast_lidar, atol=1e-9
    )


@pytest.mark.parametrize(
    ('child', 'reason'),
    [
        ('base', r"the pose of 'lidar' in 'base' is unknown: no transform on /tf_static connects"),
        ('', r"the pose of 'lidar' is unknown: the odometry has no child_frame_id"),
    ],
)
def test_an_unknown_mounting_is_never_taken_to_coincide(tmp_path, child, reason):
    bag = record(tmp_path / 'bag', child=child)
    with pytest.raises(OdometryError, match=reason + '.*--odometry kiss'):
        next(iter(scans_of(bag)))
    # Without the bag's odometry nobody asks.
    assert next(iter(scans_of(bag, odometry='kiss'))).T_odom_sensor is None


def test_odometry_that_is_in_tf_only_is_that_of_what_the_sensor_is_fixed_to(tmp_path):
    T_base_lidar = pose(0.2, 0.5, 0.0)
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write_transform('/tf_static', START_NS, 'base', 'lidar', T_base_lidar)
        for k in range(5):
            stamp_ns = START_NS + k * SECOND_NS // 4
            bag.write_transform('/tf', stamp_ns, 'map', 'odom', pose(50.0, 2.0))
            bag.write_transform('/tf', stamp_ns, '/odom', '/base', pose(0.5 * k, 0.1 * k))
            bag.write_cloud('/points', stamp_ns, 'lidar', POINTS)
    assert not scans_of(tmp_path / 'bag').has_poses  # unless somebody asks
    scans = list(scans_of(tmp_path / 'bag', odometry='robot'))
    assert len(scans) == 5
    np.testing.assert_allclose(scans[2].T_odom_sensor, pose(1.0, 0.2) @ T_base_lidar, atol=1e-9)
    with pytest.raises(OdometryError, match='has no odometry'):
        scans_of(record(tmp_path / 'without', odometry=()), odometry='both')


def test_clouds_outside_the_odometry_are_left_out(tmp_path, caplog):
    with BagWriter(tmp_path / 'bag') as bag:
        for k in range(4):
            bag.write_cloud('/points', (k + 1) * SECOND_NS, 'lidar', POINTS)
        bag.write_odometry('/odom', 2 * SECOND_NS, 'odom', 'lidar', pose(1.0, 0.0))
    with caplog.at_level(logging.WARNING):
        scans = list(open_scans(tmp_path / 'bag'))
    assert [scan.stamp_ns for scan in scans] == [2 * SECOND_NS]
    assert '3 of 4 scans' in caplog.text


def test_writer_refuses_what_it_cannot_write(tmp_path):
    record(tmp_path / 'bag')
    with pytest.raises(BagFormatError, match='exists'):
        BagWriter(tmp_path / 'bag')
    with pytest.raises(BagFormatError, match='unknown'):
        BagWriter(tmp_path / 'new', 'tape')
    with BagWriter(tmp_path / 'new') as bag:
        bag.write_pose('/a', 1, 'map', np.eye(4))
        with pytest.raises(BagFormatError, match='carries geometry_msgs'):
            bag.write_cloud('/a', 2, 'lidar', POINTS)
        with pytest.raises(BagFormatError, match='not a rigid'):
            bag.write_pose('/a', 3, 'map', 2.0 * np.eye(4))


def test_missing_bags(tmp_path):
    with pytest.raises(BagFormatError, match='does not exist'):
        BagReader(tmp_path / 'none')
    with pytest.raises(CloudFormatError, match='does not exist'):
        open_scans(tmp_path / 'none')
    (tmp_path / 'empty.mcap').write_bytes(b'')
    (tmp_path / 'empty.db3').write_bytes(b'')
    for name in ('empty.mcap', 'empty.db3'):
        with pytest.raises(BagFormatError, match=name):
            open_scans(tmp_path / name)


def test_what_is_no_bag_is_not_said_to_be_a_broken_one(tmp_path):
    (tmp_path / 'drive.log').write_bytes(b'FLASER 0 0 0 0')
    with pytest.raises(BagFormatError, match=r'is not a bag: expected a folder or a file'):
        BagReader(tmp_path / 'drive.log')


def as_of_ros_1(bag):
    """Return the same messages in a bag of ROS 1."""
    path = bag.with_suffix('.bag')
    types, nothing = get_typestore(Stores.ROS1_NOETIC), ((),) * 4
    convert([bag], path, 'sqlite3', 9, None, 'file', None, types, *nothing)
    return path


def test_a_bag_of_ros_1_says_the_same(tmp_path):
    bag = record(tmp_path / 'drive')
    old = as_of_ros_1(bag)
    scans, same = (list(open_scans(each, truth_topic='/ground_truth')) for each in (bag, old))
    for scan, other in zip(scans, same, strict=True):
        assert scan.stamp_ns == other.stamp_ns
        np.testing.assert_array_equal(scan.points, other.points)
        np.testing.assert_array_equal(scan.T_odom_sensor, other.T_odom_sensor)
        np.testing.assert_array_equal(scan.T_truth_sensor, other.T_truth_sensor)
    with BagReader(bag) as reader, BagReader(old) as ros_1:
        assert ros_1.topics == reader.topics
        assert sorted(ros_1.raw_messages()) == sorted(reader.raw_messages())


@pytest.mark.parametrize(('latching', 'expected'), [(None, False), (0, False), (1, True)])
def test_what_a_bag_of_ros_1_latched_is_told(tmp_path, latching, expected):
    types = get_typestore(Stores.ROS1_NOETIC)
    with rosbag1.Writer(tmp_path / 'a.bag') as writer:
        kind = 'std_msgs/msg/String'
        to = writer.add_connection('/map_name', kind, typestore=types, latching=latching)
        writer.write(to, START_NS, types.serialize_ros1(types.types[kind]('hall'), kind))
    with BagReader(tmp_path / 'a.bag') as reader:
        assert reader.is_latched('/map_name') is expected


def test_what_never_moves_on_the_tf_of_ros_1_is_fixed(tmp_path):
    """Robots that are older than tf2 have no /tf_static."""
    old = as_of_ros_1(record(tmp_path / 'drive', child='base'))
    with pytest.raises(OdometryError, match=r"'lidar' in 'base' is unknown"):
        list(open_scans(old))
    types = get_typestore(Stores.ROS1_NOETIC)
    msg = types.types
    T_base_lidar = pose(0.2, 0.5, 0.0)
    with rosbag1.Writer(tmp_path / 'with_tf.bag') as writer, rosbag1.Reader(old) as reader:
        for each in reader.connections:
            to = writer.add_connection(each.topic, each.msgtype, typestore=types)
            for _, at_ns, data in reader.messages([each]):
                writer.write(to, at_ns, data)
        kind = 'tf/msg/tfMessage'
        text = 'geometry_msgs/TransformStamped[] transforms'
        types.register(get_types_from_msg(text, kind))
        tf = writer.add_connection('/tf', kind, typestore=types)
        for k in range(4):
            stamp = msg['builtin_interfaces/msg/Time'](START_NS // SECOND_NS + k, 0)
            sent = [
                msg['geometry_msgs/msg/TransformStamped'](
                    msg['std_msgs/msg/Header'](0, stamp, parent),
                    child,
                    msg['geometry_msgs/msg/Transform'](
                        msg['geometry_msgs/msg/Vector3'](*T[:3, 3]),
                        msg['geometry_msgs/msg/Quaternion'](*quaternion_from_rigid(T)),
                    ),
                )
                for parent, child, T in (
                    ('/odom', '/base', pose(0.5 * k, 0.1 * k)),
                    ('/base', '/lidar', T_base_lidar),
                )
            ]
            message = msg[kind](sent)
            writer.write(tf, START_NS + k, types.serialize_ros1(message, kind))
    scan = list(open_scans(tmp_path / 'with_tf.bag'))[1]
    np.testing.assert_allclose(scan.T_odom_sensor, pose(1.0, 0.2) @ T_base_lidar, atol=1e-9)


def test_a_damaged_bag_of_ros_1_is_named_with_what_repairs_it(tmp_path):
    (tmp_path / 'drive.bag').write_bytes(b'#ROSBAG V2.0\n')
    with pytest.raises(BagFormatError, match=r'drive\.bag.*repair it \(rosbag reindex\)'):
        open_scans(tmp_path / 'drive.bag')


def test_zero_quaternion_in_odometry_is_named(tmp_path):
    bag = record(tmp_path / 'bag', 'mcap')
    file = next(bag.glob('*.mcap'))
    data = file.read_bytes()
    second = quaternion_from_rigid(pose(0.5, 0.1)).tobytes()
    assert second in data
    file.write_bytes(data.replace(second, bytes(32)))
    with pytest.raises(BagFormatError, match='zero'):
        open_scans(bag)


def test_metadata_that_unfolds_to_gigabytes_is_refused(tmp_path):
    path = record(tmp_path / 'bag')
    bomb = ['a0: &a0 [x, x]'] + [
        f'a{k}: &a{k} [{", ".join([f"*a{k - 1}"] * 9)}]' for k in range(1, 30)
    ]
    (path / 'metadata.yaml').write_text('\n'.join(bomb))
    with pytest.raises(BagFormatError, match=r'alias \*a0'):
        open_scans(path)
