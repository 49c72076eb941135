# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated robot with true odometry drives until it is localised for the first time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.scans import Scan
from fpnet_core.localizer import Localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import lengths_along
from fpnet_core.types import Status
from fpnet_lab.sim.drives.recording import Recording

Array = NDArray[np.float64]

# Chosen, not measured:
_SCAN_EVERY = 3  # at 10 Hz and 1 m/s, a scan every 0.3 m
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


def true_scans(recording: Recording) -> Iterator[tuple[int, Scan]]:
    """Yield some scans and their numbers, with true odometry from the first pose on."""
    poses = recording.truth()
    T_odom_building = np.linalg.inv(poses[0])
    for index in range(0, len(recording), _SCAN_EVERY):
        scan = recording.scan(index)
        yield index, Scan(scan.stamp_ns, scan.points, T_odom_sensor=T_odom_building @ poses[index])


def first_claim(recording: Recording, localizer: Localizer) -> FirstClaim:
    """Drive a recording with true odometry until its localizer, whose plan is set, claims."""
    truth = recording.truth()[:, :2, 3]
    path_m = lengths_along(truth).tolist()
    tick_every_ns = int(_TICK_EVERY_S * NS_PER_S)
    next_update_ns = int(recording.stamps_ns[0]) + tick_every_ns
    for index, scan in true_scans(recording):
        assert scan.T_odom_sensor is not None, 'this odometry knows it'
        localizer.add_scan(scan.points, scan.T_odom_sensor, scan.stamp_ns)
        if scan.stamp_ns < next_update_ns:
            continue
        next_update_ns = scan.stamp_ns + tick_every_ns
        if localizer.update(scan.stamp_ns).status is Status.LOCALIZED:
            pose = localizer.output.pose(scan.T_odom_sensor)
            assert pose is not None, 'it is localised'
            return FirstClaim(path_m[-1], path_m[index], pose.translation, truth[index])
    return FirstClaim(path_m[-1])
