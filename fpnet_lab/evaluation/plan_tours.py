# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated tours of the building on a floorplan, for ``fpnet check-plan``."""

from __future__ import annotations

from typing import Any

import numpy as np

from fpnet.plan_check import TourResult
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.types import Reading
from fpnet_core.localizer import StoreyPlan, create_localizer
from fpnet_lab.evaluation.first_claims import first_claim
from fpnet_lab.sim.drives.recording import Recording, RecordingOptions, make_recording
from fpnet_lab.sim.lidars.sensors import SENSORS

_SENSOR = 'planar'  # fastest sensor to ray-cast; it observes the walls, which is sufficient here


def drive_tour(reading: Reading, config: FpnetConfig, seed: int) -> TourResult:
    """
    Simulate a robot with a planar scanner and true odometry until it is localized.

    The building is generated from the drawing, up to 4 % larger or smaller than drawn.

    Raises
    ------
    ConfigError
        If there is no feasible tour on the plan.
    """
    options = RecordingOptions(lidar=SENSORS[_SENSOR])
    recording = make_recording(seed, options, threads=1, floorplan=reading.grid)
    localizer = create_localizer(config)
    plan = StoreyPlan('', reading.grid, segmentation=reading.segmented(config.segmentation))
    localizer.set_storeys([plan])
    claim = first_claim(recording, localizer)
    path_m = round(claim.path_m, 2)
    if claim.found_after_m is None or claim.on_plan is None:
        return TourResult(seed, path_m, None, None)
    error_m = _error_m(recording, claim.on_plan, claim.in_building)
    return TourResult(seed, path_m, round(claim.found_after_m, 2), error_m)


def _error_m(recording: Recording, on_plan: Any, truth: Any) -> float:
    found = recording.A_plan_building.inv().apply(on_plan)
    return round(float(np.linalg.norm(found - truth)), 3)
