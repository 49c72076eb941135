# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""LaserScans over DDS: of one scanner to a pose on the floorplan, of two to one odometry."""

from array import array
from types import SimpleNamespace

from geometry_msgs.msg import PoseStamped
from laser_robot import (
    FRONT,
    PERIOD_NS,
    REAR,
    START_NS,
    base_at,
    distance_to_walls,
    place,
)
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from sensor_msgs.msg import LaserEcho, LaserScan, MultiEchoLaserScan, PointCloud2
from short_recording import start_of_recording

from fpnet.accuracy import pose_errors
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.sim.drives.recording import (
    LASER_TOPIC,
    ODOMETRY_TOPIC,
    write_recording,
)
from fpnet_lab.sim.lidars.sensors import SENSORS
from fpnet_ros.inputs import ScanInput
from fpnet_ros.logs import NodeLog
from fpnet_ros.runtime import STREAM, TF_STATIC
from fpnet_ros.settings import InputParameters
from msg_adapters.clouds import cloud_from_msg
from msg_adapters.odometry import odometry_from_msg, odometry_to_msg
from msg_adapters.poses import pose_from_msg
from msg_adapters.stamps import header_to_msg, stamp_from_msg
from msg_adapters.transforms import transform_to_msg

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = pytest.mark.ros

SWEEPS, WAITING = 20, 3
DRIVE_S = 20.0
ENOUGH_POSES = 40


def _message(kind, stamp_ns, frame, readings):
    ranges = readings.ranges.tolist()
    if kind is MultiEchoLaserScan:
        ranges = [LaserEcho(echoes=array('f', [distance, distance + 1.0])) for distance in ranges]
    else:
        ranges = array('f', ranges)
    return kind(
        header=header_to_msg(stamp_ns, frame),
        angle_min=readings.angle_min,
        angle_increment=readings.angle_increment,
        time_increment=readings.time_increment,
        range_min=readings.range_min,
        range_max=readings.range_max,
        ranges=ranges,
    )


class _Robot:
    """Publishes what two scanners see, and where they are on the robot."""

    def __init__(self, bench) -> None:
        self._bench = bench
        self._rng = np.random.default_rng(6)
        create = bench.node.create_publisher
        self._scans = {
            FRONT: create(LaserScan, 'front/scan', STREAM),
            REAR: create(MultiEchoLaserScan, 'rear/echoes', STREAM),
        }
        self._static = create(tf2_msgs.TFMessage, '/tf_static', TF_STATIC)

    def is_heard(self) -> bool:
        return all(
            publisher.get_subscription_count()
            for publisher in (*self._scans.values(), self._static)
        )

    def tell_places(self, places) -> None:
        transforms = [transform_to_msg(T, 0, 'base_link', frame) for frame, T in places.items()]
        self._static.publish(tf2_msgs.TFMessage(transforms=transforms))

    def send(self, index: int) -> None:
        for scanner, publisher in self._scans.items():
            stamp_ns, readings = scanner.readings(index, self._rng)
            publisher.publish(_message(publisher.msg_type, stamp_ns, scanner.frame, readings))


