# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cloud in, pose out: every node in a process of its own; and the colcon install space."""

from pathlib import Path
import shlex
import subprocess
import sys

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid
import numpy as np
import pytest
from visualization_msgs.msg import MarkerArray

from fpnet.accuracy import pose_errors
from fpnet_core.geometry import SE2
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_from_msg
from msg_adapters.poses import pose_from_msg, uncertain_pose_from_msg
from msg_adapters.transforms import transform_from_msg

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = [pytest.mark.ros, pytest.mark.slow]

ENOUGH_POSES = 40
EXECUTABLES = {'fpnet', 'floorplan_server', 'localizer', 'odometry', 'replay', 'seeder'}


def _sourced(install_space: Path, command: str) -> list[str]:
    setup = shlex.quote(str(install_space / 'setup.bash'))
    return ['bash', '-c', f'source {setup} && exec {command} "$@"', '--']


def _installed(install_space: Path, name: str) -> list[str]:
    """Return what ``ros2 run fpnet_ros NAME`` executes, in a shell that sourced the workspace."""
    executable = install_space / 'fpnet_ros' / 'lib' / 'fpnet_ros' / name
    return _sourced(install_space, shlex.quote(str(executable)))


def test_the_install_space_holds_what_ros2_run_needs(install_space):
    prefix = install_space / 'fpnet_ros'
    executables = {path.name for path in (prefix / 'lib' / 'fpnet_ros').iterdir()}
    assert executables == EXECUTABLES
    share = prefix / 'share' / 'fpnet_ros'
    for name in (
        *('package.xml', 'config/fpnet.yaml', 'config/fastdds_shm.xml', 'config/fpnet.rviz'),
        *('config/foxglove.json', 'launch/localizer.launch.py', 'launch/demo.launch.py'),
    ):
        assert (share / name).is_file(), name
    assert (prefix / 'share/ament_index/resource_index/packages/fpnet_ros').is_file()


def test_the_packages_come_from_the_install_space(install_space, tmp_path):
    script = (
        'import fpnet, fpnet_core, fpnet_lab.sim.plans, fpnet_ros, msg_adapters;'
        'from importlib import resources;'
        'print(fpnet_core.__file__, fpnet_ros.__file__, msg_adapters.__file__);'
        'print(sorted(p.name for p in resources.files("fpnet_core.weights").iterdir()))'
    )
    command = [*_sourced(install_space, shlex.quote(sys.executable)), '-c', script]
    result = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60
    )
    paths, weights = result.stdout.splitlines()
    assert all(path.startswith(str(install_space)) for path in paths.split())
    assert 'matcher.safetensors' in weights
    assert 'matcher.json' in weights


