# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A run on the planted building, made up without a localizer."""

import numpy as np
from planted import A_BUILDING_PLAN, A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet.report import RunRecord
from fpnet_core.config import load_config
from fpnet_core.geometry import SE2, Placement, Placements
from fpnet_core.matches import MatchResult
from fpnet_core.segmentation import segment_floorplan, segment_submap
from fpnet_core.submaps import submap_from_grid
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput, Status, Submap

SECOND = 1_000_000_000
T_ODOM_SUBMAP = SE2.from_xy_yaw(1.0, -2.0, 0.4)
A_PLAN_ODOM = A_PLAN_SUBMAP @ T_ODOM_SUBMAP.inv()
IN_BUILDING = [(2.0, 3.0), (3.0, 6.0), (8.0, 6.0)]


def _trajectory(xy, stamps_ns, yaw=0.0):
    return PlanarTrajectory(
        np.asarray(stamps_ns, np.int64), np.asarray(xy, float), np.full(len(xy), yaw)
    )


def _output(second, status, submap=None, segmentation=None, match=None, scores=()):
    estimates = Placements.of(Placement(A_PLAN_SUBMAP, s, 0.01 * np.eye(3)) for s in scores)
    return LocalizerOutput(
        second * SECOND,
        status,
        A_PLAN_ODOM if status is Status.LOCALIZED else None,
        probability=0.9 if scores else 0.0,
        estimates=estimates,
        match=match,
        segmentation=segmentation,
        submap=submap,
        reason=f'{len(scores)} placements',
        timings_ms={'segment': 20.0, 'align': 30.0, 'total': 51.0} if scores else {},
    )


@pytest.fixture(scope='session')
def made_up_run():
    """Three ticks: waiting, ambiguous, localised; the truth is 5 cm beside the placements."""
    config = load_config(None, {}).segmentation
    plan = segment_floorplan(plan_grid(), config)
    path = (A_BUILDING_PLAN @ A_PLAN_SUBMAP).inv().apply(IN_BUILDING)
    drawn = submap_from_grid(submap_grid())
    submap = Submap(drawn.grid, drawn.lintel, path, T_ODOM_SUBMAP, 2 * SECOND, 1)
    sub = segment_submap(submap)
    count = min(len(plan.rooms), len(sub.rooms))
    rooms = [(k, k) for k in range(count)]
    doors = [(p.id, s.id) for p, s in zip(plan.doors[:2], sub.doors[:2], strict=True)]
    pairs = np.array(rooms + doors)
    match = MatchResult(
        pairs, np.linspace(1.0, 0.5, len(pairs)), np.zeros((len(plan.regions), len(sub.regions)))
    )
    stamps = [2 * SECOND, 2 * SECOND + SECOND // 10]
    outputs = (
        _output(1, Status.WAITING),
        _output(2, Status.AMBIGUOUS, submap, sub, match, (0.8, 0.7)),
        _output(3, Status.LOCALIZED, submap, sub, match, (0.9, 0.3, 0.2)),
    )
    last = np.asarray(IN_BUILDING[-1])
    published = _trajectory(A_BUILDING_PLAN.inv().apply([last, last]), stamps)
    truth = _trajectory(last + np.array([[0.03, 0.04]] * 2), stamps, yaw=A_BUILDING_PLAN.yaw)
    return RunRecord(
        'a <drive> on a plan',
        'found & kept',
        plan,
        outputs,
        published,
        truth,
        A_BUILDING_PLAN.inv(),
        {'path_to_first_pose_m': 3.25, 'localized': True, 'wrong_poses': None},
    )
