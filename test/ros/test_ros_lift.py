# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A bag of two drives and a ride in a shut lift, through KISS-ICP and the localizer on a site."""

from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from lift_rides import LiftRide, lift_ride
import numpy as np
import pytest
from std_msgs.msg import String
import yaml

from fpnet.bag_writer import BagWriter
from fpnet_core.io.maps import write_map
from fpnet_core.types import Status
from fpnet_lab.sim.drawn.distort import renovated
from fpnet_lab.sim.drives.recording import (
    CLOUD_TOPIC,
    LIDAR_FRAME,
    RecordingOptions,
    make_recording,
)
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.lidars.sensors import SENSORS
from fpnet_ros.runtime import LATCHED, STATUS, STREAM
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.poses import pose_from_msg

pytestmark = [pytest.mark.ros, pytest.mark.slow]

OPTIONS = RecordingOptions(
    family='double_corridor',
    rooms=(8, 30),
    limits=TourLimits(rooms=3, shortest_s=22.0, longest_s=36.0),
    lidar=SENSORS['beams16'],
)
SEEDS = 11, 12
STOREYS = 'ground', 'second'
RIGHT_M = 1.0


@dataclass(frozen=True)
class Recorded:
    """A bag, a site with a third storey that is like the first, and where the robot truly was."""

    folder: str
    ride: LiftRide
    true: dict[int, tuple[int, np.ndarray]]

    def is_right(self, pose) -> bool:
        """Tell whether a pose is on the robot's storey, where it is."""
        part, T = self.true[pose.stamp_ns]
        storey = 1 if part == 2 else 0
        here = self.ride.storeys[storey]
        # In the cabin it stands still, in the cabin's own frame.
        true = self.ride.at[0] if part == 1 else here.A_plan_building.apply(T[:2, 3])
        off_m = np.linalg.norm(pose.T_frame_body.translation - true)
        return pose.frame_id == STOREYS[storey] and off_m <= RIGHT_M


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp('lift')
    ride = lift_ride(*(make_recording(seed, OPTIONS, threads=1) for seed in SEEDS))
    low, high = ride.storeys
    alike, rng = low.floorplan, np.random.default_rng(5)
    for _ in range(3):
        alike = renovated(alike, low.building.plan, low.A_plan_building, rng)
    plans = {'ground': low.floorplan, 'first': alike, 'second': high.floorplan}
    stops = {'ground': ride.at[0], 'first': ride.at[0], 'second': ride.at[1]}
    for name, grid in plans.items():
        write_map(grid, folder / f'{name}.yaml')
    site = {
        'storeys': [{'name': n, 'plan': f'{n}.yaml', 'level': k} for k, n in enumerate(plans)],
        'links': [
            {'name': 'A', 'kind': 'lift', 'at': {n: xy.tolist() for n, xy in stops.items()}}
        ],
    }
    (folder / 'site.yaml').write_text(yaml.safe_dump(site), encoding='utf-8')
    true = {}
    with BagWriter(folder / 'bag') as bag:
        for part, scan in ride:
            since_stamp = (scan.time_s - OPTIONS.lidar.period_s).astype(np.float32)
            bag.write_cloud(
                *(CLOUD_TOPIC, scan.stamp_ns, LIDAR_FRAME, scan.points, scan.intensity),
                *(scan.ring, since_stamp),
            )
            true[scan.stamp_ns] = part, scan.T_truth_sensor
    return Recorded(str(folder), ride, true)


def test_two_claims_and_no_wrong_pose_though_nobody_says_a_word(bench, recorded):
    said = bench.collect(String, 'localizer/storey', LATCHED)
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
    reliable = 'qos_overrides.{}.subscription.reliability'
    bench.start(
        'odometry',
        {reliable.format('/points'): 'reliable', 'max_pending_scans': 30},
        {'pointcloud_topic': '/points'},
    )
    node = bench.start(
        'localizer',
        {
            'site': f'{recorded.folder}/site.yaml',
            'localizer.update_period_s': 0.5,
            'max_pending_scans': 30,
            reliable.format('/kiss/frame'): 'reliable',
            reliable.format('/kiss/odometry'): 'reliable',
        },
    )
    replay = bench.start(
        'replay',
        {
            'bag': f'{recorded.folder}/bag',
            'rate': 2.0,
            'max_ahead': 15,
            'wait_for_localizer': True,
            'wait_for_subscriber_s': 120.0,
        },
    )
    last_ns = max(recorded.true)

    def is_over() -> bool:
        bench.group.check(may_end=[replay])
        return bool(poses) and pose_from_msg(poses[-1]).stamp_ns >= last_ns - 1_000_000_000

    assert bench.wait_for(is_over, 240.0), (len(poses), said, node.log_tail())
    assert tuple(msg.data for msg in said) == STOREYS
    published = [pose_from_msg(msg) for msg in poses]
    wrong = [pose for pose in published if not recorded.is_right(pose)]
    assert not wrong, wrong[:3]
    parts = np.array([recorded.true[pose.stamp_ns][0] for pose in published])
    assert (np.bincount(parts, minlength=3)[[0, 2]] > 10).all()
    told = [report_from_msg(msg).status for msg in statuses]
    assert Status.WAITING in told[told.index(Status.LOCALIZED) :]  # for the doors
