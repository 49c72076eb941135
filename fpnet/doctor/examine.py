# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every check, in the order in which one mends: topics, their clocks, then what is in them."""

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
"""Checks that take no time: of names, QoS, frames and stamps."""

SCAN_CHECKS = (check_returns, check_unit, check_point_times, check_mount)
"""Checks of what single scans show."""

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
    # A wrong odometry says nothing of times, and scans that lose their way nothing of turns.
    found = found or list(check_lag(seen, poses))
    lost = any(finding.problem is Problem.REGISTRATION for finding in found)
    return found if lost else [*found, *check_gyro(seen, poses)]


def examine(seen: Observed) -> list[Finding]:
    """Return everything that is wrong, the first thing to mend first."""
    found = [finding for check in (*WIRING, *SCAN_CHECKS) for finding in check(seen)]
    # With these no odometry agrees with the scans, however good.
    if not _SPOILS & {finding.problem for finding in found}:
        found += _of_motion(seen)
    found += [
        Finding(
            Problem.FORMAT,
            seen.scans,
            why,
            'mend the driver, or name another topic',
        )
        for why in dict.fromkeys(seen.unreadable)
    ]
    return found
