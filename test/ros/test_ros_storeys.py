# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot on a site, over DDS: it says the storey, hears of a level, and shows what differs."""

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import SCAN_NS, drive, recorded
from planted_site import MOVED, laid_elsewhere, other_storey
import pytest
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64, String
import yaml

from fpnet_core.io.maps import write_map
from fpnet_core.types import Status
from fpnet_ros.runtime import LATCHED, STATUS, STREAM
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.odometry import odometry_to_msg

pytestmark = [pytest.mark.ros, pytest.mark.slow]

START_NS = 1_700_000_000_000_000_000
PATIENCE_S = 240.0  # for busy machines; a quiet one needs seconds


def written_site(folder):
    """Two storeys that look the same, and one that does not."""
    plans = {
        'low': plan_grid(), 'high': laid_elsewhere(plan_grid()), 'attic': other_storey(),
    }  # fmt: skip
    for name, grid in plans.items():
        write_map(grid, folder / f'{name}.yaml')
    storeys = [
        {'name': name, 'plan': f'{name}.yaml', 'level': level, 'elevation': 3.5 * level}
        for level, name in enumerate(plans)
    ]
    path = folder / 'site.yaml'
    path.write_text(yaml.safe_dump({'site': 'tower', 'storeys': storeys}), encoding='utf-8')
    return path


def test_it_says_on_which_storey_it_is_and_hears_of_the_level(bench, tmp_path):
    said = bench.collect(String, 'localizer/storey', LATCHED)
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
    differences = bench.collect(OccupancyGrid, 'localizer/differences', LATCHED)
    reliable = 'qos_overrides./kiss/{}.subscription.reliability'
    node = bench.start(
        'localizer',
        {
            'site': str(written_site(tmp_path)),
            'localizer.update_period_s': 0.3,
            'max_pending_scans': 100,
            'scan_timeout_s': 600.0,  # a busy machine looks later than the last scan is good for
            reliable.format('frame'): 'reliable',
            reliable.format('odometry'): 'reliable',
        },
    )
    hints = bench.node.create_publisher(String, 'localizer/storey_hint', STREAM)
    heights = bench.node.create_publisher(Float64, 'localizer/elevation_hint', STREAM)
    frames = bench.node.create_publisher(PointCloud2, 'kiss/frame', STREAM)
    odometry = bench.node.create_publisher(Odometry, 'kiss/odometry', STREAM)

    def last():
        return report_from_msg(statuses[-1]) if statuses else None

    def send(first, stop):
        for index in range(first, stop):
            points, T, stamp_ns = recorded()[index]
            frames.publish(cloud_to_msg(points, START_NS + stamp_ns, 'lidar'))
            odometry.publish(odometry_to_msg(T, START_NS + stamp_ns, 'odom', 'lidar'))
            bench.wait_for(lambda: False, SCAN_NS * 1e-9)

    ready = (frames, odometry, hints, heights)
    assert bench.wait_for(
        lambda: bool(statuses) and all(each.get_subscription_count() for each in ready), 180.0
    ), node.log_tail()
    half = len(recorded()) // 2
    send(0, half)
    assert bench.wait_for(lambda: last().status is Status.AMBIGUOUS, PATIENCE_S), node.log_tail()
    assert not said  # equal storeys stay open
    assert not poses

    hints.publish(String(data='cellar'))
    assert bench.wait_for(lambda: 'storey_hint was rejected' in node.log.read_text())
    hints.publish(String(data='high'))
    assert bench.wait_for(lambda: 'received the hint' in node.log.read_text()), node.log_tail()
    heights.publish(Float64(data=float('nan')))
    assert bench.wait_for(lambda: 'elevation_hint was rejected' in node.log.read_text())
    heights.publish(Float64(data=3.0))
    assert bench.wait_for(lambda: 'the floor is at 3 m' in node.log.read_text()), node.log_tail()
    send(half, len(recorded()))
    assert bench.wait_for(lambda: bool(said), PATIENCE_S), node.log_tail()
    assert said[-1].data == 'high'
    assert bench.wait_for(lambda: bool(poses), PATIENCE_S), node.log_tail()
    assert {msg.header.frame_id for msg in poses} == {'high'}
    is_found = lambda: last().status is Status.LOCALIZED  # noqa: E731
    assert bench.wait_for(is_found), node.log_tail()  # the status follows the pose
    x, y, _ = drive()[-1]
    true = MOVED.apply(A_BUILDING_PLAN.inv().apply(np.array([x, y])))
    position = poses[-1].pose.position
    np.testing.assert_allclose((position.x, position.y), true, atol=1.0)

    assert bench.wait_for(lambda: bool(differences), PATIENCE_S), node.log_tail()
    grid = differences[-1]
    assert grid.header.frame_id == 'high'
    assert (grid.info.height, grid.info.width) == plan_grid().shape
    values = np.array(grid.data)
    assert (values == 0).any()  # seen, as drawn
    assert (values == -1).any()  # not seen
    assert (values > 50).mean() < 0.002  # the drawing is right
    assert 'Traceback' not in node.log.read_text()
