# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cloud in, pose out: every node from the colcon install space, in a process of its own."""

from pathlib import Path
import shlex
import subprocess
import sys

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid
import numpy as np
import pytest

from fpnet_core.evaluation.runs import pose_errors
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_ros.runtime import LATCHED, STATUS, STREAM
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_from_msg
from msg_adapters.poses import pose_from_msg

pytestmark = [pytest.mark.ros, pytest.mark.slow]

ENOUGH_POSES = 40
EXECUTABLES = {'fpnet', 'floorplan_server', 'localizer', 'odometry', 'replay'}


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
        'import fpnet_core.sim.plans, fpnet_ros, msg_adapters; from importlib import resources;'
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


def test_clouds_become_poses_on_the_floorplan(bench, install_space, excerpt):
    grids = bench.collect(OccupancyGrid, 'floorplan', LATCHED)
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
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
                'max_ahead': 15,
                'wait_for_subscriber_s': 60.0,
            },
            {},
        ),
    }
    children = {
        name: bench.start(name, *nodes[name], command=_installed(install_space, name))
        for name in ('floorplan_server', 'odometry', 'localizer')
    }
    took = lambda: 'took the floorplan' in children['localizer'].log_tail()  # noqa: E731
    assert bench.wait_for(took, 300.0), children['localizer'].log_tail()
    children['replay'] = bench.start(
        'replay', *nodes['replay'], command=_installed(install_space, 'replay')
    )

    def is_done() -> bool:
        bench.group.check(may_end=[children['replay']])
        return len(poses) >= ENOUGH_POSES

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
