# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated robot with true odometry drives until it is localised for the first time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.localizer import Localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_lab.sim.recording import Recording

Array = NDArray[np.float64]

# Chosen, not measured:
SCAN_EVERY = 3  # at 10 Hz and 1 m/s, a scan every 0.3 m
_TICK_EVERY_S = 2.0


@dataclass(frozen=True, eq=False)
class FirstClaim:
    """
    Where a drive was localised first.

    ``path_m`` is all that there was to drive, ``found_after_m`` the path to the claim, None where
    there was none; then ``on_plan (2,)`` is the claimed place in the floorplan's metres, and
    ``in_building (2,)`` the true one.
    """

    path_m: float
    found_after_m: float | None = None
    on_plan: Array | None = None
    in_building: Array | None = None


def first_claim(recording: Recording, localizer: Localizer) -> FirstClaim:
    """Drive a recording with true odometry until its localizer, whose plan is set, claims."""
    poses, stamps_ns = recording.truth(), recording.stamps_ns
    steps_m = np.linalg.norm(np.diff(poses[:, :2, 3], axis=0), axis=1)
    path_m = np.concatenate([[0.0], np.cumsum(steps_m)])
    T_odom_building = np.linalg.inv(poses[0])
    next_tick_ns = int(stamps_ns[0]) + int(_TICK_EVERY_S * NS_PER_S)
    for index in range(0, len(recording), SCAN_EVERY):
        T_odom_sensor = T_odom_building @ poses[index]
        localizer.add_scan(recording.scan(index).points, T_odom_sensor, int(stamps_ns[index]))
        if stamps_ns[index] < next_tick_ns:
            continue
        next_tick_ns = int(stamps_ns[index]) + int(_TICK_EVERY_S * NS_PER_S)
        if localizer.tick(int(stamps_ns[index])).status is Status.LOCALIZED:
            pose = localizer.output.pose(T_odom_sensor)
            assert pose is not None  # it is localised
            found_m, truth = float(path_m[index]), poses[index, :2, 3]
            return FirstClaim(float(path_m[-1]), found_m, pose.translation, truth)
    return FirstClaim(float(path_m[-1]))
