# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""First accepted pose of a simulated robot with true odometry."""

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
    First accepted pose of a recording.

    ``path_m`` is the length of the whole path, ``found_after_m`` that up to the first accepted
    pose, None without one; then ``on_plan (2,)`` is its position in floorplan metres and
    ``in_building (2,)`` the true one.
    """

    path_m: float
    found_after_m: float | None = None
    on_plan: Array | None = None
    in_building: Array | None = None


def true_scans(recording: Recording) -> Iterator[tuple[int, Scan]]:
    """Yield every third scan with its index and true odometry relative to the first pose."""
    poses = recording.truth()
    T_odom_building = np.linalg.inv(poses[0])
    for index in range(0, len(recording), _SCAN_EVERY):
        scan = recording.scan(index)
        yield index, Scan(scan.stamp_ns, scan.points, T_odom_sensor=T_odom_building @ poses[index])


def first_claim(recording: Recording, localizer: Localizer) -> FirstClaim:
    """Replay a recording with true odometry until the localizer, with its plan set, accepts."""
    truth = recording.truth()[:, :2, 3]
    path_m = lengths_along(truth).tolist()
    tick_every_ns = int(_TICK_EVERY_S * NS_PER_S)
    next_update_ns = int(recording.stamps_ns[0]) + tick_every_ns
    for index, scan in true_scans(recording):
        assert scan.T_odom_sensor is not None, 'set by true_scans'
        localizer.add_scan(scan.points, scan.T_odom_sensor, scan.stamp_ns)
        if scan.stamp_ns < next_update_ns:
            continue
        next_update_ns = scan.stamp_ns + tick_every_ns
        if localizer.update(scan.stamp_ns).status is Status.LOCALIZED:
            pose = localizer.output.pose(scan.T_odom_sensor)
            assert pose is not None, 'the status is localized'
            return FirstClaim(path_m[-1], path_m[index], pose.translation, truth[index])
    return FirstClaim(path_m[-1])
