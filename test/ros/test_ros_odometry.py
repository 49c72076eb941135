# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from types import SimpleNamespace

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from sensor_msgs.msg import Imu, PointCloud2

from fpnet_core.geometry import SE2
from fpnet_ros.odometry_outputs import OdometryOutputs
from fpnet_ros.robot_odometry import Patience
from fpnet_ros.runtime import STREAM, TF, TF_STATIC
from fpnet_ros.settings import OdometryParameters
from msg_adapters.clouds import cloud_from_msg, cloud_to_msg
from msg_adapters.odometry import odometry_from_msg, odometry_to_msg
from msg_adapters.stamps import header_to_msg, stamp_from_msg
from msg_adapters.transforms import transform_from_msg, transform_to_msg

pytestmark = pytest.mark.ros

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 100_000_000
BEHIND_NS = 60_000_000_000
SCANS = 25
SPEED_MPS = 0.8
# Walls, floor and ceiling of a room, the sensor starts at the origin.
ROOM = np.array([[-4.0, -3.0, -1.0], [8.0, 5.0, 2.0]])


def _sweep(rng: np.random.Generator, x: float) -> np.ndarray:
    """Return (6000, 3) returns in the sensor frame, the sensor at ``(x, 0, 0)``, level."""
    rays = rng.normal(size=(6000, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    walls = np.where(rays > 0.0, ROOM[1], ROOM[0]) - (x, 0.0, 0.0)
    ranges = (walls / rays).min(axis=1) + rng.normal(scale=0.01, size=len(rays))
    return rays * ranges[:, None]


def _moving_sweep(rng: np.random.Generator, x: float) -> tuple[np.ndarray, np.ndarray]:
    """Return returns (6000, 3) and their times [s], the sensor at ``(x, 0, 0)`` at the first."""
    time_s = np.sort(rng.uniform(0.0, PERIOD_NS / 1e9, 6000))
    time_s[[0, -1]] = 0.0, PERIOD_NS / 1e9
    rays = rng.normal(size=(6000, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    origins = np.outer(x + SPEED_MPS * time_s, (1.0, 0.0, 0.0))
    ranges = ((np.where(rays > 0.0, ROOM[1], ROOM[0]) - origins) / rays).min(axis=1)
    return rays * ranges[:, None], time_s


def _malformed() -> PointCloud2:
    msg = cloud_to_msg(np.ones((200, 3)), START_NS, 'lidar')
    msg.point_step = 8
    return msg


def test_clouds_become_odometry_and_frames_and_bad_ones_are_survived(bench):
    readings = bench.collect(Odometry, 'kiss/odometry', STREAM)
    frames = bench.collect(PointCloud2, 'kiss/frame', STREAM)
    node = bench.start(
        'odometry',
        {
            'lidar_odom_frame': 'odom_test',
            'qos_overrides./lidar/points.subscription.reliability': 'reliable',
        },
        {'pointcloud_topic': 'lidar/points'},
    )
    publisher = bench.node.create_publisher(PointCloud2, 'lidar/points', STREAM)
    assert bench.wait_for(lambda: publisher.get_subscription_count() > 0), node.log_tail()
    rng = np.random.default_rng(8)
    for index in range(SCANS):
        if index == SCANS // 2:
            publisher.publish(_malformed())
            publisher.publish(cloud_to_msg(np.zeros((0, 3)), START_NS, 'lidar'))
        stamp_ns = START_NS + index * PERIOD_NS
        points = _sweep(rng, index * SPEED_MPS * PERIOD_NS / 1e9)
        publisher.publish(cloud_to_msg(points, stamp_ns, 'lidar'))
        assert bench.wait_for(lambda n=index: len(readings) > n, 60.0), node.log_tail()
    assert bench.wait_for(lambda: len(readings) == len(frames) == SCANS), node.log_tail()
    assert node.process.poll() is None

    stamps = [START_NS + index * PERIOD_NS for index in range(SCANS)]
    assert [stamp_from_msg(msg.header.stamp) for msg in readings] == stamps
    assert [stamp_from_msg(msg.header.stamp) for msg in frames] == stamps
    last = odometry_from_msg(readings[-1])
    assert (last.parent, last.child) == ('odom_test', 'lidar')
    assert frames[-1].header.frame_id == 'lidar'
    travelled_m = (SCANS - 1) * SPEED_MPS * PERIOD_NS / 1e9
    np.testing.assert_allclose(last.T_parent_child[:3, 3], (travelled_m, 0.0, 0.0), atol=0.1)
    np.testing.assert_allclose(last.T_parent_child[:3, :3], np.eye(3), atol=0.02)
    assert len(cloud_from_msg(frames[-1]).points) > 5000
    log = node.log.read_text()
    assert log.count('point_step') == 1, log
    assert 'Traceback' not in log


def test_the_gyroscope_of_an_imu_is_believed_once_walls_agree(bench):
    """The IMU hangs upside down on a lidar whose turn rate changes from sweep to sweep."""
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')
    readings = bench.collect(Odometry, 'kiss/odometry', STREAM)
    reliable = {'qos_overrides./points.subscription.reliability': 'reliable'}
    node = bench.start(
        'odometry',
        {'use_imu': True, 'qos_overrides./imu/data.subscription.reliability': 'reliable'}
        | reliable,
        {'pointcloud_topic': '/points', 'imu': '/imu/data'},
    )
    publisher = bench.node.create_publisher(PointCloud2, '/points', STREAM)
    imu = bench.node.create_publisher(Imu, '/imu/data', STREAM)
    static = bench.node.create_publisher(tf2_msgs.TFMessage, '/tf_static', TF_STATIC)
    upside_down = transform_to_msg(np.diag([1.0, -1.0, -1.0, 1.0]), 0, 'lidar', 'imu')
    static.publish(tf2_msgs.TFMessage(transforms=[upside_down]))
    heard = lambda: publisher.get_subscription_count() and imu.get_subscription_count()  # noqa: E731
    assert bench.wait_for(lambda: bool(heard()), 120.0), node.log_tail()
    rng, yaw = np.random.default_rng(8), 0.0
    for index in range(40):
        step = rng.uniform(-0.2, 0.2)
        yaw += step
        for part in range(1, 11):
            msg = Imu()
            at_ns = START_NS + index * PERIOD_NS + (part - 10) * PERIOD_NS // 10
            msg.header = header_to_msg(at_ns, 'imu')
            msg.angular_velocity.z = -step / (PERIOD_NS / 1e9)
            imu.publish(msg)
        points = _sweep(rng, 0.0) @ SE2.from_xy_yaw(0.0, 0.0, yaw).as_matrix4()[:3, :3]
        publisher.publish(cloud_to_msg(points, START_NS + index * PERIOD_NS, 'lidar'))
        assert bench.wait_for(lambda n=index: len(readings) > n, 60.0), node.log_tail()
    assert 'the rotation of the gyroscope fits the scans' in node.log.read_text(), node.log_tail()
    T = odometry_from_msg(readings[-1]).T_parent_child
    first_yaw = np.arctan2(*odometry_from_msg(readings[0]).T_parent_child[[1, 0], 0])
    turned = np.arctan2(T[1, 0], T[0, 0]) - first_yaw
    expected = yaw - np.random.default_rng(8).uniform(-0.2, 0.2)
    assert np.angle(np.exp(1j * (turned - expected))) == pytest.approx(0.0, abs=0.03)


def test_with_a_base_frame_pose_and_tf_are_those_of_the_base(bench):
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')
    readings = bench.collect(Odometry, 'kiss/odometry', STREAM)
    transforms = bench.collect(tf2_msgs.TFMessage, '/tf', TF)
    diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
    node = bench.start(
        'odometry',
        {
            'base_frame': 'base_link',
            'lidar_odom_frame': 'odom',
            'position_covariance': 0.04,
            'qos_overrides./points.subscription.reliability': 'reliable',
        },
        {'pointcloud_topic': '/points'},
    )
    publisher = bench.node.create_publisher(PointCloud2, '/points', STREAM)
    static = bench.node.create_publisher(tf2_msgs.TFMessage, '/tf_static', TF_STATIC)
    assert bench.wait_for(lambda: publisher.get_subscription_count() > 0, 120.0), node.log_tail()
    rng = np.random.default_rng(8)
    publisher.publish(cloud_to_msg(_sweep(rng, 0.0), START_NS, 'lidar'))
    unknown = "the pose of 'lidar' in 'base_link' is unknown"
    assert bench.wait_for(lambda: unknown in node.log_tail(), 60.0), node.log_tail()
    # The lidar looks backwards: where it goes ahead, the base goes back.
    T_base_lidar = SE2.from_xy_yaw(0.2, 0.0, np.pi).as_matrix4(0.5)
    mounted = transform_to_msg(T_base_lidar, 0, 'base_link', 'lidar')
    broken = transform_to_msg(np.eye(4), 0, 'base_link', 'arm')
    broken.transform.translation.x = np.nan
    told = lambda: [s.message for msg in diagnostics for s in msg.status]  # noqa: E731
    assert bench.wait_for(lambda: any(unknown in text for text in told()), 60.0), told()
    assert not any('arrive faster than they can be registered' in text for text in told())
    assert bench.wait_for(lambda: static.get_subscription_count() > 0, 60.0)
    static.publish(tf2_msgs.TFMessage(transforms=[broken, mounted]))
    for index in range(1, 8):
        x = index * SPEED_MPS * PERIOD_NS / 1e9
        seen = len(readings)
        stamp_ns = START_NS + index * PERIOD_NS
        publisher.publish(cloud_to_msg(_sweep(rng, x), stamp_ns, 'lidar'))
        bench.wait_for(lambda n=seen: len(readings) > n, 20.0)
    assert bench.wait_for(lambda: len(transforms) == len(readings) > 4, 60.0), node.log_tail()
    last, tf = odometry_from_msg(readings[-1]), transform_from_msg(transforms[-1].transforms[0])
    assert (last.parent, last.child) == (tf.parent, tf.child) == ('odom', 'base_link')
    np.testing.assert_allclose(tf.T_parent_child, last.T_parent_child, atol=1e-9)
    moved_m = (len(readings) - 1) * SPEED_MPS * PERIOD_NS / 1e9
    np.testing.assert_allclose(last.T_parent_child[:3, 3], (-moved_m, 0.0, 0.0), atol=0.1)
    assert readings[-1].pose.covariance[0] == 0.04
    assert 'transform base_link -> arm is unusable' in node.log.read_text()


def test_pose_frame_and_velocity_are_those_of_the_sweep_s_end_though_it_is_stamped_at_its_start(
    bench,
):
    readings = bench.collect(Odometry, 'kiss/odometry', STREAM)
    frames = bench.collect(PointCloud2, 'kiss/frame', STREAM)
    node = bench.start('odometry', {'qos_overrides./points.subscription.reliability': 'reliable'},
                       {'pointcloud_topic': '/points'})  # fmt: skip
    publisher = bench.node.create_publisher(PointCloud2, '/points', STREAM)
    assert bench.wait_for(lambda: publisher.get_subscription_count() > 0, 120.0), node.log_tail()
    rng = np.random.default_rng(8)
    for index in range(12):
        points, time_s = _moving_sweep(rng, index * SPEED_MPS * PERIOD_NS / 1e9)
        start_ns = START_NS + index * PERIOD_NS
        absolute_s = start_ns / 1e9 + time_s
        publisher.publish(cloud_to_msg(points, start_ns, 'lidar', time_s=absolute_s))
        assert bench.wait_for(lambda n=index: len(frames) > n, 60.0), node.log_tail()
    ends = [START_NS + (index + 1) * PERIOD_NS for index in range(12)]
    for messages in (readings, frames):
        stamps = [stamp_from_msg(msg.header.stamp) for msg in messages]
        np.testing.assert_allclose(np.subtract(stamps, ends), 0, atol=1000)
    assert readings[0].twist.covariance[0] == -1.0
    speeds = [msg.twist.twist.linear.x for msg in readings[4:]]
    assert abs(np.mean(speeds) - SPEED_MPS) < 0.1
    assert 0.0 < readings[-1].twist.covariance[0] < 0.1
    assert 'set scans.stamp' not in node.log.read_text()


@pytest.mark.parametrize('own', ['odom', 'odom_lidar'])
def test_tf_is_withheld_from_a_robot_that_has_its_own_by_whatever_name(own):
    """Two that publish odom -> base_link move the robot to and fro in TF."""
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')
    sent, heard, told = [], [], []
    node = SimpleNamespace(
        add_publisher=lambda _, topic, __: SimpleNamespace(
            publish=lambda msg: sent.append((topic, msg))
        ),
        add_subscription=lambda _, __, take, ___: heard.append(take),
        get_logger=lambda: SimpleNamespace(warning=told.append),
    )
    outputs = OdometryOutputs(node, OdometryParameters(lidar_odom_frame=own))

    def publish(index):
        T_odom_sensor = SE2.from_xy_yaw(0.1 * index, 0.0, 0.0).as_matrix4()
        found = SimpleNamespace(
            T_odom_sensor=T_odom_sensor, points=np.ones((1, 3)), viewpoints=None
        )
        outputs.publish(found, START_NS + index * PERIOD_NS, 'lidar', 'base_link', np.eye(4))
        return [msg for topic, msg in sent if topic == '/tf']

    for index in range(3):  # ours come back to us
        heard[0](publish(index)[-1])
    assert len(publish(3)) == 4
    assert told == []
    wheels = transform_to_msg(np.eye(4), START_NS + 3 * PERIOD_NS, 'odom', 'base_link')
    heard[0](tf2_msgs.TFMessage(transforms=[wheels]))
    assert f'ours from {own} is withheld' in told[0]
    assert len(publish(4)) == 4
    assert len(told) == 1


def test_beside_the_robot_s_own_odometry_ours_keeps_out_of_tf_and_tells_when_that_breaks(bench):
    """The launch file leaves TF to the robot; here somebody forgot to."""
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')
    readings = bench.collect(Odometry, 'kiss/odometry', STREAM)
    transforms = bench.collect(tf2_msgs.TFMessage, '/tf', TF)
    diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
    reliable = {'qos_overrides./points.subscription.reliability': 'reliable'}
    node = bench.start(
        'odometry',
        {'base_frame': 'base_link', 'robot_odometry': 'tf', 'odom_frame': 'odom', **reliable},
        {'pointcloud_topic': '/points'},
    )
    publisher = bench.node.create_publisher(PointCloud2, '/points', STREAM)
    static = bench.node.create_publisher(tf2_msgs.TFMessage, '/tf_static', TF_STATIC)
    tf = bench.node.create_publisher(tf2_msgs.TFMessage, '/tf', TF)
    mounted = transform_to_msg(np.eye(4), 0, 'base_link', 'lidar')
    static.publish(tf2_msgs.TFMessage(transforms=[mounted]))
    heard = lambda: publisher.get_subscription_count() and static.get_subscription_count()  # noqa: E731
    assert bench.wait_for(lambda: bool(heard()), 120.0), node.log_tail()
    rng = np.random.default_rng(8)

    def step(index: int, robot_x: float) -> None:
        stamp_ns, x = START_NS + index * PERIOD_NS, index * SPEED_MPS * PERIOD_NS / 1e9
        T_odom_base = SE2.from_xy_yaw(3.0, robot_x, np.pi / 2).as_matrix4()
        wheels = transform_to_msg(T_odom_base, stamp_ns, 'odom', 'base_link')
        tf.publish(tf2_msgs.TFMessage(transforms=[wheels]))
        publisher.publish(cloud_to_msg(_sweep(rng, x), stamp_ns, 'lidar'))
        bench.wait_for(lambda: len(readings) > index, 20.0)

    for index in range(14):
        step(index, index * SPEED_MPS * PERIOD_NS / 1e9)
    assert 'ours from odom_lidar is withheld' in node.log.read_text(), node.log_tail()
    transforms.clear()
    for index in range(14, 34):
        step(index, 1.0)  # the wheels have stopped to report a motion
    parents = {t.header.frame_id for msg in transforms for t in msg.transforms}
    assert parents == {'odom'}
    last = odometry_from_msg(readings[-1])
    travelled_m = 33 * SPEED_MPS * PERIOD_NS / 1e9
    np.testing.assert_allclose(last.T_parent_child[:3, 3], (travelled_m, 0.0, 0.0), atol=0.12)
    log = node.log.read_text()
    assert log.count("the scans do not fit the robot's odometry") == 1, log
    said = lambda: {s.message for msg in diagnostics for s in msg.status}  # noqa: E731
    doubt = "the robot's odometry does not fit the scans"
    assert bench.wait_for(lambda: doubt in said()), said()


@pytest.mark.parametrize(('apart_s', 'wait_s'), [(0.02, 0.15), (0.1, 0.15), (0.2, 0.3)])
def test_odometry_that_is_rare_is_waited_for(apart_s, wait_s):
    patience = Patience(50.0)
    assert patience.wait_s > 0.5
    for index in range(12):
        patience.hear(60.0 + index * apart_s)
    assert patience.wait_s == pytest.approx(wait_s)
    patience.hear(patience.heard_s + 30.0)  # one that stopped and came back is no rare one
    assert patience.wait_s == pytest.approx(wait_s)


def test_the_robot_s_odometry_of_another_clock_is_told(bench):
    node = bench.start(
        'odometry',
        {'robot_odometry': 'topic', 'qos_overrides./points.subscription.reliability': 'reliable'},
        {'pointcloud_topic': '/points', 'odom': '/wheels'},
    )
    clouds = bench.node.create_publisher(PointCloud2, '/points', STREAM)
    wheels = bench.node.create_publisher(Odometry, '/wheels', STREAM)
    heard = lambda: clouds.get_subscription_count() and wheels.get_subscription_count()  # noqa: E731
    assert bench.wait_for(lambda: bool(heard()), 120.0), node.log_tail()
    rng, index = np.random.default_rng(9), 0

    def is_told() -> bool:
        nonlocal index
        index += 1
        x, stamp_ns = index * SPEED_MPS * PERIOD_NS / 1e9, START_NS + index * PERIOD_NS
        pose = SE2.from_xy_yaw(x, 0.0, 0.0).as_matrix4()
        wheels.publish(odometry_to_msg(pose, stamp_ns, 'odom', 'lidar'))
        clouds.publish(cloud_to_msg(_sweep(rng, x), stamp_ns + BEHIND_NS, 'lidar'))
        return 'KISS-ICP went on alone' in node.log.read_text()

    assert bench.wait_for(is_told, 60.0), node.log_tail()


def test_a_misspelt_parameter_ends_the_node_and_those_of_other_nodes_do_not(bench):
    other = bench.start_as(
        'other', 'odometry', {'submap.resolution_m': 0.1, 'tf_rate_hz': 20.0, 'rate': 2.0}
    )
    bad = bench.start_as('bad', 'odometry', {'odometry.voxel_sise': 0.3})
    assert bench.wait_for(lambda: bad.process.poll() is not None, 120.0)
    assert bad.process.poll() == 1
    log = bad.log.read_text()
    assert 'odometry.voxel_sise is unknown; did you mean odometry.voxel_size?' in log
    assert 'Traceback' not in log
    missing = 'no message on /pointcloud_topic for'
    assert bench.wait_for(lambda: missing in other.log.read_text(), 120.0), other.log_tail()
    assert other.process.poll() is None


def test_the_parameters_carry_their_documentation(bench):
    from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
    from rclpy.parameter import Parameter

    node = bench.start('odometry', {'odometry.voxel_size': 0.3})

    def call(kind, service, request):
        client = bench.node.create_client(kind, f'/odometry/{service}')
        assert bench.wait_for(client.service_is_ready), node.log_tail()
        # A response that is sent before DDS has found this client's reader is lost: ask again.
        for _ in range(6):
            future = client.call_async(request)
            if bench.wait_for(future.done, 5.0):
                return future.result()
        raise AssertionError(node.log_tail())

    names = ['odometry.voxel_size']
    (descriptor,) = call(
        DescribeParameters, 'describe_parameters', DescribeParameters.Request(names=names)
    ).descriptors
    assert 'voxel' in descriptor.description
    assert descriptor.floating_point_range[0].from_value > 0.0
    (value,) = call(GetParameters, 'get_parameters', GetParameters.Request(names=names)).values
    assert value.double_value == 0.3
    change = Parameter('odometry.voxel_size', value=0.5).to_parameter_msg()
    (result,) = call(
        SetParameters, 'set_parameters', SetParameters.Request(parameters=[change])
    ).results
    assert not result.successful
    assert 'read' in result.reason
