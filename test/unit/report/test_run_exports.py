# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A run for evo, map_server and Foxglove."""

from dataclasses import replace
import shutil
import subprocess

import numpy as np
from planted import A_PLAN_SUBMAP
import pytest

from fpnet.recordings.trajectories import read_tum, write_tum
from fpnet.report import write_run_exports
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.geometry.rigid3d import rigid_from_quaternion
from fpnet_core.io.bags import BagReader
from fpnet_core.io.maps import read_map
from fpnet_core.types import FREE, OCCUPIED

COVARIANCES = np.stack([np.diag([0.01, 0.04, 0.0009]), np.diag([0.02, 0.05, 0.001])])


@pytest.fixture(scope='module')
def exported(made_up_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp('exports') / 'new'
    run = made_up_run
    for _ in range(2):  # the second one replaces the first
        write_run_exports(
            folder, run.plan.grid, run.outputs, run.published, COVARIANCES, run.published
        )
    return folder


def test_the_folder_holds_these_files(exported):
    assert sorted(path.name for path in exported.iterdir()) == [
        *('covariances.csv', 'map.png', 'map.yaml', 'odometry.tum', 'poses.tum', 'run.mcap'),
        *('submap.png', 'submap.yaml'),
    ]


def test_floorplan_and_submap_lie_on_each_other_in_map(exported, made_up_run):
    """Both read as map_server maps; the walls of one are those of the other."""
    plan, sub = read_map(exported / 'map.yaml'), read_map(exported / 'submap.yaml')
    walls = sub.rc_to_xy(np.argwhere(sub.cells == OCCUPIED)[::50])
    rows, columns = np.rint(plan.xy_to_rc(walls)).astype(int).T
    near = np.zeros(plan.shape, bool)
    for shift in np.ndindex(7, 7):
        near |= np.roll(plan.cells == OCCUPIED, np.subtract(shift, 3), (0, 1))
    assert near[rows, columns].mean() > 0.95
    # The drawing is 2 % too large along one axis and 1.5 % too small along the other.
    assert (plan.cells == FREE).sum() * plan.resolution**2 == pytest.approx(
        (made_up_run.plan.grid.cells == FREE).sum()
        * made_up_run.plan.grid.resolution**2
        / abs(np.linalg.det(A_PLAN_SUBMAP.linear)),
        rel=0.01,
    )


def test_a_run_that_was_never_localised_keeps_plan_and_odom(made_up_run, tmp_path):
    run = made_up_run
    write_run_exports(
        tmp_path, run.plan.grid, run.outputs[:2], run.published, COVARIANCES, run.published
    )
    assert read_map(tmp_path / 'map.yaml').shape == run.plan.grid.shape
    origin: Affine2D = read_map(tmp_path / 'submap.yaml').T_frame_grid
    submap = run.outputs[1].submap
    expected = submap.T_odom_submap @ submap.grid.T_frame_grid
    np.testing.assert_allclose(origin.matrix, expected.matrix, atol=1e-6)
    write_run_exports(tmp_path, run.plan.grid, (), run.published, COVARIANCES, run.published)


def test_the_bag_puts_the_robot_where_the_poses_do(exported, made_up_run):
    transforms, texts, poses, grids = {}, [], [], []
    with BagReader(exported / 'run.mcap') as bag:
        counts = {topic: bag.count(topic) for topic in bag.topics}
        for topic, _, msg in bag.messages(list(bag.topics)):
            if topic == '/tf':
                [t] = msg.transforms
                move, turn = t.transform.translation, t.transform.rotation
                transforms[t.header.frame_id, t.child_frame_id] = SE2.from_matrix4(
                    rigid_from_quaternion(
                        [move.x, move.y, move.z], [turn.x, turn.y, turn.z, turn.w]
                    )
                )
            elif topic == '/localizer/status':
                texts.append(msg.data)
            elif topic == '/floorplan_pose':
                poses.append((msg.header.frame_id, msg.pose.position.x, msg.pose.position.y))
            elif topic.endswith('/submap'):
                grids.append(msg.header.frame_id)
    assert counts == {
        '/map': 1, '/odometry': 2, '/tf': 3, '/floorplan_pose': 2,
        '/floorplan_pose_with_covariance': 2, '/localizer/status': 3,
        '/localizer/probability': 3, '/localizer/tick_ms': 2, '/localizer/submap': 2,
    }  # fmt: skip
    assert texts == [output.status.value for output in made_up_run.outputs]
    assert grids == ['odom', 'odom']
    submap = made_up_run.outputs[2].submap
    in_odom = submap.T_odom_submap.apply(submap.path_xy[-1])
    assert poses[0][0] == 'map'
    assert transforms['map', 'odom'].apply(in_odom) == pytest.approx(poses[0][1:], abs=0.02)


def test_the_folder_says_what_each_pose_may_be_off_by(exported, made_up_run):
    header, *rows = (exported / 'covariances.csv').read_text().splitlines()
    assert header == 't,xx,xy,x_yaw,yy,y_yaw,yaw_yaw'
    found = np.array([row.split(',')[1:] for row in rows], dtype=float)
    np.testing.assert_allclose(
        found, [[0.01, 0, 0, 0.04, 0, 0.0009], [0.02, 0, 0, 0.05, 0, 0.001]]
    )
    with BagReader(exported / 'run.mcap') as bag:
        [first, _] = [msg for *_, msg in bag.messages(['/floorplan_pose_with_covariance'])]
    stretch = made_up_run.outputs[-1].A_plan_odom.stretch
    expected = np.linalg.inv(stretch) @ COVARIANCES[0, :2, :2] @ np.linalg.inv(stretch)
    got = np.reshape(first.pose.covariance, (6, 6))
    np.testing.assert_allclose(got[:2, :2], expected, atol=1e-9)
    assert got[5, 5] == pytest.approx(0.0009)


def test_evo_reads_the_trajectories(exported, made_up_run, tmp_path):
    evo = shutil.which('evo_ape')
    if evo is None:
        pytest.skip('evo is not installed; pipx install evo')
    truth = made_up_run.published
    moved = replace(truth, xy=truth.xy + np.array([0.0, 0.1]))
    write_tum(tmp_path / 'truth.tum', moved.stamps_ns, moved.xy, moved.yaw)
    command = [evo, 'tum', str(tmp_path / 'truth.tum'), str(exported / 'poses.tum')]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert 'rmse\t0.100' in printed
    assert len(read_tum(exported / 'poses.tum')) == 2
