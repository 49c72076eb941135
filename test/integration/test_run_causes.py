# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated drives that fail for a cause that the scans or the site tell, and what is named."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from fpnet.api.run import Run
from fpnet_core.config import load_config
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.sites import Site, Storey
from fpnet_core.types import CauseKind, Status
from fpnet_lab.sim.drives.recording import (
    Recording,
    RecordingOptions,
    make_recording,
    write_recording,
)
from fpnet_lab.sim.lidars.lidar import LidarModel

pytestmark = pytest.mark.slow

SCANS = 400


@dataclass(frozen=True)
class Drive:
    """The beginning of a simulated drive, as any recording is read."""

    recording: Recording
    has_poses: bool = False
    every: int = 1
    is_over: bool = False
    kind: str = 'folder'

    def __len__(self):
        return SCANS // self.every

    def __iter__(self):
        truth = self.recording.truth()
        for index in range(0, SCANS, self.every):
            scan = self.recording.scan(index)
            if self.is_over:
                scan = replace(scan, points=scan.points * np.float32([1, -1, -1]))
            if self.has_poses:
                T_odom_sensor = np.linalg.inv(truth[0]) @ truth[index]
                scan = replace(scan, T_odom_sensor=T_odom_sensor)
            yield scan


@pytest.fixture(scope='module')
def recording():
    return make_recording(2, RecordingOptions(lidar=LidarModel(beams=16, columns=180)))


@pytest.fixture(scope='module')
def plan(recording, tmp_path_factory):
    folder = tmp_path_factory.mktemp('drive')
    write_recording(replace(recording, tour=_start(recording.tour)), folder)
    return read_plan(folder / 'floorplan.yaml', ReadOptions(), load_config())


def _start(tour):
    parts = ('time_s', 'xy', 'yaw_rad', 'tilt_rad')
    return replace(tour, **{name: getattr(tour, name)[:100] for name in parts})


def kinds(plan, drive):
    return [cause.kind for cause in Run(plan, drive, load_config()).causes()]


def test_a_lidar_upside_down_is_no_mirrored_drawing(recording, plan):
    assert kinds(plan, Drive(recording, is_over=True)) == [CauseKind.UPSIDE_DOWN]


def test_two_scans_a_second_will_do(recording, plan):
    run = Run(plan, Drive(recording, every=5), load_config())
    assert (run.status, list(run.causes())) == (Status.LOCALIZED, [])


def test_one_scan_a_second_is_too_few_for_odometry(recording, plan):
    assert kinds(plan, Drive(recording, every=10))[0] is CauseKind.RARE_SCANS


def test_twin_storeys_are_no_other_building(recording, plan):
    site = Site('twins', (Storey('1', plan), Storey('2', plan)))
    found = kinds(site, Drive(recording, has_poses=True, every=2))
    assert found[0] is CauseKind.SELF_SIMILAR
    assert CauseKind.OTHER_PLAN not in found
