# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Segmentation and submap building on real plans, robot maps and lidar scans."""

import cv2
import numpy as np
import pytest
from real_data import DATA, needs

from fpnet_core.config import SegmentationConfig, SubmapConfig
from fpnet_core.segmentation import segment_floorplan, segment_submap, segment_unknown_scale
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.submaps import SubmapBuilder, submap_from_grid
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.evaluation.segmentation import bench_plans, bench_robot_maps

BORMANN = DATA / 'bormann'
CONFIG = SegmentationConfig()

pytestmark = [
    pytest.mark.real,
    needs('bormann'),
]


def read_grid(path, resolution_m=0.05, free_grey=250, occupied_grey=100):
    grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)[::-1]
    cells = np.where(grey >= free_grey, FREE, np.where(grey < occupied_grey, OCCUPIED, UNKNOWN))
    return GridMap(cells, resolution_m)


def read_labels(path):
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[::-1].astype(np.int32)


# Measured with fpnet bench segmentation, less a margin of about five points.
@pytest.mark.parametrize(
    ('image', 'labels', 'least_f1'),
    [
        ('floorplan/office_b.png', 'office_b', 0.95),
        ('furnished/office_a_furnitures.png', 'office_a', 0.86),
        ('floorplan/NLB.png', 'NLB', 0.83),
        ('furnished/office_f_furnitures.png', 'office_f', 0.95),
        ('floorplan/Freiburg79_scan.png', 'Freiburg79_scan', 0.92),
        ('floorplan/lab_intel.png', 'lab_intel', 0.74),
    ],
)
def test_floorplans_agree_with_human_labels(image, labels, least_f1):
    segmentation = segment_floorplan(read_grid(BORMANN / image), CONFIG)
    truth = read_labels(BORMANN / 'room_labels' / f'{labels}.png')
    agreement = room_agreement(segmentation.labels, truth)
    assert agreement.f1 > least_f1
    assert agreement.precision > 0.9
    assert agreement.recall > 0.85


@pytest.mark.parametrize('plan', ['office_e', 'NLB', 'Freiburg52_scan'])
@pytest.mark.parametrize('wrong_by', [0.3, 3.0])
def test_scale_of_a_plan_is_recovered(plan, wrong_by):
    grid = read_grid(BORMANN / 'floorplan' / f'{plan}.png', 0.05 * wrong_by)
    _, estimate = segment_unknown_scale(grid, CONFIG)
    assert estimate.factor * wrong_by == pytest.approx(1.0, rel=0.15)


@pytest.mark.parametrize(
    ('name', 'least_f1'), [('lab_a', 0.55), ('lab_c', 0.65), ('freiburg_building52', 0.75)]
)
def test_robot_maps_agree_with_human_labels(name, least_f1):
    grid = read_grid(BORMANN / 'robot_maps' / f'{name}.png')
    segmentation = segment_submap(submap_from_grid(grid))
    truth = read_labels(BORMANN / 'robot_room_labels' / f'{name}.png')
    assert room_agreement(segmentation.labels, truth).f1 > least_f1


def test_partial_laser_map_has_rooms_doors_and_frontiers():
    grid = read_grid(DATA / 'radish' / 'robot_maps' / 'freiburg-079_part0.png', free_grey=200)
    segmentation = segment_submap(submap_from_grid(grid))
    assert len(segmentation.rooms) >= 5
    assert len(segmentation.portals) >= 4
    assert any(room.frontier_fraction > 0.1 for room in segmentation.rooms)


def test_real_lidar_scans_become_one_large_hall():
    folder = DATA / 'real_hilti_hall_balm'
    scans = np.load(folder / 'scans_xyz_quarter_float16.npz', allow_pickle=False)
    poses = np.loadtxt(folder / 'alidarPose.csv', delimiter=',', usecols=range(4))
    poses = poses.reshape(-1, 4, 4)
    poses[:, 3] = [0.0, 0.0, 0.0, 1.0]
    builder = SubmapBuilder(SubmapConfig())
    for k, name in enumerate(sorted(scans.files)):
        points = scans[name].astype(np.float32)
        builder.add_scan(points[np.isfinite(points).all(axis=1)], poses[k], k * 100_000_000)
    submap = builder.take()
    assert 900.0 < submap.free_area_m2 < 1300.0
    segmentation = segment_submap(submap)
    assert 1 <= len(segmentation.rooms) <= 5
    hall = segmentation.rooms[0]
    assert hall.area_m2 > 800.0
    assert 0.02 < hall.frontier_fraction < 0.6


def test_benchmark_reports_fractions_for_plans_and_robot_maps():
    plans = bench_plans(DATA, 'tune', limit=1)
    assert plans['clean']['f1'] > 0.9
    assert plans['clean']['f1'] > plans['baselines']['morphological']['clean']['f1']
    shares = [v for k, v in plans['furnished'].items() if k != 'seconds_per_map_median']
    assert all(0.0 <= share <= 1.0 for share in shares)
    maps = bench_robot_maps(DATA, limit=2)
    assert maps['maps'] == 2
    assert 0.3 < maps['default']['f1'] <= 1.0