def test_front_and_rear_scanners_make_one_odometry_of_the_base(bench):
    readings = bench.collect(Odometry, 'kiss/odometry', STREAM)
    frames = bench.collect(PointCloud2, 'kiss/frame', STREAM)
    reliable = 'qos_overrides./{}.subscription.reliability'
    node = bench.start(
        'odometry',
        {
            'scan_topics': ['front/scan'],
            'multi_echo_topics': ['rear/echoes'],
            'base_frame': 'base_link',
            'max_pending_scans': WAITING,
            reliable.format('front/scan'): 'reliable',
            reliable.format('rear/echoes'): 'reliable',
        },
    )
    robot = _Robot(bench)
    assert bench.wait_for(robot.is_heard, 120.0), node.log_tail()
    unknown = "_laser' in 'base_link' is unknown: no transform"
    for index in range(WAITING):
        robot.send(index)
    assert not bench.wait_for(lambda: unknown in node.log_tail(), 1.0)
    robot.send(WAITING)
    said = lambda: node.log_tail().count(unknown)  # noqa: E731
    assert bench.wait_for(lambda: said() == 2, 60.0), node.log_tail()
    tilted = place(0.35, 0.1, 0.2, pitch=0.1)
    robot.tell_places({FRONT.frame: tilted, REAR.frame: REAR.T_base_laser})
    assert not bench.wait_for(lambda: bool(readings), 1.0)

    robot.tell_places({s.frame: s.T_base_laser for s in (FRONT, REAR)})
    assert not bench.wait_for(lambda: bool(readings), 1.0)
    for index in range(WAITING + 1, SWEEPS):
        robot.send(index)
        bench.wait_for(lambda n=index: len(readings) >= n, 20.0)
    # Those that waited are used; the first ones had no more room.
    done = SWEEPS - 1
    assert bench.wait_for(lambda: len(readings) == len(frames) == done), node.log_tail()
    assert said() == 2, 'once for each scanner'
    _check_motion(readings)
    _check_frame(frames[-1])
    assert 'Traceback' not in node.log.read_text()


def _check_motion(readings) -> None:
    first, last = (odometry_from_msg(readings[k]) for k in (0, -1))
    assert (last.parent, last.child) == ('odom_lidar', 'base_link')
    moved = np.linalg.inv(base_at(first.stamp_ns)) @ base_at(last.stamp_ns)
    error = np.linalg.inv(last.T_parent_child) @ moved
    assert np.hypot(*error[:2, 3]) < 0.05
    assert abs(np.arctan2(error[1, 0], error[0, 0])) < np.deg2rad(1.0)


def _check_frame(msg) -> None:
    """Both scanners' points, from where they were, without the motion during the sweep."""
    cloud, T = cloud_from_msg(msg), base_at(stamp_from_msg(msg.header.stamp))
    assert msg.header.frame_id == 'base_link'
    assert len(cloud.points) > 600
    assert np.ptp(cloud.viewpoints[:, 0]) > 0.5
    in_room = cloud.points @ T[:3, :3].T + T[:3, 3]
    assert np.median(distance_to_walls(in_room[:, :2])) < 0.03


def test_two_scanners_without_a_frame_to_merge_them_in_end_in_one_line(bench):
    node = bench.start('odometry', {'scan_topics': ['front/scan', 'rear/scan']})
    assert bench.wait_for(lambda: node.process.poll() is not None, 120.0)
    assert node.process.poll() == 1
    log = node.log.read_text()
    assert 'base_frame is empty; set it to merge 2 scanners' in log
    assert 'Traceback' not in log


class _Subscriptions:
    """Stands where a node does, and hands messages over without a middleware."""

    def __init__(self) -> None:
        self.callbacks = {}

    def add_subscription(self, _kind, topic, callback, _qos, raw=False) -> None:
        self.callbacks[topic] = callback

    def resolve_topic_name(self, topic: str) -> str:
        return topic if topic.startswith('/') else f'/{topic}'


