# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Trials of the placement scorer from recordings: early updates on the correct and on other plans.

Buildings, sensors and inaccurate plans are those of the localization benchmark with other seeds;
scans are registered by KISS-ICP and accumulated in the product's submap. Every update of a
recording, from the first corner of a room on, may cause a wrong acceptance, and plans of other
buildings by the same architect are the hardest to reject.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2
from fpnet_core.io.scans import Scan
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.global_localizer import Candidates, GlobalLocalizer, MatchQuery
from fpnet_core.localizer.prepared_maps import StageTimer, prepare_submap
from fpnet_core.matching import RegionMatcher
from fpnet_core.odometry import KissOdometry
from fpnet_core.scoring import PlacementModel, PlacementScorer
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.stamps import NS_PER_S
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Submap
from fpnet_lab.evaluation.localization.cases import plain_cases
from fpnet_lab.evaluation.localization.inputs import make_inputs, make_plan
from fpnet_lab.evaluation.localization.records import RIGHT, Truth, robot_error
from fpnet_lab.evaluation.localization.runs import settings_of
from fpnet_lab.training.scorer_trials import Trial

DRIVE_S = 40.0
"""Later updates mostly repeat earlier results. Chosen."""

DRIVE_BLOCK = 2
"""Recordings per task; each gives about thirty trials. Chosen."""

PLAIN_DRIVES = 42
"""
Number of buildings of the localization benchmark without symmetry, for one seed. Chosen.
"""

# Chosen, not measured:
_WRONG_PLANS = 3  # other buildings' plans per recording, the first one of its own family
_GROWTH = 1.12  # growth of the free space between two trials
_SCANS_PER_LOOK = 10  # a second of sensor time


class DriveSource:
    """Generates trials from recordings; recording ``index`` of a seed is deterministic."""

    def __init__(self, seed: int, config: FpnetConfig, matcher: RegionMatcher) -> None:
        self._cases = plain_cases(seed)
        self._config = config
        self._matcher = matcher

    def block(self, number: int) -> list[Trial]:
        """Return the trials of :data:`DRIVE_BLOCK` recordings."""
        first = number * DRIVE_BLOCK
        last = min(first + DRIVE_BLOCK, PLAIN_DRIVES)
        return [trial for index in range(first, last) for trial in self.trials(index)]

    def trials(self, index: int) -> Iterator[Trial]:
        """Yield the trials of one recording: updates on the correct plan and on others."""
        case = self._cases[index % len(self._cases)]
        config = settings_of(case, self._config)
        global_localizer = GlobalLocalizer(
            self._matcher, PlacementScorer(PlacementModel.indifferent(), 0.5), config
        )
        inputs = make_inputs(case, Path())
        truth = Truth(inputs.truth, inputs.A_plan_truth)
        own = Floorplan.prepared(inputs.plan, config)
        others = [self._cases[number] for number in case.wrong_cases[:_WRONG_PLANS]]
        foreign = [Floorplan.prepared(make_plan(other), config) for other in others]
        odometry = KissOdometry(config.odometry)
        segmenter = SubmapSegmenter()
        for submap, pose, path in _updates(inputs.scans, odometry, config):
            sub, segmenter = prepare_submap(submap, segmenter, StageTimer())
            robot_xy = submap.T_odom_submap.inv().apply(pose[:2, 3])
            for plan in (own, *foreign):
                search, area_m2 = plan.scale.search.as_stated, submap.free_area_m2
                query = MatchQuery(plan.working, sub, area_m2, search, robot_xy=robot_xy)
                found = global_localizer.find(query, StageTimer())
                if len(found.estimates):
                    right = np.zeros(len(found.estimates), dtype=np.bool_)
                    if plan is own:
                        right = _right(found, plan, submap, path, truth)
                    yield Trial(
                        found.posterior.evidence.figures_only,
                        right,
                        plan is own,
                        'drive',
                        case.name,
                    )


def _updates(
    scans: Iterable[Scan], odometry: KissOdometry, config: FpnetConfig
) -> Iterator[tuple[Submap, NDArray[np.float64], PlanarTrajectory]]:
    """Yield submap, sensor pose and sensor path each time the explored area has grown."""
    builder = SubmapBuilder(config.submap)
    seen_m2 = config.localizer.min_explored_m2 / _GROWTH
    stamps: list[int] = []
    poses: list[NDArray[np.float64]] = []
    for scan in scans:
        sweep = odometry.register_scan(scan)
        pose = sweep.T_odom_sensor
        builder.add_scan(sweep.points, pose, scan.stamp_ns)
        stamps.append(scan.stamp_ns)
        poses.append(pose)
        if scan.stamp_ns - stamps[0] > DRIVE_S * NS_PER_S:
            return
        if len(stamps) % _SCANS_PER_LOOK:
            continue
        submap = builder.take()
        if submap is not None and submap.free_area_m2 >= _GROWTH * seen_m2:
            seen_m2 = submap.free_area_m2
            yield submap, pose, PlanarTrajectory.from_transforms(stamps, np.array(poses))


def _right(
    found: Candidates, plan: Floorplan, submap: Submap, path: PlanarTrajectory, truth: Truth
) -> NDArray[np.bool_]:
    """Return which placements give the right robot pose."""
    T_submap_odom: SE2 = submap.T_odom_submap.inv()
    errors = np.array(
        [
            robot_error(
                submap.stamp_ns,
                plan.to_nominal(placed.A_plan_submap @ T_submap_odom),
                path,
                truth,
            )
            for placed in found.estimates
        ]
    )
    return np.asarray((errors[:, 0] <= RIGHT[0]) & (errors[:, 1] <= RIGHT[1]))