def test_every_installed_node_starts(install_space, tmp_path):
    """As far as its parameters: one that is not there or is missing ends it with a line."""
    started = {
        name: subprocess.Popen(
            [*_installed(install_space, name), '--ros-args', '-p', 'misspelt:=1.0'],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for name in sorted(EXECUTABLES - {'fpnet'})
    }
    for name, process in started.items():
        printed, _ = process.communicate(timeout=300)
        assert process.returncode == 1, (name, printed)
        said = 'bag is empty' if name == 'replay' else 'misspelt is unknown'
        assert said in printed.splitlines()[-1], name


class Seen:
    """Everything beside the pose, held to the truth and to one another."""

    def __init__(self, bench) -> None:
        self.twins = bench.collect(
            PoseWithCovarianceStamped, 'floorplan_pose_with_covariance', STREAM
        )
        self.tfs = bench.collect(tf2_msgs.TFMessage, '/tf', TF)
        self.diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
        self.markers = bench.collect(MarkerArray, 'localizer/markers', LATCHED)

    def check(self, excerpt) -> None:
        twins = [uncertain_pose_from_msg(msg) for msg in self.twins]
        self._check_twins(twins, excerpt.truth)
        self._check_tf(twins[-1].pose)
        self._check_markers(twins[-1].pose)
        names = {status.name for msg in self.diagnostics for status in msg.status}
        assert names == {
            '/localizer: localization',
            '/localizer: doctor',
            '/odometry: doctor',
            '/odometry: registration',
        }
        scales = [
            report_from_msg(status).values['scale']
            for msg in self.diagnostics
            for status in msg.status
            if any(entry.key == 'scale' for entry in status.values)
        ]
        true_scale = excerpt.A_plan_building.scale
        assert abs(scales[-1] / true_scale - 1.0) < 0.03

    @staticmethod
    def _check_twins(twins, truth) -> None:
        """In ``map`` distances are true: a rigid motion brings the poses onto the truth."""
        assert {twin.pose.frame_id for twin in twins} == {'map'}
        assert all((np.linalg.eigvalsh(twin.cov) > 0.0).all() for twin in twins)
        stamps = np.array([twin.pose.stamp_ns for twin in twins])
        true, _ = truth.at(stamps)
        xy = np.array([twin.pose.T_frame_body.translation for twin in twins])
        here, there = xy - xy.mean(axis=0), true.xy - true.xy.mean(axis=0)
        U, _, Vt = np.linalg.svd(here.T @ there)
        turn = U @ np.diag([1.0, np.linalg.det(U @ Vt)]) @ Vt
        assert np.median(np.linalg.norm(here @ turn - there, axis=1)) < 0.3

    def _check_tf(self, pose) -> None:
        """The localizer's transform followed by that of odometry is the twin."""
        by_child = {}
        for msg in self.tfs:
            for t in map(transform_from_msg, msg.transforms):
                by_child.setdefault((t.parent, t.child), {})[t.stamp_ns] = t.T_parent_child
        assert set(by_child) == {('map', 'odom_lidar'), ('odom_lidar', 'lidar')}
        T_map_odom = list(by_child['map', 'odom_lidar'].values())[-1]
        T_odom_lidar = by_child['odom_lidar', 'lidar'][pose.stamp_ns]
        T_map_lidar = SE2.from_matrix4(T_map_odom @ T_odom_lidar)
        np.testing.assert_allclose(T_map_lidar.matrix, pose.T_frame_body.matrix, atol=0.3)

    def _check_markers(self, pose) -> None:
        """Rooms of both sides are drawn, and the best placement where the robot is."""
        drawn = {}
        for marker in self.markers[-1].markers[1:]:
            drawn.setdefault(marker.ns, marker)
        assert {'plan_rooms', 'plan_doors', 'submap_rooms', 'hypotheses'} <= set(drawn)
        at = drawn['hypotheses'].pose.position
        assert np.hypot(*(pose.T_frame_body.translation - (at.x, at.y))) < 3.0


def test_clouds_become_poses_on_the_floorplan(bench, excerpt):
    grids = bench.collect(OccupancyGrid, 'floorplan', LATCHED)
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
    seen = Seen(bench)
    reliable = 'qos_overrides.{}.subscription.reliability'
    nodes = {
        'floorplan_server': ({'floorplan': str(excerpt.floorplan), 'frame_id': 'storey_2'}, {}),
        'odometry': (
            {reliable.format('/points'): 'reliable', 'max_pending_scans': 30},
            {'pointcloud_topic': '/points'},
        ),
        'localizer': ({reliable.format('/kiss/frame'): 'reliable', 'max_pending_scans': 30}, {}),
        'replay': (
            {
                'bag': str(excerpt.folder / 'bag'),
                'topics': ['/points'],
                'rate': 2.0,
                'max_ahead': 15,
                'wait_for_subscriber_s': 60.0,
            },
            {},
        ),
    }
    children = {
        name: bench.start(name, *nodes[name])
        for name in ('floorplan_server', 'odometry', 'localizer')
    }
    took = lambda: 'received the floorplan' in children['localizer'].log_tail()  # noqa: E731
    assert bench.wait_for(took, 300.0), children['localizer'].log_tail()
    children['replay'] = bench.start('replay', *nodes['replay'])

    def is_done() -> bool:
        bench.group.check(may_end=[children['replay']])
        # The scale is that of all that was driven, however far ahead of the ticks the poses are.
        ticked_ns = report_from_msg(statuses[-1]).stamp_ns if statuses else 0
        return len(poses) >= ENOUGH_POSES and ticked_ns >= excerpt.stamps_ns[-1]

    done = bench.wait_for(is_done, 400.0)
    reports = [report_from_msg(msg) for msg in statuses]
    story = [(report.stamp_ns, report.status.value, report.probability) for report in reports]
    if not done:
        logs = [f'{name}: {child.log_tail()}' for name, child in children.items()]
        pytest.fail('\n'.join([f'{len(poses)} poses', *map(str, story), *logs]))
    assert grids[0].header.frame_id == 'storey_2'
    assert {msg.header.frame_id for msg in poses} == {'storey_2'}
    published = [pose_from_msg(msg) for msg in poses]
    stamps = np.array([pose.stamp_ns for pose in published])
    assert np.isin(stamps, excerpt.stamps_ns).all()
    assert (np.diff(stamps) > 0).all()
    in_plan = PlanarTrajectory(
        stamps,
        np.array([pose.T_frame_body.translation for pose in published]),
        np.array([pose.T_frame_body.yaw for pose in published]),
    )
    position_m, yaw_rad = pose_errors(in_plan.mapped(excerpt.A_plan_building.inv()), excerpt.truth)
    assert np.median(position_m) < 0.5
    assert np.median(yaw_rad) < np.deg2rad(3.0)
    assert position_m.max() < 3.0
    # The pose draws in the right place on the very grid that the server published: in free space.
    grid = grid_from_msg(grids[0])
    rows, columns = np.rint(grid.xy_to_rc(in_plan.xy)).astype(int).T
    assert (grid.cells[rows, columns] == 0).mean() > 0.95
    assert any(report.values.get('total_ms', 0.0) > 0.0 for report in reports)
    seen.check(excerpt)