def test_scanners_beside_wheels_are_merged_where_the_wheels_say_they_were():
    node, located, errors = _Subscriptions(), [], []
    parameters = InputParameters(scan_topics=('/front/scan', '/rear/scan'))
    log = NodeLog(SimpleNamespace(error=errors.append))
    scan_input = ScanInput(node, parameters, located.append, lambda: None, log)
    take, rng = node.callbacks, np.random.default_rng(6)
    assert set(take) == {'/front/scan', '/rear/scan', 'kiss/odometry', '/tf_static'}
    assert set(scan_input.silence_s) == {'/front/scan, /rear/scan', '/kiss/odometry'}

    def send(index):
        for topic, scanner in (('/front/scan', FRONT), ('/rear/scan', REAR)):
            stamp_ns, readings = scanner.readings(index, rng)
            take[topic](_message(LaserScan, stamp_ns, scanner.frame, readings), {})

    send(0)
    assert errors == [], 'they wait'
    places = [transform_to_msg(x.T_base_laser, 0, 'base_link', x.frame) for x in (FRONT, REAR)]
    take['/tf_static'](tf2_msgs.TFMessage(transforms=places))
    for index in range(1, 6):
        for at_ns in range(
            START_NS + (index - 1) * PERIOD_NS, START_NS + index * PERIOD_NS, 10**7
        ):
            take['kiss/odometry'](odometry_to_msg(base_at(at_ns), at_ns, 'odom', 'base_link'), {})
        send(index)
    assert errors == []
    assert len(located) == 4  # the last two end after the newest odometry
    assert scan_input.unlocated == 0
    for scan in located:
        assert scan.sensor_pose.odom_frame == 'odom'
        np.testing.assert_allclose(scan.T_odom_sensor, base_at(scan.stamp_ns), atol=1e-3)
        cloud = scan.unpack()
        in_room = cloud.points @ scan.T_odom_sensor[:3, :3].T + scan.T_odom_sensor[:3, 3]
        assert np.median(distance_to_walls(in_room[:, :2])) < 0.01
        assert np.ptp(cloud.viewpoints[:, 0]) > 0.5


@pytest.fixture(scope='module')
def drive(tmp_path_factory):
    """The start of a simulated recording with one planar scanner and wheels."""
    folder = tmp_path_factory.mktemp('drive')
    recording = start_of_recording(DRIVE_S, SENSORS['planar'])
    write_recording(recording, folder, with_wheels=True, laser_scans=True)
    poses = recording.truth()
    yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    return folder, recording, PlanarTrajectory(recording.stamps_ns, poses[:, :2, 3], yaw)


@pytest.mark.slow
@pytest.mark.parametrize('odometry', ['kiss', 'wheels'])
def test_scans_become_poses_on_the_floorplan(bench, drive, odometry):
    folder, recording, truth = drive
    poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
    reliable = 'qos_overrides.{}.subscription.reliability'
    lasers = {'scan_topics': [LASER_TOPIC], reliable.format(LASER_TOPIC): 'reliable'}
    own = {'max_pending_scans': 30, reliable.format('/kiss/frame'): 'reliable'}
    nodes = [bench.start('floorplan_server', {'floorplan': str(folder / 'floorplan.yaml')})]
    topics, pace = [LASER_TOPIC], {'max_ahead': 15}
    if odometry == 'kiss':
        nodes.append(bench.start('odometry', {'max_pending_scans': 30, **lasers}))
        localizer = bench.start('localizer', own)
    else:
        topics, pace = [LASER_TOPIC, ODOMETRY_TOPIC], {}
        localizer = bench.start('localizer', own | lasers, {'kiss/odometry': ODOMETRY_TOPIC})
    took = lambda: 'received the floorplan' in localizer.log_tail()  # noqa: E731
    assert bench.wait_for(took, 300.0), localizer.log_tail()
    played = {'bag': str(folder / 'bag'), 'topics': topics, 'wait_for_subscriber_s': 60.0, **pace}
    replay = bench.start('replay', played)

    def is_done() -> bool:
        bench.group.check(may_end=[replay])
        return len(poses) >= ENOUGH_POSES

    said = [node.log_tail() for node in (*nodes, localizer, replay)]
    assert bench.wait_for(is_done, 300.0), (len(poses), said)
    published = [pose_from_msg(msg) for msg in poses]
    in_plan = PlanarTrajectory(
        np.array([pose.stamp_ns for pose in published]),
        np.array([pose.T_frame_body.translation for pose in published]),
        np.array([pose.T_frame_body.yaw for pose in published]),
    )
    position_m, yaw_rad = pose_errors(in_plan.mapped(recording.A_plan_building.inv()), truth)
    assert np.median(position_m) < 0.3
    assert np.median(yaw_rad) < np.deg2rad(3.0)
    assert position_m.max() < 1.0
