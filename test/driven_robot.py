# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot that drives through the planted building, for a localizer in a process of its own."""

import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from planted import A_BUILDING_PLAN
from planted_drive import drive, recorded
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from fpnet_core.geometry import SE2
from fpnet_core.types import GridMap, Status
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.stamps import stamp_to_msg

NAMESPACE = '/robot_1'
NODE = f'{NAMESPACE}/finder'
TOLERANCE_S = 0.3
TOLERANCE_NS = 300_000_000  # stamps are too long for floats
START_NS = 1_700_000_000_000_000_000
STEP_NS = 200_000_000
PATIENCE_S = 240.0  # for busy machines; a quiet one needs seconds


class Robot:
    """Publishes clock, scans and odometry of the drive, to and fro."""

    def __init__(self, bench, state_file) -> None:
        self.bench = bench
        self.state_file = state_file
        node = bench.node
        self._clock = node.create_publisher(Clock, '/clock', 10)
        self._clouds = node.create_publisher(PointCloud2, f'{NAMESPACE}/registered', STREAM)
        self._floorplans = node.create_publisher(OccupancyGrid, f'{NAMESPACE}/floorplan', LATCHED)
        self.initial_pose = node.create_publisher(
            PoseWithCovarianceStamped, f'{NAMESPACE}/initialpose', STREAM
        )
        self._odometry = node.create_publisher(Odometry, f'{NAMESPACE}/kiss/odometry', STREAM)
        topics = {
            'statuses': (DiagnosticStatus, f'{NODE}/status', STATUS),
            'diagnostics': (DiagnosticArray, '/diagnostics', STREAM),
            'poses': (PoseStamped, f'{NAMESPACE}/floorplan_pose', STREAM),
            'twins': (
                PoseWithCovarianceStamped,
                f'{NAMESPACE}/floorplan_pose_with_covariance',
                STREAM,
            ),
            'paths': (Path, f'{NAMESPACE}/floorplan_path', LATCHED),
            'goals': (PoseStamped, f'{NODE}/next_look', STREAM),
            'markers': (MarkerArray, f'{NODE}/markers', LATCHED),
            'submaps': (OccupancyGrid, f'{NODE}/submap', LATCHED),
            'scaled': (OccupancyGrid, f'{NODE}/floorplan_scaled', LATCHED),
            'tfs': (TFMessage, '/tf', TF),
        }
        for name, topic in topics.items():
            setattr(self, name, bench.collect(*topic))
        self.tf_heard_s: list[float] = []
        node.create_subscription(
            TFMessage, '/tf', lambda _: self.tf_heard_s.append(time.monotonic()), TF
        )
        self.index = 0
        self.offset_ns = START_NS
        self.child = None
        self.start()

    def start(self, more: dict | None = None) -> None:
        reliable = f'qos_overrides.{NAMESPACE}/{{}}.subscription.reliability'
        self.child = self.bench.start(
            'localizer',
            {
                'use_sim_time': True,
                'transform_tolerance': TOLERANCE_S,
                'max_pending_scans': 50,
                'state_file': str(self.state_file),
                'autosave_period_s': 1.0,
                'scan_timeout_s': 5.0,  # longer than a test lets the clock run without a scan
                'localizer.update_period_s': 0.4,
                reliable.format('registered'): 'reliable',
                reliable.format('kiss/odometry'): 'reliable',
                **(more or {}),
            },
            {'__ns': NAMESPACE, '__node': 'finder', 'kiss/frame': 'registered'},
        )

    def is_heard(self) -> bool:
        publishers = (self._clouds, self._odometry, self._clock, self._floorplans)
        return all(publisher.get_subscription_count() for publisher in publishers)

    def show(self, grid: GridMap, frame_id: str) -> None:
        self._floorplans.publish(grid_to_msg(grid, self.now_ns, frame_id))

    @property
    def now_ns(self) -> int:
        return self.offset_ns + self.index * STEP_NS

    def position(self, stamp_ns: int) -> int:
        """Index into the drive at a time: to and fro, so that odometry never jumps."""
        last = len(drive()) - 1
        return last - abs(last - (stamp_ns - self.offset_ns) // STEP_NS % (2 * last))

    def truth(self, stamp_ns: int) -> SE2:
        """Pose on the drawing at a time."""
        x, y, yaw = drive()[self.position(stamp_ns)]
        T_plan_building = A_BUILDING_PLAN.inv()
        at = T_plan_building.apply((x, y))
        return SE2.from_xy_yaw(*at, T_plan_building.apply_yaw(yaw))

    def step(self) -> None:
        """One scan further, and one tick of the clock."""
        self.index += 1
        points, T_odom_sensor, _ = recorded()[self.position(self.now_ns)]
        self._clock.publish(Clock(clock=stamp_to_msg(self.now_ns)))
        self._odometry.publish(odometry_to_msg(T_odom_sensor, self.now_ns, 'odom', 'lidar'))
        self._clouds.publish(cloud_to_msg(points, self.now_ns, 'lidar'))

    def step_until(self, condition, timeout_s=PATIENCE_S) -> bool:
        """Go on, at a pace that a busy machine keeps up with, until the condition holds."""
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.step()
            self.bench.wait_for(condition, 0.15)
        return True

    @property
    def status(self) -> Status | None:
        return report_from_msg(self.statuses[-1]).status if self.statuses else None

    def is_localized(self) -> bool:
        return self.status is Status.LOCALIZED

    def localize(self) -> None:
        assert self.step_until(self.is_localized), (self.statuses[-1:], self.child.log_tail())
        for messages in (self.poses, self.twins, self.tfs, self.diagnostics):
            messages.clear()
        assert self.step_until(lambda: self.poses and self.twins and self.tfs)

    def logs(self, text: str) -> bool:
        return self.bench.wait_for(lambda: text in self.child.log.read_text(), PATIENCE_S)

    def change_state(self, transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return self.bench.call(ChangeState, f'{NODE}/change_state', request).success

    def state(self) -> str:
        return self.bench.call(GetState, f'{NODE}/get_state').current_state.label

    def set(self, name: str, value):
        request = SetParameters.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg()]
        )
        (result,) = self.bench.call(SetParameters, f'{NODE}/set_parameters', request).results
        return result
