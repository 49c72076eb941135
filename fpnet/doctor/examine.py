# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""All checks, in the order of the fixes: topics, their clocks, then their contents."""

from __future__ import annotations

from fpnet.doctor.gyro import check_gyro
from fpnet.doctor.lag import check_lag
from fpnet.doctor.motion import check_flips, check_odometry, registered
from fpnet_core.doctor.clocks import check_clocks, check_gaps, check_jumps, check_rate
from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.frames import check_frames, check_tree
from fpnet_core.doctor.observed import Observed
from fpnet_core.doctor.sensor import (
    check_mount,
    check_point_times,
    check_returns,
    check_unit,
)
from fpnet_core.doctor.topics import check_qos, check_time, check_topics

WIRING = (
    check_topics,
    check_time,
    check_qos,
    check_tree,
    check_frames,
    check_jumps,
    check_clocks,
    check_gaps,
    check_rate,
)
"""Fast checks of names, QoS, frames and stamps."""

SCAN_CHECKS = (check_returns, check_unit, check_point_times, check_mount)
"""Checks of single scans."""

_SPOILS = {
    Problem.CLOCK_JUMP,
    Problem.OTHER_CLOCK,
    Problem.SPARSE,
    Problem.UNIT,
    Problem.UPSIDE_DOWN,
    Problem.TILTED,
}


def _of_motion(seen: Observed) -> list[Finding]:
    if not len(seen.track) and not len(seen.gyro_ns):
        return []
    poses = registered(seen)
    found = list(check_flips(seen)) or list(check_odometry(seen, poses))
    # Wrong odometry gives no time offset, and failed scan registration no rotations.
    found = found or list(check_lag(seen, poses))
    lost = any(finding.problem is Problem.REGISTRATION for finding in found)
    return found if lost else [*found, *check_gyro(seen, poses)]


def examine(seen: Observed) -> list[Finding]:
    """Return all findings, in the order in which to fix them."""
    found = [finding for check in (*WIRING, *SCAN_CHECKS) for finding in check(seen)]
    # With these faults, even correct odometry disagrees with the scans.
    if not _SPOILS & {finding.problem for finding in found}:
        found += _of_motion(seen)
    found += [
        Finding(
            Problem.FORMAT,
            seen.scans,
            why,
            'fix the driver, or select another topic',
        )
        for why in dict.fromkeys(seen.unreadable)
    ]
    return found
