# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses have the stamp of the instant that they are of, whatever a driver stamps clouds with."""

from itertools import product

import numpy as np
import pytest
from turning_drive import OTHER_SEEDS, STAMPS, clouds, lag_ms, yaw_errors_deg

from fpnet.bag_writer import BagWriter
from fpnet.recordings.opening import open_scans
from fpnet_core.config import OdometryConfig
from fpnet_core.io.scans import Scan
from fpnet_core.odometry import KissOdometry

LAG_MS = 15.0  # half a sweep is 50 ms, and one drive's lag is known to some milliseconds


def registered(scans):
    odometry, stamps_ns, poses = KissOdometry(OdometryConfig()), [], []
    for scan in scans:
        stamps_ns.append(scan.stamp_ns)
        poses.append(odometry.register_scan(scan).T_odom_sensor)
    return stamps_ns, poses


# Absolute times are the same whatever the stamp is of.
@pytest.mark.parametrize(
    ('stamp', 'times'), [('end', 'absolute'), *product(STAMPS, ('relative', 'missing'))]
)
def test_headings_are_right_at_their_stamps_while_the_robot_turns(tmp_path, stamp, times):
    with BagWriter(tmp_path / 'bag') as bag:
        for stamp_ns, points, time_s in clouds(stamp, times):
            bag.write_cloud('/points', stamp_ns, 'lidar', points, time_s=time_s)
    # Times tell which instant a stamp is of; without them somebody has to.
    said = stamp if times == 'missing' else 'auto'
    stamps_ns, poses = registered(open_scans(tmp_path / 'bag', scan_stamp=said))
    errors = yaw_errors_deg(stamps_ns, poses)
    assert len(errors) > 140
    assert np.median(np.abs(errors)) < 0.5
    assert abs(lag_ms(stamps_ns, errors)) < LAG_MS


def test_headings_without_times_are_those_of_the_middle_of_a_sweep_on_every_drive():
    lags_ms, in_a_second_deg = [], []
    for seed in OTHER_SEEDS:
        given = clouds('middle', 'missing', seed)
        stamps_ns, poses = registered(Scan(stamp_ns, points) for stamp_ns, points, _ in given)
        errors = yaw_errors_deg(stamps_ns, poses, seed)
        lags_ms.append(lag_ms(stamps_ns, errors, seed))
        in_a_second_deg.append(np.median(np.abs(errors[10:] - errors[:-10])))
    assert np.abs(lags_ms).max() < LAG_MS, lags_ms
    assert abs(np.mean(lags_ms)) < 0.5 * LAG_MS, lags_ms
    assert np.median(in_a_second_deg) < 0.4, in_a_second_deg
