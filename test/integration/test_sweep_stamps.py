# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses have the stamp of the instant that they are of, whatever a driver stamps clouds with."""

import numpy as np
import pytest
from turning_drive import STAMPS, TIMES, clouds, yaw_errors_deg

from fpnet_core.config import OdometryConfig
from fpnet_core.io.bag_writer import BagWriter
from fpnet_core.io.recordings import open_scans
from fpnet_core.odometry import KissOdometry


@pytest.mark.parametrize('times', TIMES)
@pytest.mark.parametrize('stamp', STAMPS)
def test_headings_are_right_at_their_stamps_while_the_robot_turns(tmp_path, stamp, times):
    with BagWriter(tmp_path / 'bag') as bag:
        for stamp_ns, points, time_s in clouds(stamp, times):
            bag.write_cloud('/points', stamp_ns, 'lidar', points, time_s=time_s)
    # Times tell which instant a stamp is of; without them somebody has to.
    said = stamp if times == 'missing' else 'auto'
    odometry, stamps_ns, poses = KissOdometry(OdometryConfig()), [], []
    for scan in open_scans(tmp_path / 'bag', scan_stamp=said):
        stamps_ns.append(scan.stamp_ns)
        poses.append(odometry.register_scan(scan).T_odom_sensor)
    errors = yaw_errors_deg(stamps_ns, poses)
    assert len(errors) > 140
    assert np.median(errors) < 0.5
