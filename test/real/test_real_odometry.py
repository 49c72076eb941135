# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Odometry by the scans of a real laser log alone: 4 a second, of a robot that turns fast."""

from dataclasses import replace

import numpy as np
import pytest
from real_data import DATA, needs

from fpnet.recordings.opening import open_scans
from fpnet_core.config import OdometryConfig
from fpnet_core.odometry import KissOdometry
from fpnet_lab.evaluation.fitted_truth import read_fitted_truth

pytestmark = [pytest.mark.real, needs('radish')]

SCANS, APART = slice(1600), 10


def test_scans_alone_go_where_the_log_went():
    log = read_fitted_truth(DATA / 'radish', 'freiburg-079').log
    scans = list(open_scans(log))[SCANS]
    odometry = KissOdometry(OdometryConfig())
    poses = np.array(
        [odometry.register_scan(replace(s, T_odom_sensor=None)).T_odom_sensor for s in scans]
    )
    truth = np.array([scan.T_odom_sensor for scan in scans])
    moved, true = (np.linalg.inv(each[:-APART]) @ each[APART:] for each in (poses, truth))
    off = np.linalg.inv(true) @ moved
    metres = np.linalg.norm(off[:, :2, 3], axis=1)
    degrees = np.rad2deg(np.abs(np.arctan2(off[:, 1, 0], off[:, 0, 0])))
    assert np.median(metres) < 0.06
    assert np.percentile(metres, 99) < 0.3
    assert np.percentile(degrees, 99) < 6.0
